// How a search went, live: convergence, particles, every evaluation.
import { connection } from "./dom.js";
import { get } from "./http.js";
import { convergence } from "./job/convergence.js";
import { evaluations } from "./job/evaluations.js";
import { facts } from "./job/facts.js";
import { live } from "./job/live.js";
import { particles } from "./job/particles.js";
import { paced } from "./pace.js";

const INTERVAL = 2500;

/** Units and bounds of the parameters, and the deviation of the best evaluation, which others show. */
function frame(view) {
  let objective;
  const load = paced(async () => {
    if (view.fit !== null && objective === view.job.objective) return;
    objective = view.job.objective;
    view.fit = await get(`/jobs/${view.id}/fit`);
    view.changed();
  }, INTERVAL);
  return { job: load, generation: load };
}

const shown = [facts, frame, document.getElementById("convergence") && convergence, particles, evaluations].filter(Boolean);
live(shown).catch((error) => connection(error.message));
