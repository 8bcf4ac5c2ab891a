// Why a job failed, in one step, with the first failed evaluation at hand.
import { announce, element } from "../dom.js";
import { typeset } from "../format.js";
import { get } from "../http.js";
import { openEvaluation } from "./evaluation.js";

export function outcome(view) {
  const place = document.getElementById("outcome"),
    warnings = document.getElementById("warnings");
  let shown = null;

  async function first() {
    try {
      const { items } = await get(`/jobs/${view.id}/evaluations`, { state: "failed", limit: 1 });
      if (items.length) openEvaluation(view, items[0].generation, items[0].particle);
      else announce("No failed evaluation is left.");
    } catch (error) {
      announce(error.message);
    }
  }

  function show() {
    const { job } = view;
    const now = JSON.stringify([job.error, job.failed_evaluations, job.warnings]);
    if (now === shown) return;
    shown = now;
    warnings.replaceChildren(...job.warnings.map((text) => element("li", {}, typeset(text))));
    const failed = job.failed_evaluations;
    const why = failed
      ? element(
          "button",
          { type: "button", class: job.error ? "quiet" : "link", onclick: first },
          job.error ? "Show the first failed evaluation" : "See why",
        )
      : null;
    const again =
      job.error && document.body.dataset.maySubmit === "true"
        ? element("a", { class: "button", href: `/new?from=${view.id}` }, "Change the problem and calibrate again")
        : null;
    if (job.error)
      place.replaceChildren(
        element(
          "div",
          { class: "error" },
          element("p", {}, job.error),
          element("div", { class: "buttons" }, again, why),
        ),
      );
    else if (failed)
      place.replaceChildren(
        element("p", { class: "help" }, `${failed} of ${job.evaluations} evaluations failed. `, why),
      );
    else place.replaceChildren();
  }
  return { job: show, generation: show };
}
