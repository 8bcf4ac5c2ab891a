// Why a job failed, in one step, with the first failed evaluation at hand; and whether the model describes the data.
import { alarm } from "../alarm.js";
import { announce, element } from "../dom.js";
import { get } from "../http.js";
import { ENDED } from "../states.js";
import { openEvaluation } from "./evaluation.js";

export function outcome(view) {
  const place = document.getElementById("outcome"), warnings = document.getElementById("warnings");
  let shown = null, judged = null;

  /** At the end of a search: the verdict that its values do not hold without. */
  async function judge() {
    const { job } = view;
    if (!ENDED.has(job.state) || job.objective === null || judged === job.evaluations) return;
    judged = job.evaluations;
    try {
      const { fit } = await get(`/jobs/${view.id}/statistics`);
      document.getElementById("alarm").replaceChildren(...alarm(fit));
    } catch (error) {
      if (![404, 409].includes(error.status)) announce(error.message); // 404: the job has been deleted meanwhile
    }
  }

  async function first() {
    try {
      const { items } = await get(`/jobs/${view.id}/evaluations`, { state: "failed", limit: 1 });
      if (items.length) openEvaluation(view, items[0].generation, items[0].particle);
      else announce("No evaluation is failed any more.");
    } catch (error) {
      announce(error.message);
    }
  }

  function show() {
    judge();
    const { job } = view;
    const now = JSON.stringify([job.error, job.failed_evaluations, job.warnings]);
    if (now === shown) return;
    shown = now;
    warnings.replaceChildren(...job.warnings.map((text) => element("li", {}, text)));
    const failed = job.failed_evaluations;
    const why = failed ? element("button", { type: "button", class: job.error ? "quiet" : "link", onclick: first }, job.error ? "Show the first failed evaluation" : "See why") : null;
    if (job.error) place.replaceChildren(element("div", { class: "error" }, element("p", {}, job.error), why));
    else if (failed) place.replaceChildren(element("p", { class: "help" }, `${failed} of ${job.evaluations} evaluations failed. `, why));
    else place.replaceChildren();
  }
  return { job: show, generation: show };
}
