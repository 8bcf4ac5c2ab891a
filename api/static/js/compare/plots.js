// Convergence and fits of several jobs, a colour and a dash each.
import { element, empty } from "../dom.js";
import { direction, withUnit } from "../format.js";
import { DASHES, SYMBOLS, colour, palette, plot } from "../plot.js";
import { broken, stageAxis, stagesOf } from "../job/fit_plot.js";
import { inUnits } from "../units.js";
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

/** One plot a series, in the units of the first job: measured points, and the best evaluation of every job that has it. */
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
  const first = loaded.flatMap(({ fit }) => fit.series).find(({ series }) => series === name);
  const fits = loaded.map(({ fit }) => inUnits(fit, first)); // null without the series, or in other quantities
  const series = fits.map((fit) => fit?.series.find((one) => one.series === name));
  const stages = series.map((one) => one && stagesOf(one));
  const long = stages.every((one) => !one || one.long) && same(series.filter(Boolean).map(({ breaks }) => breaks));
  const curve = (i, y) => (long ? broken(stages[i].place, stages[i].stage, y) : { x: series[i].x, y });
  const points = new Map(); // jobs of one data set share their points
  series.forEach((one, i) => {
    if (one) points.set(JSON.stringify([one.x, one.measured]), { x: long ? stages[i].place : one.x, y: one.measured });
  });
  const measured = [...points.values()].map((one, i) => ({
    type: "scatter",
    mode: "markers",
    name: points.size > 1 ? `measured ${i + 1}` : "measured",
    ...one,
    marker: { color: colour("--ink"), symbol: `${SYMBOLS[i]}-open`, size: long ? 5 : 7 },
  }));
  const drawn = loaded.flatMap(({ job }, i) => {
    const best = fits[i]?.curves.find(({ role }) => role === "best")?.values[name];
    return best ? [{ i, name: job.name, best }] : [];
  });
  const left = loaded.filter((_, i) => loaded[i].fit.series.some((one) => one.series === name) && !fits[i]);
  return {
    data: [
      ...measured,
      ...drawn.map(({ i, name: job, best }) => ({
        type: "scatter",
        mode: "lines",
        name: job,
        ...curve(i, best),
        line: { dash: DASHES[i], color: palette()[i], width: 2 },
      })),
    ],
    layout: {
      xaxis: long
        ? stageAxis(first, stages.find(Boolean))
        : { title: { text: withUnit(first.x_quantity, first.x_unit) } },
      yaxis: { title: { text: withUnit(first.y_quantity, first.y_unit) }, ...direction(name, first.y_quantity) },
      showlegend: true,
      height: 360,
    },
    label: `${name}: measured points and the best evaluation of ${drawn.length} jobs${long ? ", every stage over the logarithm of its time" : ""}${left.length ? `; not of ${left.map(({ job }) => job.name).join(", ")}, with another unit` : ""}`,
    columns: {
      [withUnit(first.x_quantity, first.x_unit)]: first.x,
      measured: first.measured,
      ...Object.fromEntries(drawn.map(({ i, name: job, best }) => [`${job} (${i + 1})`, best])),
    },
  };
}

const same = (lists) =>
  new Set(lists.map((list) => JSON.stringify(list.map((value) => Number(value.toPrecision(9)))))).size < 2;
