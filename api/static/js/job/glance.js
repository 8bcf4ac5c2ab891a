// The fit at a glance: all series and the diagrams of the tests as small drawings, without waiting for a library.
import { element, empty, exchange, svg } from "../dom.js";
import { amount, direction, number, partOf, plain, withUnit } from "../format.js";
import { get } from "../http.js";
import { ENDED } from "../states.js";
import { thinned, ticks } from "../scales.js";
import { headingOf } from "./diagrams.js";
import { broken, stagesOf } from "./fit_plot.js";
import { unitChoices } from "./readings.js";

const MOST = 300,
  HEIGHT = 430,
  LARGEST = 540,
  LEAST = 90,
  GAP = 4,
  LEGEND = 36,
  BELOW = 24,
  BESIDE = 992,
  CAPTION = 36,
  LETTER = 6.2,
  RIGHT = 8,
  TOP = 6,
  BOTTOM = 34; // px
const ABOVE = ["attachments", "live", "alarm", "outcome", "warnings", "answer"]; // what moves the fit down when it comes

/** "cell 50: volumetric strain": the test, where there are several, and what was measured. */
const headed = (series) => plain(series.replace(".", ": "));

/** Those of one test beside each other, in the order of the tests. */
function byTest(all) {
  const tests = [...new Set(all.map(({ test }) => test))];
  return all.sort((a, b) => tests.indexOf(a.test) - tests.indexOf(b.test));
}

/** What one series of a fit shows: {title, note, x, y, line, first, gross, ...}; places where a line breaks are null. */
function ofSeries(fit, one) {
  const values = (role) => fit.curves.find((curve) => curve.role === role)?.values[one.series] ?? null;
  const best = fit.curves.find(({ role }) => role === "best");
  const share = best?.shares.find(({ series }) => series === one.series);
  const stages = stagesOf(one);
  const x = stages.long ? stages.place : one.x;
  const line = (y) => y && (stages.long ? broken(x, stages.stage, y) : { x, y });
  return {
    test: partOf(one.series),
    title: headed(one.series),
    x,
    y: one.measured,
    line: line(values("best")),
    first: line(values("initial")),
    note: share
      ? [element("abbr", { title: "root mean square" }, "RMS"), ` ${amount(share.root_mean_square, share.unit)}`]
      : null,
    gross: stages.long ? null : { x: one.gross_x, y: one.gross_measured },
    down: "autorange" in direction(one.series, one.y_quantity),
    log: false,
    across: stages.long ? "stage, each over log time" : withUnit(one.x_quantity, one.x_unit),
    up: plain(one.series).includes(one.y_quantity)
      ? withUnit("", one.y_unit).trim()
      : withUnit(one.y_quantity, one.y_unit),
    marks: stages.long
      ? stages.starts.map((_, i) => [i + 0.45, String(i + 1)])
      : one.x_names.length
        ? one.x_names.map((name, i) => [i + 1, name])
        : null,
  };
}

/** The same of a diagram of a test. */
function ofDiagram(one) {
  return {
    test: one.test || "",
    title: plain(headingOf(one)),
    x: one.measured_x,
    y: one.measured_y,
    line: { x: one.x, y: one.y },
    first: null,
    note: null,
    gross: null,
    down: one.downwards,
    log: one.log,
    across: withUnit(one.x_quantity, one.x_unit),
    up: withUnit(one.y_quantity, one.y_unit),
    marks: null,
  };
}

function extent(lists) {
  let low = Infinity,
    high = -Infinity;
  for (const list of lists)
    for (const value of list ?? [])
      if (Number.isFinite(value) && value !== null) {
        low = Math.min(low, value);
        high = Math.max(high, value);
      }
  return low > high ? [0, 1] : low === high ? [low - (Math.abs(low) || 1), high + (Math.abs(high) || 1)] : [low, high];
}

