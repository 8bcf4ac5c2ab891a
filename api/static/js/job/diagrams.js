// Diagrams that engineers draw of a test, such as compression over log stress or q over p′; each drawn when it is seen.
import { element, empty } from "../dom.js";
import { withUnit } from "../format.js";
import { get } from "../http.js";
import { paced } from "../pace.js";
import { colour, palette, plot } from "../plot.js";

export function diagrams(view) {
  const section = document.getElementById("diagrams");
  let asked = null,
    plots = [];

  // each is recalculated for a better evaluation
  const load = paced(async () => {
    const { objective } = view.job;
    if (objective === null || asked === objective) return;
    let items;
    try {
      ({ items } = await get(`/jobs/${view.id}/diagrams`));
    } catch (error) {
      if (error.status === 0) throw error;
      return void section.querySelector("div").replaceChildren(empty(error.message));
    }
    asked = objective;
    plots.forEach(({ remove }) => remove());
    section.hidden = items.length === 0;
    const frames = items.map(() => element("div", {}));
    section
      .querySelector("div")
      .replaceChildren(...frames.map((frame, i) => element("div", {}, element("h3", {}, headingOf(items[i])), frame)));
    plots = items.map((one, i) => plot(frames[i], () => figure(one)));
    plots.forEach(({ draw }, i) => paced(draw, 100, frames[i])());
  }, 5000);
  return { job: load };
}

/** "Compression curve", with the test it is of where there are several. */
export const headingOf = ({ heading, test }) => (test ? `${test}: ${heading.toLowerCase()}` : heading);

function figure(one) {
  const [across, up] = [withUnit(one.x_quantity, one.x_unit), withUnit(one.y_quantity, one.y_unit)];
  return {
    data: [
      {
        type: "scatter",
        mode: "markers",
        name: "measured",
        x: one.measured_x,
        y: one.measured_y,
        marker: { color: colour("--ink"), symbol: "circle-open", size: 7 },
      },
      { type: "scatter", mode: "lines", name: "best", x: one.x, y: one.y, line: { color: palette()[0], width: 2 } },
    ],
    layout: {
      xaxis: { title: { text: across }, type: one.log ? "log" : "linear" },
      yaxis: { title: { text: up }, autorange: one.downwards ? "reversed" : true },
      showlegend: true,
      height: 380,
    },
    label: `${headingOf(one)}: ${one.measured_x.length} measured points and the best evaluation, ${up} over ${across}`,
    columns: {
      [`measured: ${across}`]: one.measured_x,
      [`measured: ${up}`]: one.measured_y,
      [`best: ${across}`]: one.x,
      [`best: ${up}`]: one.y,
    },
  };
}
