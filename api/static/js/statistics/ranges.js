// The ranges that were drawn in the matrix plot, as numbers: for the keyboard and for exact limits.
import { element } from "../dom.js";
import { natural, place } from "./cloud.js";

/** Fills `holder` with two numbers a parameter; `onRanges()` after a change of the ranges of the cloud that `present()` returns. */
export function rangeForm(holder, present, onRanges) {
  const rows = present().parameters.map((parameter, index) => {
    const unit = parameter.unit === "-" ? "" : ` [${parameter.unit}]`;
    const field = (which) =>
      element("input", {
        type: "number",
        step: "any",
        "aria-label": `${parameter.symbol}${unit}, ${which}`,
        placeholder: String(which === "at least" ? parameter.lower : parameter.upper),
        onchange: read,
      });
    const [low, high] = [field("at least"), field("at most")];
    function read() {
      if (low.value === "" && high.value === "") present().limit(index, null);
      else {
        const ends = [
          low.value === "" ? parameter.lower : Number(low.value),
          high.value === "" ? parameter.upper : Number(high.value),
        ];
        present().limit(
          index,
          ends.map((value) => Math.max(0, Math.min(1, place(parameter, value) || 0))).sort((a, b) => a - b),
        );
      }
      onRanges();
    }
    const clear = element(
      "button",
      {
        type: "button",
        class: "quiet small",
        "aria-label": `Any ${parameter.symbol}`,
        onclick: () => {
          present().limit(index, null);
          onRanges();
        },
      },
      "Any",
    );
    return {
      index,
      parameter,
      low,
      high,
      cells: [element("span", {}, `${parameter.symbol}${unit}`), low, high, clear],
    };
  });
  const all = element(
    "button",
    {
      type: "button",
      class: "quiet small",
      onclick: () => {
        present().ranges.clear();
        onRanges();
      },
    },
    "Remove all ranges",
  );
  const help = element(
    "p",
    { class: "help" },
    "Draw a rectangle in a cell to select its evaluations in every cell and in the fit; click to remove it. Or give limits here:",
  );
  const form = element(
    "details",
    {},
    element("summary", {}, "Ranges of the parameters"),
    help,
    element(
      "div",
      { class: "grid-form" },
      rows.map(({ cells }) => cells),
    ),
  );
  const row = element("p", { class: "buttons" }, all);
  holder.replaceChildren(form, row);

  function show() {
    const cloud = present();
    row.hidden = cloud.ranges.size === 0;
    for (const { index, parameter, low, high } of rows) {
      const range = cloud.ranges.get(index);
      const text = (unit) => String(Number(natural(parameter, unit).toPrecision(5)));
      if (document.activeElement !== low) low.value = range ? text(range[0]) : "";
      if (document.activeElement !== high) high.value = range ? text(range[1]) : "";
    }
  }
  show();
  return { show };
}
