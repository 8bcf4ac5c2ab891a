// Convergence: lowest objective so far, and the best of every generation, logarithmic.
import { empty } from "../dom.js";
import { withUnit } from "../format.js";
import { paced } from "../pace.js";
import { colour, palette, plot } from "../plot.js";
import { thinned } from "../scales.js";

const MOST = 1500,
  INTERVAL = 500;

export function convergence(view) {
  const place = document.getElementById("convergence");
  let made = null;

  function content() {
    const lowered = (item, i) => i > 0 && item.objective !== view.course[i - 1].objective;
    const shown = thinned(view.course, MOST, lowered);
    const x = shown.map(({ evaluations }) => evaluations);
    const positive = (f) => (f > 0 ? f : null);
    return {
      data: [
        {
          type: "scatter",
          mode: "markers",
          name: "best of a generation",
          x,
          y: shown.map((one) => positive(one.best_objective)),
          marker: { color: colour("--muted"), size: 5, opacity: 0.6 },
        },
        {
          type: "scatter",
          mode: "lines",
          name: "best so far",
          x,
          y: shown.map((one) => positive(one.objective)),
          line: { shape: "hv", color: palette()[0], width: 2.5 },
        },
      ],
      layout: {
        xaxis: { title: { text: "evaluations" }, rangemode: "tozero" },
        yaxis: { title: { text: withUnit("objective", view.fit?.objective_unit) }, type: "log" },
        showlegend: true,
        height: 340,
        uirevision: "kept",
      },
      label: "Objective over evaluations, logarithmic: lowest so far and best of each generation",
      columns: {
        evaluations: x,
        "best so far": shown.map((one) => one.objective),
        "best of the generation": shown.map((one) => one.best_objective),
      },
    };
  }

  const draw = paced(
    async () => {
      if (!view.course.some(({ objective }) => objective !== null)) {
        place.replaceChildren(
          empty(view.course.length ? "No evaluation has succeeded yet." : "No generation has finished yet."),
        );
        made = null;
        return;
      }
      made ??= plot(place, content);
      await made.draw();
    },
    INTERVAL,
    place,
  );
  return { course: draw, generation: draw, fit: draw };
}
