// How a search went, live: convergence, particles, every evaluation.
import { connection } from "./dom.js";
import { convergence } from "./job/convergence.js";
import { evaluations } from "./job/evaluations.js";
import { facts } from "./job/facts.js";
import { live } from "./job/live.js";
import { particles } from "./job/particles.js";
import { readings } from "./job/readings.js";
import { timeline } from "./job/timeline.js";

const shown = [
  readings(),
  facts,
  document.getElementById("convergence") && convergence,
  particles,
  timeline,
  evaluations,
].filter(Boolean);
live(shown).catch((error) => connection(error.message));
