// The figure of one series: measured points, curves of evaluations, and residuals below.
import { withUnit } from "../format.js";
import { DASHES, colour, grossErrors, palette } from "../plot.js";

const NAMES = { initial: "first evaluation", best: "best", chosen: "this evaluation" };
const MARKERS = { best: "circle", chosen: "diamond" };

/** What `plot` draws: `fit` as GET …/fit answers, one of its series, and `log` and `initial`, what to show. */
export function fitPlot(fit, name, { log = false, initial = true } = {}) {
  const series = fit.series.find((one) => one.series === name);
  const curves = fit.curves.filter(({ role, values }) => values[name] && (role !== "initial" || initial));
  const colours = { initial: colour("--muted"), best: palette()[0], chosen: palette()[1] };
  const [xTitle, yTitle] = [withUnit(series.x_quantity, series.x_unit), withUnit(series.y_quantity, series.y_unit)];
  const left = (curve) => curve.values[name].map((value, i) => (value === null ? null : value - series.measured[i]));
  const main = curves.filter(({ role }) => role !== "initial");
  const struck = series.gross_x.length > 0;
  const anchors = log ? [] : series.breaks.filter((x) => x <= series.x.at(-1));
  return {
    data: [
      { type: "scatter", mode: "markers", name: "measured", x: series.x, y: series.measured, marker: { color: colour("--ink"), symbol: "circle-open", size: 7 } },
      ...curves.map((curve) => ({
        type: "scatter", mode: "lines", name: NAMES[curve.role], x: series.x, y: curve.values[name],
        line: { color: colours[curve.role], dash: curve.role === "initial" ? DASHES[2] : DASHES[0], width: curve.role === "initial" ? 1.5 : 2 },
      })),
      ...(struck ? [grossErrors(series.gross_x, series.gross_measured)] : []),
      ...main.map((curve) => ({
        type: "scatter", mode: "markers", name: `${NAMES[curve.role]} − measured`, x: series.x, y: left(curve), yaxis: "y2", showlegend: false,
        marker: { color: colours[curve.role], symbol: MARKERS[curve.role], size: 5 },
      })),
    ],
    layout: {
      xaxis: { title: { text: xTitle }, type: log ? "log" : "linear", anchor: main.length ? "y2" : "y" },
      yaxis: { title: { text: yTitle }, domain: main.length ? [0.34, 1] : [0, 1] },
      ...(main.length ? { yaxis2: { title: { text: withUnit("residual", series.y_unit) }, domain: [0, 0.24], zeroline: true, zerolinecolor: colour("--edge") } } : {}),
      shapes: anchors.map((x) => ({ type: "line", x0: x, x1: x, yref: "paper", y0: 0, y1: 1, line: { color: colour("--plot-grid"), width: 1, dash: "dot" }, layer: "below" })),
      showlegend: true, height: 440, uirevision: log ? "log" : "linear",
    },
    label: `${name}: ${series.x.length} measured points${curves.length ? ` with ${curves.map(({ role }) => NAMES[role]).join(" and ")}` : ""}, residuals below${struck ? `, and ${series.gross_x.length === 1 ? "one gross error" : `${series.gross_x.length} gross errors`}` : ""}`,
    columns: {
      [xTitle]: series.x, [`measured ${yTitle}`]: series.measured,
      ...Object.fromEntries(curves.map((curve) => [NAMES[curve.role], curve.values[name]])),
      ...Object.fromEntries(main.map((curve) => [`${NAMES[curve.role]}: residual`, left(curve)])),
    },
  };
}
