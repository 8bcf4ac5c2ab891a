// What stands before everything: where the model does not describe the data, by how much, and what to do.
import { withButtons } from "./costs.js";
import { element } from "./dom.js";

/** Kinds of verdicts, on the fit and on parameters, with which intervals do not hold. */
export const WRONG = new Set(["lack_of_fit", "error_not_met"]);
const SIGNS = { doubtful: "?", gross_error: "!" };

/** Whether intervals do not hold, and what to say beside them; empty where nothing is wrong. */
export function doubt(fit) {
  return fit && WRONG.has(fit.kind) ? fit.headline : "";
}

/** The elements of the alarm of a verdict on the fit; none where nothing is wrong. */
export function alarm(fit) {
  if (!fit?.headline) return [];
  return [element("section", { class: "alarm", role: "alert" }, element("h2", {}, `${SIGNS[fit.kind] ?? "≠"} ${fit.headline}`), element("p", {}, withButtons(fit.sentence)),
    element("p", {}, element("strong", {}, "What to do:")), element("ol", {}, fit.remedies.map((text) => element("li", {}, text))))];
}
