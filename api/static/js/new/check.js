// One forward calculation before the job: does it run, how far is it from the data, what will the search cost. And the start.
import { announce, connection, element, exchange, failure, once, tableHead } from "../dom.js";
import { count, duration, number, objectiveUnit, percent, symbol, withUnit } from "../format.js";
import { post } from "../http.js";
import { forget } from "./draft.js";
import { pointsPlot } from "./points_plot.js";
import { messageOf, placeOf, worded } from "./words.js";

const PLACEHOLDER =
  "The check makes one forward calculation with the estimates (or the middle of the bounds), shows it against the data and estimates the cost.";

/** `judged(strict)` makes the page show all mistakes and returns the service's judgement. */
export function checkSection(context, place, judged) {
  const { draft } = context;
  const result = element("div", { "aria-live": "polite" }),
    stale = element("p", { class: "help stale", hidden: true }, "The problem has changed since this check.");
  const check = element(
    "button",
    { type: "button", class: "quiet", id: "check", onclick: () => once(check, () => run(checked)) },
    "Check",
  );
  const start = element(
    "button",
    { type: "button", id: "start", onclick: () => once(start, () => run(submitted)) },
    "Start the job",
  );
  let checkedAt = -1;
  // The same key as long as the problem is the same: a second click, or a lost answer, never makes a second job.
  let key = newKey(),
    keyAt = -1;

  async function run(act) {
    try {
      const answer = await judged();
      if (!answer) return;
      if (!answer.valid) {
        const count_ = answer.issues.length;
        exchange(
          result,
          element(
            "p",
            { class: "error", role: "alert" },
            `${count_ === 1 ? "One thing is" : `${count_} things are`} missing or wrong; they are marked above and listed beside the YAML.`,
          ),
        );
        return;
      }
      await act(answer);
      connection(null);
    } catch (error) {
      exchange(
        result,
        failure(error),
        error.issues?.length
          ? element(
              "ul",
              {},
              error.issues.map((one) => element("li", {}, `${placeOf(one.path)}: ${messageOf(one)}`)),
            )
          : null,
      );
    }
  }

  async function submitted(answer) {
    if (keyAt !== draft.changes) [key, keyAt] = [newKey(), draft.changes];
    const job = await post("/jobs", answer.document, { headers: { "Idempotency-Key": key } });
    forget();
    announce("The job has started.");
    location.assign(`/jobs/${job.id}`);
  }

  async function checked(answer) {
    exchange(result, element("p", { class: "help" }, "Calculating …"));
    const at = draft.changes;
    const found = await post("/problems/check", answer.document);
    checkedAt = at;
    stale.hidden = at === draft.changes;
    show(found, answer);
  }

  function show(found, answer) {
    const run_ = found.test_run;
    const cost =
      found.planned_evaluations === null
        ? "not limited by a number of evaluations"
        : `at most ${count(found.planned_evaluations)} evaluations${found.estimated_seconds === null ? "" : `, about ${duration(found.estimated_seconds)} on one worker`}${found.left_to_answer ? `; the search leaves ${count(found.left_to_answer)} of them for minimum and intervals` : ""}`;
    const unit = objectiveUnit(answer.observations.map((one) => answer.series.find(({ name }) => name === one.series)));
    const fact = (name, value) => element("div", {}, element("dt", {}, name), element("dd", {}, value));
    exchange(
      result,
      element("h3", {}, run_.state === "finished" ? "The forward calculation works" : "The forward calculation failed"),
      run_.state === "finished"
        ? null
        : element("p", { class: "error", role: "alert" }, `${run_.reason}: ${run_.message}`),
      answer.warning_parts.length
        ? element(
            "ul",
            { class: "notes", role: "alert" },
            answer.warning_parts.map((parts) => element("li", {}, worded(parts))),
          )
        : null,
      Object.entries(found.notes).map(([series, notes]) =>
        element("p", { class: "help" }, `Readings of ${series}: ${notes.join("; ")}.`),
      ),
      found.assumptions.map((sentence) => element("p", { class: "help" }, `Assumed: ${sentence}`)),
      element(
        "dl",
        {},
        fact("Estimated cost", cost),
        fact("One calculation", duration(run_.seconds)),
        fact("Readings", count(found.data_points)),
        run_.objective === null ? null : fact(withUnit("Objective there", unit), number(run_.objective)),
        ...Object.entries(run_.parameters).map(([name, value]) =>
          fact(symbol(name), `${number(value)}${unitOf(answer, name)}`),
        ),
      ),
      shares(run_, found.shares),
      plots(run_, answer),
    );
  }

  /** Parts of the objective: what the weights do, and what they do at this point. */
  function shares(run_, found) {
    if (found.length < 2) return null;
    const several = new Set(found.map(({ test }) => test)).size > 1;
    const ofTest = (name) => found.reduce((sum, { test, share }) => sum + (test === name ? share : 0), 0);
    const columns = [
      ["Weight", (one) => number(one.weight)],
      ["Share, all missed alike", (one) => percent(one.share, 1)],
      several ? ["Share of its test", ({ test }) => percent(ofTest(test), 1)] : null,
      found[0].readings === null ? null : ["Readings", (one) => number(one.readings)],
      run_.objective > 0
        ? ["Share here", (one) => percent((one.weight * run_.misfits[one.series]) / run_.objective, 1)]
        : null,
    ].filter(Boolean);
    return element(
      "div",
      { class: "wide" },
      element(
        "table",
        {},
        element(
          "caption",
          {},
          "Shares of the objective: where each series is missed by the same part of its range, and at this point",
        ),
        tableHead(["Series", ...columns.map(([name]) => name)], (i) => i > 0),
        element(
          "tbody",
          {},
          found.map((one) =>
            element(
              "tr",
              {},
              element("th", { scope: "row" }, one.series),
              columns.map(([, cell]) => element("td", { class: "n" }, cell(one))),
            ),
          ),
        ),
      ),
    );
  }

  function plots(run_, answer) {
    const made = element("div", { class: "panels" });
    for (const one of answer.observations) {
      const calculated = run_.responses[one.series];
      const given = answer.document.observations.find((each) => each.series === one.series)?.points;
      if (!calculated || !given) continue;
      const about = answer.series.find((each) => each.name === one.series);
      const panel = element("div", {});
      made.append(
        element(
          "section",
          { class: "panel", "aria-label": `Test run of ${one.series}` },
          element("h3", {}, one.series),
          panel,
        ),
      );
      pointsPlot(panel, () => ({
        x: given.x,
        y: given.y,
        gross: answer.document.observations.find((each) => each.series === one.series).gross_errors,
        calculated: {
          x: calculated.x.map((x) => x / one.x_factor),
          y: calculated.y.map((y) => (y === null ? null : y / one.y_factor)),
        },
        label: one.series,
        xLabel: [about.x_quantity, one.x_unit],
        yLabel: [about.y_quantity, one.y_unit],
      })).draw();
    }
    return made;
  }

  place.replaceChildren(element("div", { class: "buttons" }, check, start), stale, result);
  exchange(result, element("p", { class: "help" }, PLACEHOLDER));
  draft.on("change", () => {
    stale.hidden = checkedAt < 0 || checkedAt === draft.changes;
  });
}

function unitOf(answer, name) {
  const unit = answer.parameters.find((one) => one.name === name || one.name === name.split(".").at(-1))?.unit;
  return unit ? ` ${unit}` : "";
}

/** Random text; crypto.randomUUID is there only on https and loopback. */
function newKey() {
  return Array.from(crypto.getRandomValues(new Uint8Array(16)), (byte) => byte.toString(16).padStart(2, "0")).join("");
}
