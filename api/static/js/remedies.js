// What to do about a finding, in the words of the dashboard: names of fields, and buttons for what the service does itself.
import { BUTTONS, affordable } from "./costs.js";
import { element, once } from "./dom.js";
import { count, number, plain, typeset } from "./format.js";
import { get, post } from "./http.js";

const FIELDS = { x_from: "“From”", x_to: "“To”", leave_out_stages: "“Stages to leave out”" };
const EARLY = "“Of every stage, from so long after its load”";
const least = (time) => (time < 10 ? Number(time.toPrecision(2)) : Math.round(time)); // as the command line words it
const either = (ways) => (ways.length < 2 ? ways.join("") : `${ways.slice(0, -1).join(", ")} or ${ways.at(-1)}`);
const ends = ({ stage_settlement: offered }) =>
  offered ? ", or calibrate the series stage_settlement, the values at the ends of the stages" : "";

const WORDS = {
  gross_errors: ({ series, values: { readings }, changes }) =>
    `Look up reading${readings.length > 1 ? "s" : ""} ${readings.join(", ")} of ${plain(series)}: ${either(["correct a slip", `enter ${readings.length > 1 ? "their numbers" : "its number"} under “Gross errors”`, ...(changes.includes("loss") ? ["choose a loss under “Outliers”"] : [])])}.`,
  check_readings: () =>
    "Check the readings first: their units and columns, the zero reading and the sign, and the size and the loads of the specimen.",
  primary_consolidation: ({ series, values }) =>
    `${plain(series)}: the readings of stage${values.stages.length > 1 ? "s" : ""} ${values.stages.join(", ")} look like primary consolidation (90 % after ${number(values.t90, 3)} ${values.unit}), which the soil laws do not contain. Leave out the ${count(values.readings)} readings before its end: enter ${least(values.t100)} ${values.unit} under ${EARLY}${ends(values)}.`,
  stage_ends: ({ values }) =>
    `Primary consolidation is not part of the soil laws: leave out readings before its end under ${EARLY}${ends(values)}.`,
  change_model: ({ values, changes }) =>
    `Check the fit: ${changes.length ? `leave out what the model does not contain (${changes.map((key) => FIELDS[key] ?? key).join(", ")}), ` : ""}${values.fixed.length ? "free a parameter that is fixed, " : ""}or use another law.`,
  thin: () =>
    "If the model is right and the readings drift or depend on one another, only the intervals are wrong: thin the readings out until the residuals no longer follow one another.",
  error: () =>
    "Enter the error that the readings have under “Standard deviation of a reading”, or leave the field empty: the error is then estimated.",
  sensitivity: () => `“${BUTTONS.sensitivity}” refines the optimum, tests the fit and calculates intervals there.`,
  profile: () => `“${BUTTONS.profile}” calculates the interval by likelihood.`,
  explore: () => `“${BUTTONS.explore}” runs the model where another basin is most likely.`,
};

/** The problem with an observation changed. */
const changed = (problem, series, change) => ({
  ...problem,
  observations: problem.observations.map((one) => (one.series === series ? { ...one, ...change(one) } : one)),
});

/** The problem with other sections of parameters; what a new range keeps of the old one stays. */
export function withParameters(problem, sections) {
  const kept = ([name, section]) => {
    const { initial, integer } = problem.parameters[name];
    if (section.lower === undefined) return [name, section];
    const inside = initial >= section.lower && initial <= section.upper;
    return [name, { ...section, ...(integer ? { integer } : {}), ...(inside ? { initial } : {}) }];
  };
  return {
    ...problem,
    parameters: { ...problem.parameters, ...Object.fromEntries(Object.entries(sections).map(kept)) },
  };
}

/** Changes of the problem that leave nothing to choose: the words of each, and what it makes of a problem. */
const CHANGES = {
  gross_errors: ({ series, values: { readings } }) => [
    [
      `Leave out reading${readings.length > 1 ? "s" : ""} ${readings.join(", ")} of ${plain(series)}`,
      (problem) =>
        changed(problem, series, ({ gross_errors: before }) => ({
          gross_errors: [...new Set([...(before ?? []), ...readings])].sort((a, b) => a - b),
        })),
    ],
  ],
  primary_consolidation: ({ series, values: { t100, unit } }) => [
    [
      `Leave out the first ${least(t100)} ${unit} of each stage of ${plain(series)}`,
      (problem) => changed(problem, series, () => ({ stage_x_from: least(t100) })),
    ],
  ],
  check_readings: ({ values: { units } }) =>
    (units ?? []).map(({ series, key, unit }) => [
      `Read ${plain(series)} in ${unit}`,
      (problem) => ({
        ...changed(problem, series, () => ({ [key]: unit })),
        accept: (problem.accept ?? []).filter((name) => name !== series),
      }),
    ]),
};

/** Start a job again with its problem changed, if what it takes is accepted, and go to it. */
export async function recalculate(job, words, change) {
  const [problem, { items }] = await Promise.all([get(`/jobs/${job}/problem`), get(`/jobs/${job}/follow-ups`)]);
  const cost = items.find(({ kind }) => kind === "again");
  if (!(await affordable(words, cost))) return;
  const name = `${problem.name} (${words[0].toLowerCase()}${words.slice(1)})`.slice(0, 200);
  const made = await post("/jobs", { ...change(problem), name });
  location.assign(`/jobs/${made.id}`);
}

/** Buttons that start a job again with a remedy done; none where there is something to choose. */
export function recalculations(remedy, job) {
  return (CHANGES[remedy.kind]?.(remedy) ?? []).map(([words, change]) => {
    const message = element("p", { class: "error", role: "alert" });
    const button = element(
      "button",
      { type: "button", class: "quiet", onclick: () => once(button, begin) },
      `${words} and recalculate`,
    );
    async function begin() {
      message.textContent = "";
      try {
        await recalculate(job, words, change);
      } catch (error) {
        message.textContent = error.message;
      }
    }
    return element("div", { class: "buttons" }, button, message);
  });
}

/** A remedy in the words of the dashboard. */
export function remedyWords(remedy) {
  return WORDS[remedy.kind]?.(remedy) ?? typeset(remedy.text);
}

/** Follow-ups among remedies, in words, with a button each where they can be started here. */
export function followUps(remedies, start) {
  return remedies.map((remedy) =>
    element(
      "div",
      { class: "proposal" },
      element("p", {}, remedyWords(remedy)),
      start
        ? element(
            "div",
            { class: "buttons" },
            element(
              "button",
              { type: "button", class: "quiet", onclick: () => start(remedy.kind) },
              BUTTONS[remedy.kind],
            ),
          )
        : null,
    ),
  );
}
