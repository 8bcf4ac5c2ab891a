// What an operator watches: queue, workers, and how forward runs have ended.
import { element } from "../dom.js";
import { count, duration, percent } from "../format.js";

const KINDS = {
  finished: "finished",
  diverged: "diverged",
  timeout: "too slow",
  killed_memory: "too much memory",
  worker_lost: "process lost",
  bad_output: "bad output",
  not_finite: "not finite",
  infeasible: "not admissible",
};

export function operations({
  jobs,
  waiting,
  running,
  oldest_wait: wait,
  workers,
  outcomes,
  lost_evaluations: lost,
  event_streams: streams,
}) {
  const figures = [
    ["Evaluations waiting", count(waiting)],
    ["Evaluations running", count(running)],
    ["Longest wait of a job", wait > 0 ? duration(wait) : "none"],
    ["Jobs queued", count(jobs.queued ?? 0)],
    ["Jobs running", count(jobs.running ?? 0)],
    ["Jobs ended", count((jobs.finished ?? 0) + (jobs.failed ?? 0) + (jobs.cancelled ?? 0))],
    ["Workers busy, idle, lost", `${workers.busy}, ${workers.idle}, ${workers.lost}`],
    ["Runs taken from lost workers", count(lost)],
    ["Open event streams", count(streams)],
  ];
  const total = Object.values(outcomes).reduce((sum, number) => sum + number, 0);
  const kinds = Object.entries(outcomes).sort(([a, n], [b, m]) => (b === "finished") - (a === "finished") || m - n);
  return element(
    "div",
    {},
    element(
      "dl",
      { class: "figures" },
      figures.map(([name, value]) => element("div", {}, element("dt", {}, name), element("dd", {}, value))),
    ),
    element("h3", {}, "How forward runs have ended"),
    total === 0
      ? element("p", { class: "empty" }, "No forward run has been counted yet.")
      : element(
          "div",
          { class: "bars" },
          kinds.map(([kind, number]) => bar(KINDS[kind] ?? kind, number, total)),
        ),
    element(
      "p",
      { class: "help" },
      "Since the installation was made; workers add what they have counted every few seconds.",
    ),
  );
}

function bar(name, number, total) {
  const share = number / total;
  return element(
    "div",
    {},
    element("span", {}, name),
    element("meter", { min: 0, max: 1, value: share, "aria-label": `${name}: ${percent(share, 1)}` }),
    element("span", { class: "n" }, `${count(number)} (${percent(share, 1)})`),
  );
}
