// Measured points with the first and the best evaluation, and what is left over, one plot a series; each drawn when it is seen.
import { element, empty, exchange } from "../dom.js";
import { amount, plain } from "../format.js";
import { paced } from "../pace.js";
import { plot } from "../plot.js";
import { ENDED } from "../states.js";
import { fitPlot, stagesOf } from "./fit_plot.js";
import { unitChoices } from "./readings.js";

export function fit(view) {
  const place = document.getElementById("fit");
  const options = { time: null, initial: true };
  let plots = [],
    shape = "";

  function controls(series) {
    const staged = series.some((one) => one.breaks.length > 1);
    options.time ??= series.some((one) => stagesOf(one).long) ? "stages" : "linear";
    const kinds = [
      ["linear", "as measured"],
      ["log", "logarithmic"],
      ...(staged ? [["stages", "each stage, logarithmic"]] : []),
    ];
    const time = element(
      "select",
      {
        onchange: ({ target }) => {
          options.time = target.value;
          draw();
        },
      },
      kinds.map(([value, words]) => element("option", { value, selected: value === options.time }, words)),
    );
    const initial = element("input", {
      type: "checkbox",
      checked: options.initial,
      onchange: ({ target }) => {
        options.initial = target.checked;
        draw();
      },
    });
    return [
      element("label", { class: "beside" }, initial, "first evaluation"),
      element("label", { class: "beside" }, "Across", time),
      unitChoices(view),
    ];
  }

  function build(series) {
    plots.forEach(({ remove }) => remove());
    const heads = series.map((one) => element("h3", {}, plain(one.series)));
    const frames = series.map(() => element("div", {}));
    place.replaceChildren(
      element("p", { class: "help", id: "fit-state" }),
      element("div", { class: "controls" }),
      element(
        "div",
        { class: "panels" },
        frames.map((frame, i) => element("div", {}, heads[i], frame)),
      ),
    );
    plots = series.map(({ series: name, breaks }, i) => {
      const { draw: drawn, remove } = plot(frames[i], () =>
        fitPlot(view.fit, name, {
          ...options,
          time: options.time === "stages" && breaks.length < 2 ? "linear" : options.time,
        }),
      );
      return { draw: paced(drawn, 100, frames[i]), remove, head: heads[i] };
    });
  }

  function draw() {
    const best = view.fit.curves.find(({ role }) => role === "best");
    view.fit.series.forEach(({ series }, i) => {
      const share = best?.shares.find((one) => one.series === series);
      plots[i].head.replaceChildren(
        plain(series),
        share ? element("small", {}, ` ${amount(share.root_mean_square, share.unit)} root mean square`) : "",
      );
      plots[i].draw();
    });
    place.querySelector("#fit-state").textContent = best
      ? ""
      : `Measured points only: no evaluation has succeeded${ENDED.has(view.job.state) ? "" : " yet"}.`;
  }

  place.replaceChildren(empty("Loading …"));
  return {
    fit() {
      const { series } = view.fit;
      const now = series.map((one) => one.series).join("\n");
      if (now !== shape) {
        shape = now;
        build(series);
      }
      exchange(place.querySelector(".controls"), controls(series));
      draw();
    },
  };
}
