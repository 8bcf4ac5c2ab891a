// What a job has found, live: the answer, its fit at a glance, what to do next.
import { connection, failure } from "./dom.js";
import { actions } from "./job/actions.js";
import { answer } from "./job/answer.js";
import { attachments } from "./job/attachments.js";
import { glance } from "./job/glance.js";
import { live } from "./job/live.js";
import { outcome } from "./job/outcome.js";
import { progress } from "./job/progress.js";
import { readings } from "./job/readings.js";

const without = (error) => document.getElementById("fit").replaceChildren(failure(error));
live([readings(without), actions, attachments, outcome, progress, answer, glance]).catch((error) =>
  connection(error.message),
);
