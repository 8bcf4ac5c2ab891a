// What to do about a finding, in the words of the dashboard: names of fields, and buttons for what the service does itself.
import { BUTTONS } from "./costs.js";
import { element } from "./dom.js";
import { count, number, plain } from "./format.js";

const FIELDS = { x_from: "“From”", x_to: "“To”", leave_out_stages: "“Stages to leave out”" };
const EARLY = "“Of every stage, from so long after its load”";
const either = (ways) => (ways.length < 2 ? ways.join("") : `${ways.slice(0, -1).join(", ")} or ${ways.at(-1)}`);
const ends = ({ stage_settlement: offered }) => (offered ? ", or calibrate the series stage_settlement, the values at the ends of the stages" : "");

const WORDS = {
  gross_errors: ({ series, values: { readings }, changes }) => `Look up reading${readings.length > 1 ? "s" : ""} ${readings.join(", ")} of ${plain(series)}: ${either(["correct a slip", `enter ${readings.length > 1 ? "their numbers" : "its number"} under “Gross errors”`, ...(changes.includes("loss") ? ["choose a loss under “Outliers”"] : [])])}.`,
  check_readings: () => "Check the readings first: their units and columns, the zero reading and the sign, and the size and the loads of the specimen.",
  primary_consolidation: ({ series, values }) => `${plain(series)}: the readings of stage${values.stages.length > 1 ? "s" : ""} ${values.stages.join(", ")} look like primary consolidation (90 % after ${number(values.t90, 3)} ${values.unit}), which the soil laws do not contain. Leave out the ${count(values.readings)} readings before its end: enter ${number(values.t100, 2)} ${values.unit} under ${EARLY}${ends(values)}.`,
  stage_ends: ({ values }) => `Primary consolidation is not part of the soil laws: leave out readings before its end under ${EARLY}${ends(values)}.`,
  change_model: ({ values, changes }) => `Look at the fit: ${changes.length ? `leave out what the model does not contain (${changes.map((key) => FIELDS[key] ?? key).join(", ")}), ` : ""}${values.fixed.length ? "free a parameter that is fixed, " : ""}or take another law.`,
  thin: () => "If the model is right and the readings drift or depend on one another, only the intervals are wrong: thin the readings out until the residuals no longer follow one another.",
  error: () => "Enter the error that the readings have under “Standard deviation of a reading”, or leave the field empty: the error is then estimated.",
  sensitivity: () => `“${BUTTONS.sensitivity}” refines the optimum, tests the fit and calculates intervals there.`,
  profile: () => `“${BUTTONS.profile}” calculates the interval by likelihood.`,
  explore: () => `“${BUTTONS.explore}” searches for further basins.`,
};

/** A remedy in the words of the dashboard. */
export function remedyWords(remedy) {
  return WORDS[remedy.kind]?.(remedy) ?? remedy.text;
}

/** Follow-ups among remedies, in words, with a button each where they can be started here. */
export function followUps(remedies, start) {
  return remedies.map((remedy) => element("div", { class: "proposal" }, element("p", {}, remedyWords(remedy)),
    start ? element("div", { class: "buttons" }, element("button", { type: "button", class: "quiet", onclick: () => start(remedy.kind) }, BUTTONS[remedy.kind])) : null));
}
