// One evaluation: why it failed, parameters, response, tries, log.
import { announce, dialog, element, tableHead, wide } from "../dom.js";
import { amount, duration, moment, number, symbol, withUnit } from "../format.js";
import { get } from "../http.js";
import { addressValues, setAddressValues } from "../place.js";
import { plot } from "../plot.js";
import { converted } from "../units.js";
import { fitPlot } from "./fit_plot.js";

const words = (name) => name.replaceAll("_", " ");
// What has a place of its own in the dialog; every other column of an evaluation is a fact.
const PLACED = new Set([
  "generation",
  "particle",
  "state",
  "parameters",
  "objective",
  "misfits",
  "responses",
  "reason",
  "message",
  "attempts",
  "worker",
  "started_at",
  "finished_at",
  "seconds",
  "log",
]);

/** Show it in a dialog. */
export async function openEvaluation(view, generation, particle) {
  let evaluation, tries, fit;
  const path = `/jobs/${view.id}/evaluations/${generation}/${particle}`;
  try {
    [evaluation, { items: tries }, fit] = await Promise.all([
      get(path),
      get(`${path}/attempts`),
      get(`/jobs/${view.id}/fit`, { generation, particle }),
    ]);
  } catch (error) {
    return announce(error.message);
  }
  fit = converted(fit);
  const chosen = fit.curves.find(({ role }) => role === "chosen");
  const drawn = fit.series.filter(({ series }) => chosen.values[series]);
  const frames = drawn.map(() => element("div", {}));
  const made = dialog(
    `Generation ${generation}, particle ${particle}`,
    evaluation.reason
      ? element(
          "p",
          { class: "error" },
          element("strong", {}, `Why it failed: ${words(evaluation.reason)}. `),
          evaluation.message ?? "",
        )
      : null,
    element(
      "dl",
      {},
      fact("State", evaluation.state),
      fact(withUnit("Objective", fit.objective_unit), number(evaluation.objective, 8)),
      fact("Time", duration(evaluation.seconds)),
      fact("Worker", evaluation.worker ?? "–"),
      fact("Finished", moment(evaluation.finished_at)),
      Object.entries(evaluation)
        .filter(([name]) => !PLACED.has(name))
        .map(([name, value]) => fact(heading(name), cell(name, value))),
    ),
    element("div", { class: "grid" }, parameters(fit, chosen), chosen.shares.length ? shares(chosen) : null),
    drawn.length ? element("h3", {}, "Response") : null,
    frames,
    attempts(tries),
    evaluation.log
      ? [element("h3", {}, "End of what the forward model wrote"), element("pre", { tabindex: "0" }, evaluation.log)]
      : null,
  );
  made.classList.add("evaluation");
  setAddressValues({ evaluation: `${generation}-${particle}` });
  made.addEventListener("close", () => setAddressValues({ evaluation: null }));
  const plots = drawn.map((series, i) => plot(frames[i], () => fitPlot(fit, series.series, { initial: false })));
  made.addEventListener("close", () => plots.forEach(({ remove }) => remove()));
  await Promise.all(plots.map((one) => one.draw()));
}

/** The evaluation that the address names, if it does: ?evaluation=GENERATION-PARTICLE. */
export function openNamed(view) {
  const named = addressValues()
    .get("evaluation")
    ?.match(/^(\d{1,9})-(\d{1,9})$/);
  if (named) openEvaluation(view, Number(named[1]), Number(named[2]));
}

const heading = (name) => words(name).replace(/^./, (first) => first.toUpperCase());
const cell = (name, value) =>
  value === null
    ? "–"
    : name.endsWith("_at")
      ? moment(value)
      : typeof value === "number"
        ? number(value, 6)
        : String(value);
const fact = (name, value) => element("div", {}, element("dt", {}, name), element("dd", {}, value));

function rows(title, heads, body) {
  return element(
    "section",
    {},
    element("h3", {}, title),
    wide(
      title,
      element(
        "table",
        {},
        tableHead(heads),
        element(
          "tbody",
          {},
          body.map((cells) =>
            element(
              "tr",
              {},
              cells.map((cell) => element("td", {}, cell)),
            ),
          ),
        ),
      ),
    ),
  );
}

function parameters(fit, chosen) {
  return rows(
    "Parameters",
    ["Parameter", "Value", "Kind"],
    fit.parameters.map(({ name, unit, form }) => [
      withUnit(symbol(name), unit),
      number(chosen.parameters[name], 8),
      form,
    ]),
  );
}

function shares(chosen) {
  return rows(
    "Shares",
    ["Series", "Root mean square", "Misfit [base unit²]", "Share"],
    chosen.shares.map((one) => [
      one.series,
      amount(one.root_mean_square, one.unit),
      number(one.misfit, 6),
      `${(100 * one.share).toFixed(1)} %`,
    ]),
  );
}

function attempts(tries) {
  if (!tries.length) return null;
  return rows(
    "Attempts",
    ["Attempt", "Outcome", "Worker", "Started", "What happened"],
    tries.map((one) => [
      String(one.number),
      words(one.outcome) + (one.counted ? " (counts)" : ""),
      one.worker ?? "–",
      moment(one.started_at),
      [
        one.message ?? "",
        one.log ? element("details", {}, element("summary", {}, "Log"), element("pre", {}, one.log)) : null,
      ],
    ]),
  );
}
