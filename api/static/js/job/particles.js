// The particles of a generation, moving during the search: a pair of parameters, or all in parallel coordinates.
import { element, empty } from "../dom.js";
import { symbol } from "../format.js";
import { get } from "../http.js";
import { paced } from "../pace.js";
import { plot } from "../plot.js";
import { OBJECTIVE, pairPlot, parallelPlot } from "./particle_plots.js";

const INTERVAL = 1500,
  STEP = 500,
  KEPT = 400,
  LIMIT = 1000;

export function particles(view) {
  const place = document.getElementById("particles");
  const generations = new Map(); // number -> evaluations
  const shown = { kind: "pair", x: null, y: null, number: null, live: true };
  let made = null,
    slider = null,
    output = null,
    follow = null,
    play = null,
    playing = null;

  async function load(number) {
    if (number < 0) return [];
    if (!generations.has(number)) {
      const { items } = await get(`/jobs/${view.id}/evaluations`, { generation: number, limit: LIMIT });
      if (generations.size >= KEPT) generations.delete(generations.keys().next().value);
      generations.set(number, items);
    }
    return generations.get(number);
  }

  function build() {
    const names = view.job.free_parameters;
    const axes = [...names, OBJECTIVE];
    [shown.x, shown.y] = names.length > 1 ? names : axes;
    const choose = (key) =>
      element(
        "select",
        {
          onchange: ({ target }) => {
            shown[key] = target.value;
            draw();
          },
        },
        axes.map((name) =>
          element(
            "option",
            { value: name, selected: name === shown[key] },
            name === OBJECTIVE ? "objective" : symbol(name),
          ),
        ),
      );
    const pair = element(
      "div",
      { class: "controls" },
      element("label", {}, "Across", choose("x")),
      element("label", {}, "Up", choose("y")),
    );
    const kind = element(
      "select",
      {
        onchange: ({ target }) => {
          shown.kind = target.value;
          pair.hidden = target.value !== "pair";
          draw();
        },
      },
      element("option", { value: "pair" }, "two axes"),
      element("option", { value: "parallel" }, "parallel coordinates"),
    );
    slider = element("input", {
      type: "range",
      min: 0,
      max: 0,
      value: 0,
      oninput: () => {
        stop();
        go(Number(slider.value), false);
      },
    });
    output = element("output", {});
    follow = element("input", {
      type: "checkbox",
      checked: true,
      onchange: ({ target }) => {
        stop();
        shown.live = target.checked;
        if (shown.live) draw();
      },
    });
    play = element(
      "button",
      { type: "button", class: "quiet", onclick: () => (playing === null ? start() : stop()) },
      "Play",
    );
    const frame = element("div", {});
    place.replaceChildren(
      element("div", { class: "controls" }, element("label", {}, "Show", kind), pair),
      frame,
      element(
        "div",
        { class: "controls" },
        element("label", {}, "Generation", slider),
        output,
        play,
        element("label", { class: "beside" }, follow, "follow the newest"),
      ),
    );
    made = plot(frame, () => {
      const rows = generations.get(shown.number) ?? [],
        before = generations.get(shown.number - 1) ?? [];
      return shown.kind === "pair" ? pairPlot(view, rows, before, shown) : parallelPlot(view, rows, shown);
    });
  }

  function go(number, live) {
    shown.live = live;
    follow.checked = live;
    shown.number = number;
    return draw();
  }

  function start() {
    const last = newest();
    if (last < 1) return;
    play.textContent = "Stop";
    if (shown.number >= last) shown.number = -1;
    const jump = Math.max(1, Math.round(last / 120)); // a long search is shown within a minute
    const step = async () => {
      if (playing === null) return;
      await go(Math.min(shown.number + jump, newest()), false);
      if (shown.number >= newest()) stop();
      else if (playing !== null) playing = setTimeout(step, STEP);
    };
    playing = setTimeout(step, 0);
  }

  function stop() {
    clearTimeout(playing);
    playing = null;
    play.textContent = "Play";
  }

  const newest = () => view.course.at(-1)?.number ?? -1;

  const draw = paced(
    async () => {
      const last = newest();
      if (last < 0) return;
      if (!made) build();
      if (shown.live || shown.number === null) shown.number = last;
      slider.max = last;
      slider.value = shown.number;
      output.textContent = `${shown.number} of ${last}`;
      await Promise.all([load(shown.number), load(shown.number - 1)]);
      await made.draw();
    },
    100,
    place,
  );

  const live = paced(
    async () => {
      if (!made || shown.live) draw();
      else slider.max = newest();
    },
    INTERVAL,
    place,
  );

  if (!view.job.generations) place.replaceChildren(empty("No generation has finished yet."));
  return {
    course: draw,
    generation: live,
    fit: () => {
      if (made) draw();
    },
    job() {
      if (!view.job.retrying && generations.size) {
        generations.clear();
        if (made) draw();
      }
    },
  };
}
