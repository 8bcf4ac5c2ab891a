// The figure of one series: measured points, curves of evaluations, and residuals below.
import { direction, number, withUnit } from "../format.js";
import { DASHES, colour, grossErrors, palette } from "../plot.js";

const NAMES = { initial: "first evaluation", best: "best", chosen: "this evaluation" };
const MARKERS = { best: "circle", chosen: "diamond" };

/** Where readings lie when every stage is drawn beside the others, over the logarithm of the time since its load. */
export function stagesOf({ x, breaks }) {
  const starts = breaks.filter((start) => start <= x.at(-1));
  const stage = x.map((value) => starts.findLastIndex((start) => start < value)); // a reading at the load belongs to what was before
  const since = x.map((value, i) => (stage[i] < 0 ? 0 : value - starts[stage[i]]));
  const times = since.filter((time) => time > 0);
  const low = Math.min(...times),
    high = Math.max(...times);
  const used = [...new Set(stage)].filter((one) => one >= 0).sort((a, b) => a - b);
  return {
    long: used.length > 1 && high / low >= 30,
    low,
    high,
    starts: used,
    place: x.map((_, i) =>
      stage[i] < 0 || since[i] <= 0
        ? null
        : used.indexOf(stage[i]) + (0.9 * Math.log(since[i] / low)) / Math.log(high / low),
    ),
    stage,
    since,
  };
}

/** The axis below stages that are drawn beside each other. */
export const stageAxis = (series, { low, high, starts }) => ({
  title: {
    text: `stage, each over log ${series.x_quantity} from ${number(low, 2)} to ${number(high, 2)} ${series.x_unit}`,
  },
  tickvals: starts.map((_, i) => i + 0.45),
  ticktext: starts.map((one) => String(one + 1)),
  range: [-0.1, starts.length],
});

/** A curve with a gap between stages. */
export function broken(places, stage, values) {
  const x = [],
    y = [];
  places.forEach((at, i) => {
    if (at === null) return;
    if (x.length && stage[i] !== stage[i - 1]) {
      x.push(null);
      y.push(null);
    }
    x.push(at);
    y.push(values[i]);
  });
  return { x, y };
}

/** What `plot` draws: `fit` as GET …/fit answers, one of its series; `time`: linear, log or stages; `initial`: whether to show that curve. */
export function fitPlot(fit, name, { time = "linear", initial = true } = {}) {
  const series = fit.series.find((one) => one.series === name);
  const curves = fit.curves.filter(({ role, values }) => values[name] && (role !== "initial" || initial));
  const colours = { initial: colour("--muted"), best: palette()[0], chosen: palette()[1] };
  const [xTitle, yTitle] = [withUnit(series.x_quantity, series.x_unit), withUnit(series.y_quantity, series.y_unit)];
  const left = (curve) => curve.residuals[name],
    leftover = series.distance === "orthogonal" ? "distance" : "residual";
  const main = curves.filter(({ role }) => role !== "initial");
  const down = direction(name, series.y_quantity);
  const struck = series.gross_x.length > 0;
  const stages = time === "stages" ? stagesOf(series) : null;
  const anchors = time === "linear" ? series.breaks.filter((x) => x <= series.x.at(-1)) : [];
  const x = stages ? stages.place : series.x;
  const told = stages
    ? {
        text: series.x.map(
          (value, i) => `stage ${stages.stage[i] + 1}, ${number(stages.since[i])} ${series.x_unit} after its load`,
        ),
        hovertemplate: "%{text}: %{y}<extra></extra>",
      }
    : {};
  const line = (curve) => (stages ? broken(x, stages.stage, curve.values[name]) : { x, y: curve.values[name] });
  const axis = stages
    ? stageAxis(series, stages)
    : {
        title: { text: xTitle },
        type: time === "log" ? "log" : "linear",
        ...(series.x_names.length ? { tickvals: series.x_names.map((_, i) => i + 1), ticktext: series.x_names } : {}),
      };
  return {
    data: [
      {
        type: "scatter",
        mode: "markers",
        name: "measured",
        x,
        y: series.measured,
        marker: { color: colour("--ink"), symbol: "circle-open", size: stages ? 5 : 7 },
        ...told,
      },
      ...curves.map((curve) => ({
        type: "scatter",
        mode: "lines",
        name: NAMES[curve.role],
        ...line(curve),
        line: {
          color: colours[curve.role],
          dash: curve.role === "initial" ? DASHES[2] : DASHES[0],
          width: curve.role === "initial" ? 1.5 : 2,
        },
      })),
      ...(struck && !stages ? [grossErrors(series.gross_x, series.gross_measured)] : []),
      ...main.map((curve) => ({
        type: "scatter",
        mode: "markers",
        name: `${NAMES[curve.role]}: ${leftover}`,
        x,
        y: left(curve),
        yaxis: "y2",
        showlegend: false,
        marker: { color: colours[curve.role], symbol: MARKERS[curve.role], size: 5 },
        ...told,
      })),
    ],
    layout: {
      xaxis: { ...axis, anchor: main.length ? "y2" : "y" },
      yaxis: { title: { text: yTitle }, domain: main.length ? [0.36, 1] : [0, 1], ...down },
      ...(main.length
        ? {
            yaxis2: {
              title: { text: withUnit(leftover, series.y_unit) },
              domain: [0, 0.26],
              zeroline: true,
              zerolinecolor: colour("--edge"),
              ...down,
            },
          }
        : {}),
      shapes: [
        ...anchors.map((at) => ({
          type: "line",
          x0: at,
          x1: at,
          yref: "paper",
          y0: 0,
          y1: 1,
          line: { color: colour("--plot-grid"), width: 1, dash: "dot" },
          layer: "below",
        })),
        ...(stages
          ? stages.starts.slice(1).map((_, i) => ({
              type: "line",
              x0: i + 0.95,
              x1: i + 0.95,
              yref: "paper",
              y0: 0,
              y1: 1,
              line: { color: colour("--plot-grid"), width: 1, dash: "dot" },
              layer: "below",
            }))
          : []),
      ],
      showlegend: true,
      height: 380,
      uirevision: time,
    },
    label: `${name}: ${series.x.length} measured points${curves.length ? ` with ${curves.map(({ role }) => NAMES[role]).join(" and ")}` : ""}, residuals below${stages ? ", every stage over the logarithm of its time" : ""}${struck ? `, and ${series.gross_x.length === 1 ? "one gross error" : `${series.gross_x.length} gross errors`}` : ""}`,
    columns: {
      [xTitle]: series.x,
      [`measured ${yTitle}`]: series.measured,
      ...Object.fromEntries(curves.map((curve) => [NAMES[curve.role], curve.values[name]])),
      ...Object.fromEntries(main.map((curve) => [`${NAMES[curve.role]}: ${leftover}`, left(curve)])),
    },
  };
}
