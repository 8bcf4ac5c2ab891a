// What a follow-up takes, in words; and the question before one that takes long.
import { confirmed } from "./dom.js";
import { count, duration } from "./format.js";

export const FOLLOW_UPS = {
  sensitivity: "Sensitivities at the optimum",
  profile: "Profile objectives",
  jackknife: "Leaving out one test at a time",
  explore: "Exploration for further basins",
  predict: "Prediction",
  design: "Which test next",
  sobol: "Global sensitivity (Sobol)",
  morris: "Global sensitivity (Morris)",
};
export const BUTTONS = {
  sensitivity: "Sensitivities at the optimum",
  profile: "Profiles of all parameters",
  jackknife: "Leave out one test at a time",
  explore: "Look for further basins",
};
const LONG = 60; // s

/** "about 40 runs, about 2 min"; a cost from GET …/follow-ups. */
export function costWords({ evaluations, exact, seconds }) {
  const runs = `${exact ? "" : "about "}${count(evaluations)} run${evaluations === 1 ? "" : "s"}`;
  return seconds === null ? runs : `${runs}, ${seconds < 1 ? "less than 1 s" : `about ${duration(seconds)}`}`;
}

/** Whether to begin: the user confirms what takes more than a minute, or an unknown time. */
export async function affordable(words, cost) {
  if (!cost || (cost.seconds !== null && cost.seconds <= LONG)) return true;
  return confirmed(
    `${words}: ${costWords(cost)}${cost.seconds === null ? ", time not known yet" : ""}. Start?`,
    "Start",
  );
}
