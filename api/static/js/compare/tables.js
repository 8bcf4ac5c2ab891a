// Tables with one column a job.
import { element, when, wide } from "../dom.js";
import { amount, count, duration, ends, number, plain, symbol, withUnit } from "../format.js";

function table(caption, loaded, rows) {
  const head = element(
    "tr",
    {},
    element("td", {}),
    loaded.map(({ job }) => element("th", { scope: "col", class: "n" }, job.name)),
  );
  const body = rows.map(([label, cells, differs]) =>
    element(
      "tr",
      {},
      element("th", { scope: "row" }, label),
      cells.map((cell, i) => element("td", { class: differs?.[i] ? "n differs" : "n" }, cell)),
    ),
  );
  return wide(
    caption,
    element(
      "table",
      { class: "side" },
      element("caption", {}, caption),
      element("thead", {}, head),
      element("tbody", {}, body),
    ),
  );
}

/** What was asked, how far it is, what it cost. */
export function factsTable(loaded, { objectives, reweighted }) {
  const lowest = Math.min(...(objectives ?? []).map((objective) => objective ?? Infinity));
  const unit = common(loaded.map(({ fit }) => fit.objective_unit)) ?? "";
  const row = (label, value) => [label, loaded.map(({ job }) => value(job))];
  const ranked = (objective) =>
    objective !== null && objective === lowest
      ? [element("strong", {}, number(objective)), " (lowest)"]
      : number(objective);
  const anew = objectives && reweighted.some(Boolean);
  const names = [...new Set(loaded.flatMap(({ fit }) => fit.series.map(({ series }) => series)))];
  const left = names.map((name) => [
    names.length > 1 ? `Root mean square of ${plain(name)}` : "Root mean square",
    loaded.map(({ fit }) => {
      const share = fit.curves.find(({ role }) => role === "best")?.shares.find(({ series }) => series === name);
      return share ? amount(share.root_mean_square, share.unit) : "–";
    }),
  ]);
  return table("Jobs", loaded, [
    ...left,
    [
      withUnit(anew ? "Best objective under its own weights" : "Best objective", unit),
      loaded.map(({ job }, i) => (anew || !objectives ? number(job.objective) : ranked(objectives[i]))),
    ],
    ...(anew
      ? [[withUnit(`Best objective under the weights of ${loaded[0].job.name}`, unit), objectives.map(ranked)]]
      : []),
    row(
      "Evaluations",
      (job) => count(job.evaluations) + (job.max_evaluations ? ` / ${count(job.max_evaluations)}` : ""),
    ),
    row("Failed evaluations", (job) => count(job.failed_evaluations)),
    row("Generations", (job) => count(job.generations)),
    row("Running time", (job) => duration(job.seconds)),
    row("Ended by", (job) => job.stop_reasons.map(plain).join(", ") || "–"),
    row("Forward model", (job) => plain(job.forward_model)),
    row("Method", (job) => plain(job.method)),
    row("Seed", (job) => String(job.seed)),
    row("Submitted", (job) => when(job.created_at)),
  ]);
}

/** Value of every parameter that any of the jobs has, with interval and verdict; those that differ by more than a hundredth stand out. */
export function parametersTable(loaded) {
  const names = [...new Set(loaded.flatMap(({ fit }) => fit.parameters.map(({ name }) => name)))];
  const rows = names.map((name) => {
    const infos = loaded.map(({ fit }) => fit.parameters.find((parameter) => parameter.name === name));
    const values = loaded.map(({ job }) => job.parameters?.[name]);
    const known = values.filter((value) => value !== undefined);
    const spread =
      known.length > 1 && Math.max(...known) - Math.min(...known) > 0.01 * Math.max(...known.map(Math.abs));
    const cells = infos.map((info, i) => [
      number(values[i] ?? info?.value, 5),
      info && info.form !== "free" ? element("small", {}, ` ${info.form}`) : null,
      info?.form === "free" ? certainty(loaded[i].job, name) : null,
    ]);
    return [
      withUnit(symbol(name), infos.find(Boolean)?.unit),
      cells,
      values.map((value) => spread && value !== undefined),
    ];
  });
  return table("Values that differ by more than 1 % are bold.", loaded, rows);
}

/** Interval, verdict and bound of a value, as far as its job knows them. */
function certainty({ intervals, verdicts, verdict_words: said, at_bounds: bounds }, name) {
  const interval = intervals?.[name];
  const parts = [
    interval && ends(...interval, 3),
    said?.[name] ?? (verdicts && plain(verdicts[name])),
    bounds?.[name] && `at its ${bounds[name]} bound`,
  ].filter(Boolean);
  return parts.length ? element("small", {}, element("br"), parts.join(", ")) : null;
}

/** The value that all share, null where they differ. */
export function common(values) {
  return values.every((value) => value === values[0]) ? values[0] : null;
}
