// What stands before everything: where the model does not describe the data, by how much, and what to do.
import { element } from "./dom.js";
import { typeset } from "./format.js";
import { recalculations, remedyWords } from "./remedies.js";

/** Kinds of verdicts, on the fit and on parameters, with which intervals do not hold. */
const WRONG = new Set(["lack_of_fit", "error_not_met"]);
const SIGNS = { doubtful: "?", gross_error: "!" };

/** Whether intervals do not hold, and what to say beside them; empty where nothing is wrong. */
export function doubt(fit) {
  return fit && WRONG.has(fit.kind) && !fit.tests ? typeset(fit.headline) : "";
}

/**
 * The elements of the alarm of a verdict on the fit of a job; none where nothing is wrong. With a link to its problem, or not.
 * Its `.step` is the place of a next step that would be far below.
 */
export function alarm(fit, job, link = true) {
  if (!fit?.headline) return [];
  const may = document.body.dataset.maySubmit === "true";
  const buttons = fit.what_to_do.map((remedy) => (may ? recalculations(remedy, job) : []));
  const editable = may && (link || buttons.flat().length) && fit.what_to_do.some(({ changes }) => changes.length);
  if (WRONG.has(fit.kind)) buttons.flat()[0]?.querySelector("button").classList.remove("quiet"); // the next step
  return [
    element(
      "section",
      { class: `alarm ${fit.kind}`, role: "alert" },
      element(
        "div",
        {},
        element("h2", {}, `${SIGNS[fit.kind] ?? "≠"} ${typeset(fit.headline)}`),
        element("p", {}, typeset(fit.sentence)),
        element("div", { class: "step" }),
        editable
          ? element("p", {}, element("a", { class: "button quiet", href: `/new?from=${job}` }, "Change the problem"))
          : null,
      ),
      element(
        "div",
        {},
        element("p", {}, element("strong", {}, "What to do:")),
        element(
          "ol",
          {},
          fit.what_to_do.map((remedy, i) => element("li", {}, remedyWords(remedy), buttons[i])),
        ),
      ),
    ),
  ];
}
