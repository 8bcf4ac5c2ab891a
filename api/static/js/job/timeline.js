// When each worker ran an evaluation, and which of them failed.
import { announce, element, empty, exchange, svg } from "../dom.js";
import { count, duration, number } from "../format.js";
import { get } from "../http.js";
import { paced } from "../pace.js";
import { ENDED } from "../states.js";
import { ticks } from "../scales.js";
import { openEvaluation } from "./evaluation.js";

const LIMIT = 1000,
  INTERVAL = 5000,
  LANE = 22,
  TOP = 4,
  BOTTOM = 22,
  NARROW = 480; // px

export function timeline(view) {
  const place = document.getElementById("timeline");
  let parts = [{ cursor: null, begin: 0 }]; // of the history: the first one, and those after it up to what is seen

  async function show() {
    const { items, next_cursor: more } = await get(`/jobs/${view.id}/evaluations`, {
      limit: LIMIT,
      cursor: parts.at(-1).cursor,
    });
    const { begin } = parts.at(-1);
    const runs = items
      .filter(({ started_at, finished_at }) => started_at && finished_at)
      .map((one) => ({ ...one, from: Date.parse(one.started_at) / 1000, to: Date.parse(one.finished_at) / 1000 }));
    if (!runs.length) return void exchange(place, empty("No run has ended yet."));
    const start = Math.min(...runs.map(({ from }) => from)),
      length = Math.max(...runs.map(({ to }) => to)) - start || 1;
    const workers = [...new Set(runs.map(({ worker }) => worker ?? "unknown"))].sort();
    const height = TOP + LANE * workers.length + BOTTOM,
      bottom = height - BOTTOM;
    const busy = runs.reduce((sum, { from, to }) => sum + to - from, 0) / (workers.length * length);
    const pace = `${number((60 * runs.length) / length, 3)} runs a minute; workers calculated for ${Math.round(100 * Math.min(1, busy))} % of the time.`;
    const at = (seconds) => `${((100 * seconds) / length).toFixed(3)}%`;
    const failed = runs.filter(({ state }) => state === "failed").length;
    const bar = (one) =>
      svg(
        "rect",
        {
          class: one.state,
          x: at(one.from - start),
          width: `${Math.max((100 * (one.to - one.from)) / length, 0.15).toFixed(3)}%`,
          y: TOP + LANE * workers.indexOf(one.worker ?? "unknown") + 3,
          height: LANE - 6,
          onclick: () => openEvaluation(view, one.generation, one.particle),
        },
        svg("title", {}, `${one.generation} · ${one.particle}: ${one.state}, ${duration(one.to - one.from)}`),
      );
    exchange(
      place,
      element(
        "p",
        { class: "help" },
        `${count(runs.length)} runs on ${workers.length === 1 ? "one worker" : `${workers.length} workers`} in ${duration(length)}${failed ? `, ${count(failed)} of them failed` : ""}. ${pace}${more || begin ? ` These are runs ${count(begin + 1)} to ${count(begin + items.length)} of ${count(Math.max(view.job.evaluations, begin + items.length))}.` : ""}`,
      ),
      more || begin
        ? element(
            "p",
            { class: "buttons" },
            turn("First", !begin, parts.slice(0, 1)),
            turn("Earlier", !begin, parts.slice(0, -1)),
            turn("Later", !more, [...parts, { cursor: more, begin: begin + items.length }]),
          )
        : null,
      element(
        "div",
        { class: "lanes" },
        element(
          "ol",
          { "aria-label": "Workers" },
          workers.map((name) => element("li", { title: name }, name)),
        ),
        svg(
          "svg",
          {
            height,
            width: "100%",
            role: "img",
            "aria-label": `Runs of ${workers.length} workers over ${duration(length)}; ${count(failed)} failed`,
          },
          ticks(0, length, "linear", place.clientWidth < NARROW ? 3 : 6).map((seconds) => [
            svg("line", { class: "grid", x1: at(seconds), x2: at(seconds), y1: TOP, y2: bottom }),
            svg("text", { x: at(seconds), y: bottom + 15 }, duration(seconds)),
          ]),
          runs.map(bar),
        ),
      ),
    );
  }
  const turn = (words, disabled, chosen) =>
    element("button", { type: "button", class: "quiet", disabled, onclick: () => look(chosen) }, words);

  const draw = paced(show, INTERVAL, place);

  /** Look at another part of the history. */
  function look(chosen) {
    parts = chosen;
    show().catch(({ message }) => announce(message));
  }

  return {
    job: draw,
    generation: () => {
      if (!ENDED.has(view.job.state)) draw();
    },
  };
}
