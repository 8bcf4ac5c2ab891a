// What runs now: every finished run at once, time left, the workers; in the tab's title, and as a notification when asked.
import { element, exchange } from "../dom.js";
import { count, duration, number } from "../format.js";
import { get } from "../http.js";
import { translate } from "../language.js";
import { LATER } from "../pace.js";
import { ENDED, OPEN } from "../states.js";

const INTERVAL = 2000,
  WORKERS = 6000;
const MARKS = { queued: "…", paused: "❚❚", finished: "✓", failed: "✗", cancelled: "■" };

export function progress(view) {
  const place = document.getElementById("live"),
    bar = document.getElementById("progress");
  const now = document.getElementById("now"),
    crew = document.getElementById("crew");
  let timer = null,
    busy = false,
    told = false,
    workers = [],
    asked = -Infinity;

  const tellMe =
    "Notification" in window
      ? element("button", { type: "button", class: "quiet small", onclick: ask }, "Tell me when it ends")
      : null;
  async function ask() {
    told = (await Notification.requestPermission()) === "granted";
    tellMe.textContent = told ? "You will be notified when the job ends" : "The browser does not allow notifications";
    tellMe.disabled = true;
  }

  async function look() {
    clearTimeout(timer);
    if (busy || !OPEN.has(view.job.state)) return;
    let pause = INTERVAL;
    if (!document.hidden) {
      busy = true;
      try {
        if (Date.now() - asked > WORKERS) {
          ({ items: workers } = await get("/workers"));
          asked = Date.now();
        }
        const found = await get(`/jobs/${view.id}/progress`);
        if (OPEN.has(view.job.state)) show(found);
      } catch (error) {
        if (error.status === 404) return; // deleted meanwhile
        pause = LATER; // the stream reports a lost connection
      } finally {
        busy = false;
      }
    }
    timer = setTimeout(look, pause);
  }

  function show(found) {
    const { job } = view,
      { search_evaluations: searched, answer_evaluations: following } = found;
    const planned =
      searched === null ? job.max_evaluations : Math.min(searched + following, job.max_evaluations ?? Infinity);
    const here = found.pending + found.running + found.finished + found.failed;
    const counted = planned
      ? `${count(found.evaluations)} of ${count(planned)} runs have ended`
      : `${count(found.evaluations)} runs have ended`;
    const parts = [
      searched === null || job.retrying
        ? counted
        : `search ended after ${count(searched)} runs, intervals: ${count(found.evaluations - searched)} of at most ${count(planned - searched)}`,
      here
        ? `generation ${found.generation + 1}: ${count(found.finished + found.failed)} of ${count(here)}${found.running ? `, ${count(found.running)} running` : ""}`
        : null,
      found.objective === null
        ? found.evaluations
          ? "none has succeeded yet"
          : null
        : `lowest objective ${number(found.objective)}`,
      found.seconds_left === null
        ? null
        : `${found.seconds_left < 1 ? "less than 1 s" : `at most ${duration(found.seconds_left)}`} left`,
      job.state === "queued" ? "waiting for a worker" : null,
    ];
    const text = `${parts.filter(Boolean).join(" · ")}.`;
    if (now.textContent !== text) now.textContent = text;
    bar.hidden = !planned;
    if (planned) bar.value = Math.min(found.evaluations / planned, 1);
    title(planned ? found.evaluations / planned : null);
    const mine = workers.filter((one) => one.job === view.id),
      free = workers.filter(({ state }) => state === "idle").length;
    exchange(
      crew,
      element(
        "ul",
        { class: "crew", "aria-label": "Workers of this job" },
        mine.map((one) =>
          element(
            "li",
            { title: `${one.host}, process ${one.pid}` },
            element("span", { class: "state running" }, `${one.evaluations} run${one.evaluations === 1 ? "" : "s"}`),
            ` ${one.host.slice(0, 16)}`,
          ),
        ),
        element(
          "li",
          { class: "help" },
          `${mine.length} worker${mine.length === 1 ? "" : "s"} on this job, ${free} free`,
        ),
      ),
      tellMe,
    );
  }

  function title(share = null) {
    const { name, state } = view.job;
    const mark =
      state === "running" ? (share === null ? "▶" : `${Math.floor(100 * Math.min(share, 1))} %`) : MARKS[state];
    document.title = `${mark} ${name} · geoswarm`;
  }

  let before = null;
  document.addEventListener("visibilitychange", () => document.hidden || look());
  return {
    job({ state, name }) {
      place.hidden = !OPEN.has(state);
      title();
      if (ENDED.has(state) && before !== null && !ENDED.has(before) && told)
        new Notification(`${name}: ${translate(state)}`);
      if (before !== state && OPEN.has(state)) look();
      before = state;
    },
    generation: look,
  };
}
