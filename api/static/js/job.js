// What a job has found, live: the answer, its fit, what to do next.
import { connection } from "./dom.js";
import { actions } from "./job/actions.js";
import { answer } from "./job/answer.js";
import { facts } from "./job/facts.js";
import { fit } from "./job/fit.js";
import { followUps } from "./job/follow_ups.js";
import { live } from "./job/live.js";
import { outcome } from "./job/outcome.js";
import { progress } from "./job/progress.js";
import { reports } from "./job/reports.js";

reports();
live([facts, actions, outcome, progress, answer, fit, followUps]).catch((error) => connection(error.message));
