// What the data say about each parameter, in words, with the evidence and what to do about it.
import { element, tableHead, wide } from "../dom.js";
import { coefficient as fixed, count, ends, number, percent, symbol, typeset } from "../format.js";
import { followUps } from "../remedies.js";

const SIGNS = { lack_of_fit: "≠ ", error_not_met: "≠ " };
const BASES = { sampling: "sampling", linearisation: "sensitivities at the optimum", none: "too little" };
const DO = { fix: "Fix", link: "Link", widen: "Widen" };

/** Cards of verdicts; `plan` takes proposals and `start` starts a follow-up, null when nothing may be submitted. */
export function verdictCards(verdicts, units, plan, start) {
  return verdicts.map(({ parameter, kind, words, sentence, evidence, proposals, what_to_do: remedies }) =>
    element(
      "article",
      { class: `card ${kind}`, id: `verdict-${parameter}`, "data-parameter": parameter },
      element(
        "h3",
        {},
        `${symbol(parameter)}${unitOf(units[parameter])}`,
        element("span", { class: "badge" }, `${SIGNS[kind] ?? ""}${words}`),
      ),
      element("p", {}, typeset(sentence)),
      element("details", {}, element("summary", {}, "Evidence"), evidenceList(evidence)),
      followUps(remedies, start),
      proposals.map((proposal) => suggestion(proposal, plan)),
    ),
  );
}

function unitOf(unit) {
  return unit && unit !== "-" ? ` [${unit}]` : "";
}

function evidenceList(evidence) {
  const yes = (value) => (value === null ? "–" : value ? "yes" : "no");
  const rows = [
    ["Basis", BASES[evidence.basis]],
    ["Good fits", count(evidence.good_fits)],
    [
      "They range over",
      evidence.range_lower === null || evidence.range_upper === null
        ? "–"
        : ends(evidence.range_lower, evidence.range_upper),
    ],
    ["Share of the sampled width", percent(evidence.width_ratio ?? NaN)],
    ["In one group", yes(evidence.unimodal)],
    ["Reach the lower bound", yes(evidence.open_below)],
    ["Reach the upper bound", yes(evidence.open_above)],
    ["Influence on the fit", number(evidence.influence)],
    [
      "Tied to",
      evidence.partners
        .map(([name, r]) => (r === null ? symbol(name) : `${symbol(name)} (r = ${fixed(r)})`))
        .join(", ") || "none",
    ],
    ["Values in other basins", evidence.elsewhere.map((value) => number(value)).join(", ") || "none"],
    ["May be exchanged with", evidence.exchangeable.map(symbol).join(", ") || "none"],
    ["Space that could still hide such a basin", percent(evidence.hidden ?? NaN)],
    ["From a swarm's path", yes(evidence.sampling_bias)],
  ];
  return element(
    "dl",
    {},
    rows.map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value))),
  );
}

function suggestion(proposal, plan) {
  const words = element("p", {}, typeset(proposal.sentence));
  if (!plan || !DO[proposal.kind]) return element("div", { class: "proposal" }, words);
  const what = `${DO[proposal.kind]} ${symbol(proposal.parameter)}`;
  return element(
    "div",
    { class: "proposal" },
    words,
    element(
      "div",
      { class: "buttons" },
      element(
        "button",
        { type: "button", class: "quiet", onclick: () => plan.accept(proposal) },
        `${what} in the follow-up`,
      ),
      element(
        "button",
        { type: "button", class: "quiet", onclick: (event) => plan.startWith(proposal, event.currentTarget) },
        `${what} and start`,
      ),
    ),
  );
}

/** Table of all correlations of an answer of /statistics. */
export function correlationTable(tables) {
  const names = {
    "pearson linear": "r, natural values",
    "pearson search": "r, search coordinates",
    "spearman linear": "ρ, ranks",
    "spearman search": "ρ, ranks",
  };
  const cell = ({ coefficient, lower, upper, correlated }) =>
    element(
      "td",
      { class: "n" },
      coefficient === null ? "–" : element(correlated ? "strong" : "span", {}, fixed(coefficient)),
      lower === null || upper === null ? "" : ` (${fixed(lower)} … ${fixed(upper)})`,
    );
  if (!tables.length || !tables[0].pairs.length)
    return element("p", { class: "empty" }, "One parameter has no correlations.");
  return wide(
    "Correlations",
    element(
      "table",
      {},
      element(
        "caption",
        { class: "help" },
        `Among the good fits, with ${percent(tables[0].level)} intervals; bold: |r| ≥ 0.5 and the interval excludes 0.${tables[0].biased ? " Of a swarm's path: not of the data alone." : ""}`,
      ),
      tableHead(
        ["Pair", ...tables.map(({ method, coordinates }) => names[`${method} ${coordinates}`]), "n"],
        (i) => i > 0,
      ),
      element(
        "tbody",
        {},
        tables[0].pairs.map((pair, i) =>
          element(
            "tr",
            {},
            element("th", { scope: "row" }, `${symbol(pair.first)}, ${symbol(pair.second)}`),
            tables.map((table) => cell(table.pairs[i])),
            element("td", { class: "n" }, count(pair.count)),
          ),
        ),
      ),
    ),
  );
}
