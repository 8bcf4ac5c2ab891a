// Worker processes as a table.
import { element, empty } from "../dom.js";
import { age, count, duration, moment } from "../format.js";

export function workersTable(workers) {
  if (!workers.length) return empty("No worker has been seen lately: jobs wait until one is started (geoswarm worker).");
  const head = ["Worker", "State", "Runs", "For", "Started", "Last seen"];
  return element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "Workers" }, element("table", {},
    element("thead", {}, element("tr", {}, head.map((text) => element("th", { scope: "col" }, text)))),
    element("tbody", {}, workers.map(row))));
}

function row(worker) {
  const busy = worker.busy_since ? duration((Date.now() - new Date(worker.busy_since)) / 1000) : "–";
  return element("tr", {},
    element("th", { scope: "row" }, `${worker.host}, process ${worker.pid}`, element("br"), element("small", {}, `${worker.engine}, ${worker.id}`)),
    element("td", {}, element("span", { class: `state ${worker.state}` }, worker.state)),
    element("td", {}, ...work(worker)),
    element("td", {}, busy),
    element("td", {}, element("time", { datetime: worker.started_at, title: moment(worker.started_at) }, age(worker.started_at))),
    element("td", {}, element("time", { datetime: worker.seen_at, title: moment(worker.seen_at) }, age(worker.seen_at))));
}

function work({ state, job, generation, evaluations }) {
  if (state !== "busy") return ["–"];
  const many = `${count(evaluations)} evaluation${evaluations === 1 ? "" : "s"}`;
  return job ? [element("a", { href: `/jobs/${job}` }, `Job ${job}`), element("br"), element("small", {}, `generation ${generation}, ${many}`)] : [`a job of somebody else, ${many}`];
}
