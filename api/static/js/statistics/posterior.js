// The posterior of the parameters: sampled on request through a response surface of the stored evaluations.
import { element, exchange, failure, once, tableHead, wide } from "../dom.js";
import { count, ends, number, percent, symbol, typeset } from "../format.js";
import { get } from "../http.js";

/** A button that samples the posterior of a job, and what it gives. `units`: by parameter. */
export function posterior(job, units) {
  const result = element("div", { role: "status" });
  const button = element(
    "button",
    { type: "button", class: "quiet", onclick: () => once(button, sample) },
    "Sample the posterior",
  );

  async function sample() {
    exchange(result, element("p", { class: "help" }, "Sampling …"));
    try {
      exchange(result, shown(await get(`/jobs/${job}/posterior`)));
    } catch (error) {
      exchange(result, failure(error));
    }
  }

  function shown({ level, medians, intervals, samples, effective, trusted, warnings }) {
    const rows = Object.entries(medians).map(([name, median]) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, `${symbol(name)}${units[name] === "-" ? "" : ` [${units[name]}]`}`),
        element("td", { class: "n" }, number(median)),
        element("td", {}, intervals[name] ? ends(...intervals[name]) : "–"),
      ),
    );
    return [
      trusted ? null : element("p", { class: "error" }, "Do not rely on these intervals:"),
      element(
        "ul",
        { class: "notes" },
        warnings.map((text) => element("li", {}, `${text[0].toUpperCase()}${typeset(text.slice(1))}.`)),
      ),
      wide(
        "Posterior",
        element(
          "table",
          {},
          tableHead(["Parameter", "Median", `${percent(level)} interval`], (i) => i === 1),
          element("tbody", {}, rows),
        ),
      ),
      element("p", { class: "help" }, `${count(samples)} samples, equivalent to ${count(effective)} independent ones.`),
    ];
  }

  return element(
    "section",
    { "aria-labelledby": "posterior-title" },
    element("h3", { id: "posterior-title" }, "How are the parameters distributed?"),
    element(
      "p",
      { class: "help" },
      "From the stored evaluations, through a response surface: no further runs, but some seconds of calculation.",
    ),
    element("div", { class: "buttons" }, button),
    result,
  );
}
