// Several jobs side by side: facts, parameters, convergence, fits.
import { drawConvergences, drawFits } from "./compare/plots.js";
import { ranking } from "./compare/ranking.js";
import { factsTable, parametersTable } from "./compare/tables.js";
import { connection, element, empty, exchange, failure } from "./dom.js";
import { get } from "./http.js";
import { translate } from "./language.js";
import { ENDED } from "./states.js";

const INTERVAL = 4000,
  MOST = 6,
  LISTED = 100,
  POINTS = 1000;
const ids = document.querySelector("main").dataset.jobs.split(" ").filter(Boolean);
const content = document.getElementById("content");

async function load(id, before) {
  const job = await get(`/jobs/${id}`);
  if (before && before.job.last_event === job.last_event) return { ...before, job };
  const better = before?.job.objective !== job.objective || before?.fit === undefined;
  const [{ items: course }, fit] = await Promise.all([
    get(`/jobs/${id}/generations`, { points: POINTS, limit: POINTS }),
    better ? get(`/jobs/${id}/fit`) : before.fit,
  ]);
  return { job, course, fit };
}

async function run() {
  const places = Object.fromEntries(
    ["facts", "parameters", "convergence", "fits"].map((name) => [name, element("div", { id: name })]),
  );
  content.replaceChildren(
    places.facts,
    element("p", { id: "ranking", class: "help", role: "status" }),
    element("h2", {}, "Parameters at the best objective"),
    places.parameters,
    element("h2", {}, "Convergence"),
    places.convergence,
    element("h2", {}, "Fits"),
    places.fits,
  );
  for (const place of Object.values(places)) place.replaceChildren(empty("Loading …"));
  let loaded = [],
    told = null,
    rank = null,
    convergence = null,
    fits = null;
  const show = async () => {
    loaded = await Promise.all(ids.map((id, i) => load(id, loaded[i])));
    connection(null);
    const now = loaded.map(({ job }) => job.objective).join();
    if (now !== told) rank = await ranking(loaded);
    told = now;
    document.getElementById("ranking").textContent = rank.why;
    exchange(places.facts, factsTable(loaded, rank));
    exchange(places.parameters, parametersTable(loaded));
    loaded.forEach(({ job }, i) => {
      const state = document.querySelectorAll(".chosen .state")[i];
      state.className = `state ${job.state}`;
      state.textContent = job.state;
    });
    convergence ??= drawConvergences(places.convergence);
    fits ??= drawFits(places.fits);
    await Promise.all([convergence(loaded), fits(loaded)]);
  };
  await show();
  const timer = setInterval(async () => {
    if (document.hidden) return;
    try {
      await show();
      if (loaded.every(({ job }) => ENDED.has(job.state) && !job.retrying)) clearInterval(timer);
    } catch (error) {
      connection(error.status ? error.message : "Connection lost; trying again …");
    }
  }, INTERVAL);
}

async function offer() {
  const form = document.getElementById("add"),
    select = document.getElementById("another");
  if (ids.length >= MOST) return;
  const { items } = await get("/jobs", { limit: LISTED });
  const others = items.filter(({ id }) => !ids.includes(id));
  if (!others.length) return;
  select.replaceChildren(
    ...others.map((job) =>
      element(
        "option",
        { value: job.id, translate: "no" },
        `${job.name} (${translate(job.state)}, ${job.id.slice(0, 6)})`,
      ),
    ),
  );
  form.hidden = false;
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    location.assign(`/compare?${new URLSearchParams([...ids, select.value].map((id) => ["job", id]))}`);
  });
}

offer().catch(() => {}); // without it jobs are chosen in the list
if (ids.length >= 2) run().catch((error) => content.replaceChildren(failure(error)));
