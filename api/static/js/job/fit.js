// Measured points with the first and the best evaluation, and what is left over, one plot a series.
import { element, empty, failure } from "../dom.js";
import { get } from "../http.js";
import { paced } from "../pace.js";
import { plot } from "../plot.js";
import { choices, choose as chooseUnit, converted } from "../units.js";
import { fitPlot, stagesOf } from "./fit_plot.js";

const INTERVAL = 2500, PANELS = 4;

export function fit(view) {
  const place = document.getElementById("fit");
  const options = { time: null, series: null, initial: true };
  let plots = [], shape = "", objective, raw = null;

  function controls(series) {
    const many = series.length > PANELS;
    options.series ??= many ? series[0].series : null;
    const staged = series.some((one) => one.breaks.length > 1);
    options.time ??= series.some((one) => stagesOf(one).long) ? "stages" : "linear";
    const kinds = [["linear", "as measured"], ["log", "logarithmic"], ...(staged ? [["stages", "each stage, logarithmic"]] : [])];
    const time = element("select", { onchange: ({ target }) => { options.time = target.value; draw(); } }, kinds.map(([value, words]) => element("option", { value, selected: value === options.time }, words)));
    const initial = element("input", { type: "checkbox", checked: true, onchange: ({ target }) => { options.initial = target.checked; draw(); } });
    const choose = element("select", { onchange: ({ target }) => { options.series = target.value; build(); draw(); } }, series.map((one) => element("option", {}, one.series)));
    return element("div", { class: "controls" },
      many ? element("label", {}, "Series", choose) : null,
      element("label", { class: "beside" }, initial, "first evaluation"),
      element("label", { class: "beside" }, "Across", time),
      choices(raw).map(({ family, name, units, chosen }) => element("label", { class: "beside" }, name,
        element("select", { onchange: ({ target }) => { chooseUnit(family, target.value || null); view.fit = converted(raw); view.changed(); draw(); } },
          element("option", { value: "" }, "as given"), units.map((unit) => element("option", { selected: unit === chosen }, unit))))));
  }

  function build() {
    const { series } = view.fit;
    const chosen = options.series ? series.filter((one) => one.series === options.series) : series;
    plots.forEach(({ remove }) => remove());
    const panels = chosen.map((one) => [one, element("div", {})]);
    plots = panels.map(([one, frame]) => plot(frame, () => fitPlot(view.fit, one.series, { ...options, time: options.time === "stages" && one.breaks.length < 2 ? "linear" : options.time })));
    place.querySelector(".panels").replaceChildren(...panels.map(([one, frame]) => element("div", {}, series.length > 1 ? element("h3", {}, one.series) : null, frame)));
  }

  const draw = () => Promise.all(plots.map((one) => one.draw()));

  const load = paced(async () => {
    try {
      if (view.fit === null || objective !== view.job.objective) {
        const wanted = view.job.objective;
        raw = await get(`/jobs/${view.id}/fit`);
        view.fit = converted(raw);
        objective = wanted;
        view.changed();
      }
      const now = view.fit.series.map((one) => one.series).join("\n");
      if (now !== shape) {
        shape = now;
        place.replaceChildren(
          element("p", { class: "help", id: "fit-state" }), controls(view.fit.series), element("div", { class: "panels" }));
        build();
      }
      place.querySelector("#fit-state").textContent = view.fit.curves.some(({ role }) => role === "best")
        ? "" : "Measured points only: no evaluation has succeeded yet.";
      await draw();
    } catch (error) {
      if (view.fit === null) place.replaceChildren(failure(error));
    }
  }, INTERVAL);

  place.replaceChildren(empty("Loading …"));
  return {
    job: load,
    generation({ objective: best }) { if (best !== objective) load(); },
  };
}
