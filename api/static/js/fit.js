// How the best evaluation lies to the readings, large and with what is left over, live.
import { connection, failure } from "./dom.js";
import { diagrams } from "./job/diagrams.js";
import { fit } from "./job/fit.js";
import { live } from "./job/live.js";
import { otherSet } from "./job/other_set.js";
import { readings } from "./job/readings.js";
import { shares } from "./job/shares.js";

const without = (error) => document.getElementById("fit").replaceChildren(failure(error));
live([readings(without), fit, otherSet, diagrams, shares]).catch((error) => connection(error.message));
