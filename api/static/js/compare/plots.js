// Convergence and fits of several jobs, a colour and a dash each.
import { element, empty } from "../dom.js";
import { direction, withUnit } from "../format.js";
import { DASHES, SYMBOLS, colour, palette, plot } from "../plot.js";
import { common } from "./tables.js";

/** Lowest objective so far of every job; returns a function that draws what was loaded. */
export function drawConvergences(place) {
  let loaded = [];
  const made = plot(place, () => {
    const unit = common(loaded.map(({ fit }) => fit.objective_unit)) ?? "";
    const courses = loaded.map(({ course }) => course.filter(({ objective }) => objective > 0));
    return {
      data: loaded.map(({ job }, i) => ({
        type: "scatter",
        mode: "lines",
        name: job.name,
        x: courses[i].map(({ evaluations }) => evaluations),
        y: courses[i].map(({ objective }) => objective),
        line: { shape: "hv", dash: DASHES[i], color: palette()[i] },
      })),
      layout: {
        xaxis: { title: { text: "evaluations" }, rangemode: "tozero" },
        yaxis: { title: { text: withUnit("best objective", unit) }, type: "log" },
        showlegend: true,
        height: 380,
      },
      label: `Lowest objective over evaluations of ${loaded.length} jobs, logarithmic`,
      columns: Object.fromEntries(
        loaded.flatMap(({ job }, i) => [
          [`${job.name} (${i + 1}): evaluations`, courses[i].map(({ evaluations }) => evaluations)],
          [`${job.name} (${i + 1}): best objective`, courses[i].map(({ objective }) => objective)],
        ]),
      ),
    };
  });
  return (now) => {
    loaded = now;
    return made.draw();
  };
}

/** One plot a series: measured points, and the best evaluation of every job that has it in the same units. */
export function drawFits(place) {
  const plots = new Map();
  return async (loaded) => {
    const names = [...new Set(loaded.flatMap(({ fit }) => fit.series.map(({ series }) => series)))];
    const drawable = loaded.some(({ fit }) => fit.curves.some(({ role }) => role === "best"));
    if (!drawable) return void place.replaceChildren(empty("No job has a successful evaluation yet."));
    if (!place.querySelector(".panels")) place.replaceChildren(element("div", { class: "panels" }));
    await Promise.all(
      names.map((name) => {
        if (!plots.has(name)) {
          const frame = element("div", {});
          place.firstElementChild.append(element("section", { class: "panel" }, element("h3", {}, name), frame));
          const entry = { loaded: [] };
          entry.plot = plot(frame, () => fitOf(name, entry.loaded));
          plots.set(name, entry);
        }
        plots.get(name).loaded = loaded;
        return plots.get(name).plot.draw();
      }),
    );
  };
}

function fitOf(name, loaded) {
  const series = loaded.map(({ fit }) => fit.series.find((one) => one.series === name));
  const first = series.find(Boolean);
  const matching = series.map((one) => one && one.x_unit === first.x_unit && one.y_unit === first.y_unit);
  const points = new Map(); // jobs of one data set share their points
  series.forEach((one, i) => {
    if (matching[i]) points.set(JSON.stringify([one.x, one.measured]), one);
  });
  const measured = [...points.values()].map((one, i) => ({
    type: "scatter",
    mode: "markers",
    name: points.size > 1 ? `measured ${i + 1}` : "measured",
    x: one.x,
    y: one.measured,
    marker: { color: colour("--ink"), symbol: `${SYMBOLS[i]}-open`, size: 7 },
  }));
  const curves = loaded.flatMap(({ job, fit }, i) => {
    const best = fit.curves.find(({ role }) => role === "best")?.values[name];
    if (!best || !matching[i]) return [];
    return [
      {
        type: "scatter",
        mode: "lines",
        name: job.name,
        x: series[i].x,
        y: best,
        line: { dash: DASHES[i], color: palette()[i], width: 2 },
      },
    ];
  });
  return {
    data: [...measured, ...curves],
    layout: {
      xaxis: { title: { text: withUnit(first.x_quantity, first.x_unit) } },
      yaxis: { title: { text: withUnit(first.y_quantity, first.y_unit) }, ...direction(name, first.y_quantity) },
      showlegend: true,
      height: 360,
    },
    label: `${name}: measured points and the best evaluation of ${curves.length} jobs`,
    columns: {
      [withUnit(first.x_quantity, first.x_unit)]: first.x,
      measured: first.measured,
      ...Object.fromEntries(curves.map((curve, i) => [`${curve.name} (${i + 1})`, curve.y])),
    },
  };
}
