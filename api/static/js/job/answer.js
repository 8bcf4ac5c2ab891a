// The answer in words, and the table of parameters: both from the statistics, so that they never disagree with these.
import { alarm, doubt } from "../alarm.js";
import { announce, element, empty, exchange } from "../dom.js";
import { amount, ends, number, plain, precise, symbol, withUnit } from "../format.js";
import { get } from "../http.js";
import { ENDED } from "../states.js";
import { nextStep } from "./next_step.js";

const FORMS = { fixed: "fixed", linked: "linked" };
const NEAR = 1e-6; // parts of the searched range, as in at_bounds of a job
const AWAY = 0.5; // standard errors

const listed = (names) => (names.length < 2 ? names.join("") : `${names.slice(0, -1).join(", ")} and ${names.at(-1)}`);

/** What the statistics say of all parameters and of the fit, in one line. */
function summary({ verdicts, fit }, shares, short = false) {
  const groups = new Map();
  for (const { parameter, words } of verdicts) groups.set(words, [...(groups.get(words) ?? []), symbol(parameter)]);
  const told = [...groups].map(([words, names]) => `${words}: ${names.join(", ")}`);
  const left = shares.slice(0, 3).map(({ series, root_mean_square: value, unit }) => `${amount(value, unit)}${shares.length > 1 ? ` in ${plain(series)}` : ""}`);
  const text = [...told, left.length ? `${short ? "the best run of the search" : "the fit"} leaves ${listed(left)} (root mean square)` : null, fit.words].filter(Boolean).join("; ");
  return `${text[0].toUpperCase()}${text.slice(1)}.`;
}

/** Whether the values are those of a minimum that a follow-up found, away from the best run of the search. */
function endedShort({ statistics, job }) {
  return Object.entries(statistics?.linearisation?.parameters ?? {}).some(([name, { value, standard_error: error }]) => error > 0 && Math.abs(value - job.parameters[name]) > AWAY * error);
}

/** Which bound a value lies at: "lower", "upper" or null. */
export function boundTouched(value, { lower, upper, scale }) {
  const place = scale === "log" && value > 0 ? Math.log(value / lower) / Math.log(upper / lower) : (value - lower) / (upper - lower);
  return place <= NEAR ? "lower" : place >= 1 - NEAR ? "upper" : null;
}

export function answer(view) {
  const said = document.getElementById("answer"), table = document.getElementById("parameters");
  const followUp = document.querySelector("main").dataset.role === "follow_up";
  const next = nextStep(view, document.getElementById("next"), () => { judged = null; judge(); });
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
    document.getElementById("alarm").replaceChildren(...alarm(view.statistics.fit, view.statistics.fit.kind === "lack_of_fit" ? null : view.id));
    show();
    next.show();
  }

  function show() {
    const best = view.fit?.curves.find(({ role }) => role === "best");
    if (view.statistics) said.textContent = summary(view.statistics, best?.shares ?? [], endedShort(view));
    parameters();
  }

  function row(name, value, info) {
    const verdict = view.statistics?.verdicts.find(({ parameter }) => parameter === name);
    const at = view.statistics?.linearisation?.parameters[name];
    const [low, high] = at?.interval ?? [verdict?.evidence.range_lower ?? null, verdict?.evidence.range_upper ?? null];
    const known = low !== null && high !== null;
    const shown = at?.value ?? value;
    const free = info ? info.form === "free" : view.job.free_parameters.includes(name);
    const bound = info && free ? boundTouched(shown, info) : null;
    const several = view.statistics?.basins.others.some(({ differs }) => differs.includes(name));
    const how = !at?.interval ? "range of the good fits" : several ? "in one of several basins" : null;
    return element("tr", {},
      element("td", {}, withUnit(symbol(name), info?.unit), symbol(name) === name ? null : element("small", {}, ` ${name}`)),
      element("td", { class: "n", title: free ? number(shown, 10) : null }, free && known ? precise(shown, high - low) : number(shown)),
      element("td", {}, free && known ? ends(low, high, 3) : free ? "–" : "", free && known && how ? element("small", {}, ` ${how}`) : null),
      element("td", {},
        verdict ? element("a", { class: `verdict ${verdict.kind}`, href: `/jobs/${view.id}/statistics#verdict-${name}`, title: verdict.reason }, verdict.words) : free ? "searched" : FORMS[info?.form] ?? "given",
        bound ? element("strong", { class: "touched" }, ` ⚠ at its ${bound} bound ${number(info[bound])}`) : null),
      element("td", { class: "range" }, free && info ? `${number(info.lower)} … ${number(info.upper)}${info.scale === "log" ? " (log)" : ""}` : info?.expression ?? ""));
  }

  function parameters() {
    const { job } = view;
    if (!job.parameters) return void table.replaceChildren(empty("No evaluation has succeeded yet."));
    const infos = new Map((view.fit?.parameters ?? []).map((info) => [info.name, info]));
    const level = view.statistics?.linearisation?.level;
    const wrong = doubt(view.statistics?.fit);
    const heads = ["Parameter", "Value", `${level ? `${Math.round(100 * level)} % interval` : "Interval"}${wrong ? ": does not hold" : ""}`, "Verdict", "Searched"];
    exchange(table, element("table", {},
      element("thead", {}, element("tr", {}, heads.map((head, i) => element("th", { scope: "col", class: i === 1 ? "n" : i === 4 ? "range" : null }, head)))),
      element("tbody", {}, Object.entries(job.parameters).map(([name, value]) => row(name, value, infos.get(name))))),
      level ? element("p", { class: "help" }, view.statistics.basins.sentence) : null,
      endedShort(view) ? element("p", { class: "help" }, "Values and intervals are those of the minimum that the sensitivities went to. The search had ended short of it; the fit shows its best run.") : null);
  }

  if (followUp) said.replaceChildren("A follow-up: its runs are around an optimum. ", ...parentLink());
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
  return parent ? ["Its results are on the ", element("a", { href: `/jobs/${parent}` }, "page of the job that it follows"), "."] : [];
}
