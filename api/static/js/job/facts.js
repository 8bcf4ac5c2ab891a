// The numbers at the top, and the parameters of the best evaluation.
import { element, empty } from "../dom.js";
import { amount, count, duration, number, symbol, withUnit } from "../format.js";
import { ENDED } from "../states.js";

const words = (name) => name.replaceAll("_", " ");
const HOW = { free: "searched", fixed: "fixed", linked: "linked" };

export function facts(view) {
  const field = (name) => document.querySelector(`[data-field=${name}]`);
  const set = (name, text) => { if (field(name).textContent !== text) field(name).textContent = text; };
  let read = performance.now();

  function show() {
    const { job } = view;
    set("objective", number(job.objective, 6));
    set("evaluations", count(job.evaluations) + (job.max_evaluations ? ` / ${count(job.max_evaluations)}` : ""));
    set("failed", count(job.failed_evaluations));
    set("generations", count(job.generations));
    const bar = document.getElementById("progress");
    bar.hidden = !job.max_evaluations;
    if (job.max_evaluations) bar.value = Math.min(job.evaluations / job.max_evaluations, 1);
    parameters();
  }

  function clock() {
    const { job } = view;
    if (job.seconds === null) return;
    set("seconds", duration(job.seconds + (job.state === "running" ? (performance.now() - read) / 1000 : 0)));
  }

  function parameters() {
    const place = document.getElementById("parameters"), { job } = view;
    if (!job.parameters) return void place.replaceChildren(empty("No successful evaluation yet."));
    const infos = new Map((view.fit?.parameters ?? []).map((info) => [info.name, info]));
    const rows = Object.entries(job.parameters).map(([name, value]) => {
      const info = infos.get(name);
      const range = info?.form === "free" ? `${number(info.lower)} … ${number(info.upper)}${info.scale === "log" ? " (log)" : ""}` : info?.expression ?? "";
      return element("tr", {},
        element("td", {}, withUnit(symbol(name), info?.unit), symbol(name) === name ? null : element("small", {}, ` ${name}`)),
        element("td", { class: "n" }, number(value, 6)),
        element("td", {}, info ? HOW[info.form] : job.free_parameters.includes(name) ? "searched" : "given"),
        element("td", { class: "n" }, range));
    });
    place.replaceChildren(element("table", {},
      element("thead", {}, element("tr", {}, ["Parameter", "Value", "How", "Search range"].map((head, i) => element("th", { scope: "col", class: i % 2 ? "n" : null }, head)))),
      element("tbody", {}, rows)));
  }

  setInterval(() => { if (!document.hidden && !ENDED.has(view.job.state)) clock(); }, 1000);
  return {
    job({ state, retrying, stop_reasons: reasons }) {
      read = performance.now();
      const badge = document.querySelector("h1 .state");
      badge.className = `state ${state}`;
      badge.textContent = retrying ? `${state} (failed evaluations again)` : state;
      document.querySelector("main").dataset.state = state;
      set("stopped", reasons.map(words).join(", ") || "–");
      show();
      clock();
    },
    generation: show,
    fit() {
      document.querySelector("[data-unit]").textContent = view.fit.objective_unit ? `[${view.fit.objective_unit}]` : "";
      const best = view.fit.curves.find(({ role }) => role === "best");
      field("deviation").replaceChildren(...(best?.shares ?? []).map(({ series, root_mean_square: value, unit }) =>
        element("div", {}, best.shares.length > 1 ? `${words(series)} ` : "", amount(value, unit))));
      parameters();
    },
  };
}
