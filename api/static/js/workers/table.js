// Worker processes as a table; the slots of an agent stand together, below what is true of all of them.
import { element, empty, tableHead, when, wide } from "../dom.js";
import { count, duration } from "../format.js";

const HEAD = ["Worker", "State", "Runs", "For", "Started", "Last seen"];

export function workersTable(workers, version) {
  if (!workers.length) return empty("No worker seen recently: jobs wait until one is started (geoswarm worker).");
  return wide(
    "Workers",
    element(
      "table",
      { class: "workers" },
      tableHead(HEAD),
      groups(workers).map((group) => body(group, version)),
    ),
  );
}

/** Processes one by one, the slots of each agent together, in the order in which they come. */
function groups(workers) {
  const found = new Map();
  for (const worker of workers) {
    const key = worker.agent?.id ?? worker.id;
    if (!found.has(key)) found.set(key, []);
    found.get(key).push(worker);
  }
  return [...found.values()];
}

function body(workers, version) {
  const [{ agent, host, pid, engine, id }] = workers;
  if (!agent) return element("tbody", {}, row(workers[0], [`${host}, process ${pid}`, line(`${engine}, ${id}`)]));
  const about = agentLines(agent, version);
  if (agent.slots === 1)
    return element(
      "tbody",
      {},
      workers.map((worker) => row(worker, [host, ...about])),
    );
  return element(
    "tbody",
    {},
    element(
      "tr",
      { class: "agent" },
      element("th", { scope: "rowgroup", colspan: String(HEAD.length) }, `${host}, ${agent.slots} slots`, ...about),
    ),
    workers.map((worker) => row(worker, [`slot ${Number(worker.id.split("/").pop()) + 1}`])),
  );
}

function row(worker, name) {
  const busy = worker.busy_since ? duration((Date.now() - new Date(worker.busy_since)) / 1000) : "–";
  return element(
    "tr",
    {},
    element("th", { scope: "row" }, ...name),
    element("td", { class: "is" }, element("span", { class: `state ${worker.state}` }, worker.state)),
    element("td", { class: worker.state === "busy" ? "runs" : "runs nothing" }, ...work(worker)),
    element("td", { class: "for" }, busy),
    element("td", { class: "started", "data-label": "started" }, when(worker.started_at)),
    element("td", { class: "seen", "data-label": "seen" }, when(worker.seen_at)),
  );
}

const line = (...parts) => element("small", {}, ...parts);

/** What an agent is: its name, its machine, its version, its registered models. */
function agentLines(agent, version) {
  const models = Object.entries(agent.models);
  const other = version && agent.version !== version;
  return [
    line(`agent ${agent.id}`),
    line(
      `${agent.system}, geoswarm ${agent.version}`,
      ...(other ? [" ", element("span", { class: "other" }, `(the service has ${version}: no built-in models)`)] : []),
    ),
    ...(models.length
      ? [
          line(
            "models ",
            models.flatMap(([name, hash], index) => [
              index ? ", " : "",
              element("span", { title: `version ${hash}` }, `${name} (${hash.slice(0, 8)})`),
            ]),
          ),
        ]
      : []),
  ];
}

function work({ state, job, generation, evaluations }) {
  if (state !== "busy") return ["–"];
  const many = `${count(evaluations)} evaluation${evaluations === 1 ? "" : "s"}`;
  return job
    ? [element("a", { href: `/jobs/${job}` }, `Job ${job}`), line(`generation ${generation}, ${many}`)]
    : [`a job of somebody else, ${many}`];
}
