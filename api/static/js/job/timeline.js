// When each worker ran an evaluation, and which of them failed.
import { element, empty, exchange, svg } from "../dom.js";
import { count, duration } from "../format.js";
import { get } from "../http.js";
import { paced } from "../pace.js";
import { ENDED } from "../states.js";
import { ticks } from "../scales.js";
import { openEvaluation } from "./evaluation.js";

const LIMIT = 1000,
  INTERVAL = 5000,
  LANE = 22,
  TOP = 4,
  BOTTOM = 22; // px

export function timeline(view) {
  const place = document.getElementById("timeline");

  const draw = paced(
    async () => {
      const { items, next_cursor: more } = await get(`/jobs/${view.id}/evaluations`, { limit: LIMIT });
      const runs = items
        .filter(({ started_at, finished_at }) => started_at && finished_at)
        .map((one) => ({ ...one, from: Date.parse(one.started_at) / 1000, to: Date.parse(one.finished_at) / 1000 }));
      if (!runs.length) return void exchange(place, empty("No run has ended yet."));
      const start = Math.min(...runs.map(({ from }) => from)),
        length = Math.max(...runs.map(({ to }) => to)) - start || 1;
      const workers = [...new Set(runs.map(({ worker }) => worker ?? "unknown"))].sort();
      const height = TOP + LANE * workers.length + BOTTOM,
        bottom = height - BOTTOM;
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
          `${count(runs.length)} runs on ${workers.length === 1 ? "one worker" : `${workers.length} workers`} in ${duration(length)}${failed ? `, ${count(failed)} of them failed` : ""}.${more ? ` These are the first ${LIMIT}.` : ""}`,
        ),
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
            ticks(0, length, "linear", 6).map((seconds) => [
              svg("line", { class: "grid", x1: at(seconds), x2: at(seconds), y1: TOP, y2: bottom }),
              svg("text", { x: at(seconds), y: bottom + 15 }, duration(seconds)),
            ]),
            runs.map(bar),
          ),
        ),
      );
    },
    INTERVAL,
    place,
  );
  return {
    job: draw,
    generation: () => {
      if (!ENDED.has(view.job.state)) draw();
    },
  };
}