/** A drawing of this size, in pixels. */
function drawing(one, width, height) {
  const scaled = (value) => (value === null ? null : one.log ? (value > 0 ? Math.log10(value) : null) : value);
  const [x0, x1] = extent([one.x, one.line?.x, one.gross?.x].map((list) => list?.map(scaled)));
  const [y0, y1] = extent([one.y, one.line?.y, one.gross?.y]);
  const named = (values) => values.map((value) => [value, number(value, 6)]);
  const ys = named(ticks(y0, y1, "linear", Math.max(2, Math.floor(height / 40))));
  const left = Math.round(24 + LETTER * Math.max(...ys.map(([, text]) => text.length), 2));
  const title = LETTER * one.up.length > height - BOTTOM ? one.up.slice(Math.max(one.up.lastIndexOf("["), 0)) : one.up;
  const [dx, dy] = [0.03 * (x1 - x0), 0.06 * (y1 - y0)];
  const across = (x) => left + ((scaled(x) - x0 + dx) / (x1 - x0 + 2 * dx)) * (width - left - RIGHT);
  const up = (y) => {
    const share = (y - y0 + dy) / (y1 - y0 + 2 * dy);
    return TOP + (one.down ? share : 1 - share) * (height - TOP - BOTTOM);
  };
  const fits = Math.max(2, Math.floor((width - left) / 55));
  const every = one.marks ? Math.ceil(one.marks.length / Math.max(4, Math.floor((width - left) / 22))) : 1;
  const xs =
    one.marks?.filter((_, i) => i % every === 0) ??
    named(one.log ? ticks(10 ** x0, 10 ** x1, "log", fits) : ticks(x0, x1, "linear", fits));
  const point = (x, y) =>
    x === null || y === null || !Number.isFinite(scaled(x)) || scaled(x) === null
      ? null
      : [across(x).toFixed(1), up(y).toFixed(1)];
  const path = ({ x, y }) => {
    let pen = "M";
    return x
      .map((value, i) => {
        const at = point(value, y[i]);
        const step = at ? `${pen}${at[0]} ${at[1]}` : "";
        pen = at ? "L" : "M";
        return step;
      })
      .join("");
  };
  const dots = thinned(one.x.map((x, i) => point(x, one.y[i])).filter(Boolean), MOST);
  const bottom = height - BOTTOM;
  return svg(
    "svg",
    {
      viewBox: `0 0 ${width} ${height}`,
      width,
      height,
      role: "img",
      "aria-label": `${one.title}: ${one.x.length} measured points${one.line ? " and the best evaluation" : ""}; ${one.up} over ${one.across}${one.down ? ", downwards" : ""}`,
    },
    xs.map(([at, text]) => [
      svg("line", { class: "grid", x1: across(at), x2: across(at), y1: TOP, y2: bottom }),
      svg("text", { x: across(at), y: bottom + 14, "text-anchor": "middle" }, text),
    ]),
    ys.map(([at, text]) => [
      svg("line", { class: "grid", x1: left, x2: width - RIGHT, y1: up(at), y2: up(at) }),
      svg("text", { x: left - 5, y: up(at) + 4, "text-anchor": "end" }, text),
    ]),
    svg("path", { class: "frame", d: `M${left} ${TOP}V${bottom}H${width - RIGHT}` }),
    svg("text", { x: (left + width - RIGHT) / 2, y: height - 5, "text-anchor": "middle" }, one.across),
    svg("text", { transform: `translate(10 ${(TOP + bottom) / 2}) rotate(-90)`, "text-anchor": "middle" }, title),
    one.first ? svg("path", { class: "first", d: path(clipped(one.first, y0, y1)) }) : null,
    dots.map(([cx, cy]) => svg("circle", { class: "measured", cx, cy, r: 2.2 })),
    one.line ? svg("path", { class: "best", d: path(one.line) }) : null,
    one.gross?.x
      .map((x, i) => point(x, one.gross.y[i]))
      .filter(Boolean)
      .map(([cx, cy]) => svg("path", { class: "gross", d: `M${cx - 4} ${cy - 4}l8 8m0-8l-8 8` })),
  );
}

/** The first evaluation is far off: what of it lies outside the drawing is left out. */
function clipped({ x, y }, low, high) {
  return { x, y: y.map((value) => (value < low || value > high ? null : value)) };
}

export function glance(view) {
  const place = document.getElementById("fit");
  let diagrams = [],
    asked = null,
    width = 0,
    top = 0;

  const topNow = () => place.getBoundingClientRect().top + scrollY;

  /** Pixels for all drawings: beside the parameters, they end with the window. */
  function room() {
    if (innerWidth < BESIDE) return HEIGHT;
    return Math.min(Math.max(innerHeight - top - LEGEND - BELOW, HEIGHT / 2), LARGEST);
  }

  async function more() {
    if (!ENDED.has(view.job.state) || view.job.objective === null || asked === view.job.objective) return;
    asked = view.job.objective;
    try {
      ({ items: diagrams } = await get(`/jobs/${view.id}/diagrams`));
    } catch (error) {
      if (error.status === 0 || error.status === 404) return; // the stream reports it
      diagrams = [];
    }
    draw();
  }

  function draw() {
    if (!view.fit) return;
    const all = byTest([...view.fit.series.map((one) => ofSeries(view.fit, one)), ...diagrams.map(ofDiagram)]);
    const best = view.fit.curves.some(({ role }) => role === "best");
    width = place.clientWidth;
    top = topNow();
    const columns =
      width < 480 ? (all.length > 2 ? 2 : 1) : all.length < 2 ? 1 : all.length < 5 ? 2 : all.length < 10 ? 3 : 4;
    const rows = Math.ceil(all.length / columns);
    const wide = Math.max(130, Math.floor((width - 8 * (columns - 1)) / columns));
    const most = (room() - GAP * (rows - 1)) / rows - CAPTION;
    const high = Math.floor(Math.min(Math.max(most, LEAST), Math.max(0.95 * wide, LEAST)));
    exchange(
      place,
      element(
        "p",
        { class: "legend" },
        element("span", { class: "key measured" }, "measured"),
        best
          ? [
              element("span", { class: "key best" }, "best"),
              element("span", { class: "key first" }, "first evaluation"),
            ]
          : null,
        unitChoices(view),
      ),
      best
        ? null
        : element(
            "p",
            { class: "help" },
            `Measured points only: no evaluation has succeeded${ENDED.has(view.job.state) ? "" : " yet"}.`,
          ),
      element(
        "div",
        { class: "multiples", style: { "grid-template-columns": `repeat(${columns}, minmax(0, 1fr))` } },
        all.map((one) =>
          element(
            "figure",
            {},
            element(
              "figcaption",
              {},
              element("strong", { title: one.title }, one.title),
              one.note ? element("span", {}, one.note) : null,
            ),
            drawing(one, wide, high),
          ),
        ),
      ),
    );
  }

  addEventListener("resize", () => {
    if (Math.abs(place.clientWidth - width) > 20) draw();
  });
  const moved = new ResizeObserver(() => {
    if (innerWidth >= BESIDE && Math.abs(topNow() - top) > 4) draw();
  });
  for (const id of ABOVE) moved.observe(document.getElementById(id));
  place.replaceChildren(empty("Loading …"));
  return {
    job: more,
    fit() {
      draw();
      more();
    },
  };
}
