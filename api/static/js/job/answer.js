// The answer in words, and the table of parameters: both from the statistics, so that they never disagree with these.
import { alarm, doubt } from "../alarm.js";
import { announce, element, empty, exchange, svg, tableHead } from "../dom.js";
import { amount, ends, number, plain, precise, symbol, typeset, withUnit } from "../format.js";
import { get } from "../http.js";
import { ENDED } from "../states.js";
import { materialButtons } from "./copy.js";
import { nextStep, widening } from "./next_step.js";

const AHEAD = new Set(["predict", "design"]); // follow-ups that ask of other tests: their page says what they found
const FORMS = { fixed: "fixed", linked: "linked" };
const NEAR = 1e-6; // parts of the searched range, as in at_bounds of a job
const MOST_NAMED = 3;
const MOST_BASINS = 3;
const AWAY = 0.5; // standard errors

const listed = (names) => (names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`);

/** What the statistics say of all parameters and of the fit, in one line. */
function summary({ verdicts, fit }, shares, short = false) {
  const groups = new Map();
  for (const { parameter, words } of verdicts) groups.set(words, [...(groups.get(words) ?? []), symbol(parameter)]);
  const told = [...groups].map(([words, names]) => `${words}: ${names.join(", ")}`);
  const all = shares.length > MOST_NAMED && !short && fit.closeness.length; // by quantity over all tests
  const left = (
    all
      ? fit.closeness.map(({ quantity, deviation, unit }) => [quantity, deviation, unit])
      : shares.slice(0, MOST_NAMED).map(({ series, root_mean_square: value, unit }) => [plain(series), value, unit])
  ).map(([name, value, unit]) => `${amount(value, unit)}${shares.length > 1 ? ` in ${name}` : ""}`);
  const text = [
    ...told,
    left.length
      ? `${short ? "the best run of the search" : "the fit"} leaves ${listed(left)} (root mean square)`
      : null,
    fit.words,
  ]
    .filter(Boolean)
    .join("; ");
  return `${text[0].toUpperCase()}${text.slice(1)}.`;
}

/** Whether the values are those of a minimum that a follow-up found, away from the best run of the search. */
function endedShort({ statistics, job }) {
  return Object.entries(statistics?.linearisation?.parameters ?? {}).some(
    ([name, { value, standard_error: error }]) => error > 0 && Math.abs(value - job.parameters[name]) > AWAY * error,
  );
}

/** Which bound a value lies at: "lower", "upper" or null. */
function boundTouched(value, { lower, upper, scale }) {
  const place =
    scale === "log" && value > 0
      ? Math.log(value / lower) / Math.log(upper / lower)
      : (value - lower) / (upper - lower);
  return place <= NEAR ? "lower" : place >= 1 - NEAR ? "upper" : null;
}

/** The searched range as a bar: the usual range in it, the interval, and the value. */
function searched({ lower, upper, scale, unit, typical_lower: usualLow, typical_upper: usualHigh }, value, low, high) {
  const log = scale === "log" && lower > 0;
  const share = (at) => {
    const part = log ? (at > 0 ? Math.log(at / lower) / Math.log(upper / lower) : 0) : (at - lower) / (upper - lower);
    return 100 * Math.min(Math.max(part, 0), 1);
  };
  const bar = (kind, from, to, y, height, least = 0) =>
    svg("rect", {
      class: kind,
      x: `${share(from).toFixed(2)}%`,
      width: `${Math.max(share(to) - share(from), least).toFixed(2)}%`,
      y,
      height,
    });
  const usual = usualLow !== null && usualLow !== undefined && usualHigh > lower && usualLow < upper;
  const words = `searched from ${number(lower)} to ${withUnit(number(upper), unit)}${log ? " on a logarithmic scale" : ""}${usual ? `, usual ${number(usualLow)} to ${number(usualHigh)}` : ""}`;
  return element(
    "span",
    { class: "searched", title: words },
    number(lower),
    svg(
      "svg",
      { class: "within", role: "img", "aria-label": words },
      svg("rect", { class: "all", x: 0, width: "100%", y: 5, height: 4 }),
      usual ? bar("usual", usualLow, usualHigh, 2, 10) : null,
      low !== null && high !== null ? bar("interval", low, high, 4, 6, 1) : null,
      svg("line", {
        class: "value",
        x1: `${share(value).toFixed(2)}%`,
        x2: `${share(value).toFixed(2)}%`,
        y1: 0,
        y2: 14,
      }),
    ),
    `${number(upper)}${log ? " log" : ""}`,
  );
}

export function answer(view) {
  const said = document.getElementById("answer"),
    table = document.getElementById("parameters"),
    copies = document.getElementById("copies");
  const followUp = document.querySelector("main").dataset.role === "follow_up";
  const next = nextStep(view, document.getElementById("next"), () => {
    judged = null;
    judge();
  });
  let judged = null;

  async function judge() {
    const { job } = view;
    if (followUp || !ENDED.has(job.state) || job.objective === null || judged === job.evaluations) return;
    judged = job.evaluations;
    try {
      view.statistics = await get(`/jobs/${view.id}/statistics`);
    } catch (error) {
      if (![404, 409].includes(error.status)) announce(error.message); // 404: the job has been deleted meanwhile
      said.replaceChildren();
      return;
    }
    const { fit, verdicts } = view.statistics;
    const elsewhere = fit.kind === "lack_of_fit" && !widening(verdicts); // the next step is to change the problem
    document.getElementById("alarm").replaceChildren(...alarm(fit, view.id, !elsewhere));
    show();
    next.show();
  }

  function show() {
    const best = view.fit?.curves.find(({ role }) => role === "best");
    if (view.statistics) said.textContent = summary(view.statistics, best?.shares ?? [], endedShort(view));
    parameters();
  }

  /** What is known of a parameter: value and interval, from the sensitivities at the optimum or the good fits. */
  function known(name) {
    const verdict = view.statistics?.verdicts.find(({ parameter }) => parameter === name) ?? null;
    const at = view.statistics?.linearisation?.parameters[name];
    const [low, high] = at?.interval ?? [verdict?.evidence.range_lower ?? null, verdict?.evidence.range_upper ?? null];
    return { value: at?.value ?? view.job.parameters[name], low, high, verdict, good: !at?.interval };
  }

  function row(name, info) {
    const { value, low, high, verdict, good } = known(name);
    const there = low !== null && high !== null;
    const bound = info ? boundTouched(value, info) : null;
    const others =
      view.statistics?.basins.others
        .filter(({ differs }) => differs.includes(name))
        .map(({ parameters }) => number(parameters[name], 3)) ?? [];
    const also =
      others.slice(0, MOST_BASINS).join(", ") +
      (others.length > MOST_BASINS ? ` and ${others.length - MOST_BASINS} more` : "");
    const how = good
      ? "range of the good fits"
      : others.length
        ? `in this basin; ${also} fit${others.length > 1 ? "" : "s"} as well`
        : null;
    return element(
      "tr",
      {},
      element(
        "td",
        {},
        withUnit(symbol(name), info?.unit),
        symbol(name) === name ? null : element("small", {}, ` ${name}`),
      ),
      element("td", { class: "n", title: number(value, 10) }, there ? precise(value, high - low) : number(value)),
      element(
        "td",
        {},
        there ? ends(low, high, 3) : "–",
        there && how ? element("small", {}, ` ${how}`) : null,
        info ? searched(info, value, low, high) : null,
      ),
      element(
        "td",
        {},
        verdict
          ? element(
              "a",
              {
                class: `verdict ${verdict.kind}`,
                href: `/jobs/${view.id}/statistics#verdict-${name}`,
                title: typeset(verdict.reason),
              },
              verdict.words,
            )
          : "searched",
        bound ? element("strong", { class: "touched" }, ` ⚠ at its ${bound} bound ${number(info[bound])}`) : null,
      ),
    );
  }

  /** Parameters that were not searched, in a line. */
  function given(infos) {
    const told = Object.entries(view.job.parameters)
      .filter(([name]) => !view.job.free_parameters.includes(name))
      .map(([name, value]) => {
        const info = infos.get(name);
        return `${symbol(name)} = ${info?.expression ? `${info.expression} = ` : ""}${amount(value, info?.unit, 4)}${FORMS[info?.form] ? ` (${FORMS[info.form]})` : ""}`;
      });
    return told.length ? element("p", { class: "help", id: "given" }, `Given: ${told.join(", ")}.`) : null;
  }

  /** Values and intervals as a material set. */
  const materialSet = (infos) => () =>
    Object.entries(view.job.parameters).map(([name, value]) => {
      const {
        value: shown,
        low,
        high,
      } = view.job.free_parameters.includes(name) ? known(name) : { value, low: null, high: null };
      return { name, unit: infos.get(name)?.unit ?? "", value: shown, lower: low, upper: high };
    });

  function parameters() {
    const { job } = view;
    if (!job.parameters)
      return void exchange(
        table,
        empty(
          ENDED.has(job.state)
            ? "No evaluation has succeeded: there are no values."
            : "No evaluation has succeeded yet.",
        ),
      );
    const infos = new Map((view.fit?.parameters ?? []).map((info) => [info.name, info]));
    const level = view.statistics?.linearisation?.level;
    const wrong = doubt(view.statistics?.fit);
    const heads = [
      "Parameter",
      "Value",
      `${level ? `${Math.round(100 * level)} % interval` : "Interval"}${wrong ? ": does not hold" : ""}`,
      "Verdict",
    ];
    exchange(
      table,
      element(
        "table",
        {},
        tableHead(heads, (i) => i === 1),
        element(
          "tbody",
          {},
          job.free_parameters.map((name) => row(name, infos.get(name))),
        ),
      ),
      given(infos),
      level ? element("p", { class: "help" }, typeset(view.statistics.basins.sentence)) : null,
      endedShort(view)
        ? element(
            "p",
            { class: "help" },
            "Values and intervals are those of the minimum that the sensitivities went to. The search had ended short of it; the fit shows its best run.",
          )
        : null,
    );
    copies.replaceChildren(ENDED.has(job.state) && view.fit ? materialButtons(materialSet(infos)) : "");
  }

  if (followUp && !AHEAD.has(document.querySelector("main").dataset.method))
    said.replaceChildren("A follow-up: its runs are around an optimum. ", ...parentLink());
  return {
    job() {
      if (!ENDED.has(view.job.state)) said.textContent = followUp ? said.textContent : "";
      if (view.fit) judge(); // else when the fit is there, which takes a moment only
      show();
    },
    generation: parameters,
    fit() {
      judge();
      show();
    },
  };
}

function parentLink() {
  const { parent } = document.querySelector("main").dataset;
  return parent
    ? ["Its results are on the ", element("a", { href: `/jobs/${parent}` }, "page of the job that it follows"), "."]
    : [];
}
