// What a job has done, in numbers.
import { count, duration, number, plain } from "../format.js";
import { ENDED } from "../states.js";

export function facts(view) {
  const field = (name) => document.querySelector(`[data-field=${name}]`);
  const set = (name, text) => {
    if (field(name).textContent !== text) field(name).textContent = text;
  };
  let read = performance.now();

  function show() {
    const { job } = view;
    set("objective", number(job.objective));
    set("evaluations", count(job.evaluations) + (job.max_evaluations ? ` / ${count(job.max_evaluations)}` : ""));
    set("failed", count(job.failed_evaluations));
    set("generations", count(job.generations));
  }

  function clock() {
    const { job } = view;
    if (job.seconds === null) return;
    set("seconds", duration(job.seconds + (job.state === "running" ? (performance.now() - read) / 1000 : 0)));
  }

  setInterval(() => {
    if (!document.hidden && !ENDED.has(view.job.state)) clock();
  }, 1000);
  return {
    job({ stop_reasons: reasons }) {
      read = performance.now();
      set("stopped", reasons.map(plain).join(", ") || "–");
      show();
      clock();
    },
    generation: show,
    fit() {
      document.querySelector("[data-unit]").textContent = view.fit.objective_unit ? `[${view.fit.objective_unit}]` : "";
    },
  };
}
