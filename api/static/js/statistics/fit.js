// Measured points, the best fit, and what the chosen evaluations span.
import { element } from "../dom.js";
import { count, direction, withUnit } from "../format.js";
import { colour, palette, plot } from "../plot.js";

const MOST_NUMBERS = 2e7;

/** Whether responses of all evaluations are worth fetching for the band. */
export function affordable(points) {
  return points.series.reduce((sum, { x }) => sum + x.length, 0) * points.count <= MOST_NUMBERS;
}

export class FitPlot {
  constructor(holder, series) {
    this.series = series;
    this.index = 0;
    this.responses = null;
    const choose = element(
      "select",
      {
        "aria-label": "Series",
        onchange: () => {
          this.index = choose.selectedIndex;
          this.draw();
        },
      },
      series.map(({ name }) => element("option", {}, name)),
    );
    this.place = element("div");
    this.note = element("p", { class: "help" });
    holder.replaceChildren(
      series.length > 1 ? element("p", {}, element("label", {}, "Series ", choose)) : "",
      this.place,
      this.note,
    );
    this.plot = plot(this.place, () => this.figure());
  }

  /** `responses` of all evaluations, null while they are not there. */
  update(cloud, chosen, responses) {
    Object.assign(this, { cloud, chosen, responses });
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.draw(), 60);
  }

  draw() {
    return this.plot.draw();
  }

  figure() {
    const {
      name,
      x,
      y,
      x_quantity: across,
      y_quantity: up,
      shown: [xUnit, xFactor, yUnit, yFactor],
    } = this.series[this.index];
    const found = this.responses?.[name];
    const order = x.map((_, i) => i).sort((a, b) => x[a] - x[b]);
    const sorted = (values, factor = yFactor) => order.map((i) => values[i] * factor); // in the units of the data
    const sortedX = sorted(x, xFactor);
    const row = (n) => Array.from(found.values.subarray(n * found.width, (n + 1) * found.width));
    const [blue, orange] = palette();
    const data = [];
    const columns = { [withUnit(across, xUnit)]: sortedX, [withUnit("measured", yUnit)]: sorted(y) };
    const many = x.length > 60;
    let told = "The calculated values are being read …";
    if (found && this.chosen.length) {
      const low = new Array(found.width).fill(Infinity),
        high = new Array(found.width).fill(-Infinity);
      for (const n of this.chosen) {
        for (let i = 0, k = n * found.width; i < found.width; i += 1, k += 1) {
          const value = found.values[k];
          if (value < low[i]) low[i] = value;
          if (value > high[i]) high[i] = value;
        }
      }
      const band = { x: sortedX, mode: "lines", line: { width: 0.5, color: blue }, hoverinfo: "skip" };
      data.push({ ...band, y: sorted(low), showlegend: false });
      data.push({
        ...band,
        y: sorted(high),
        fill: "tonexty",
        fillcolor: blue.replace("rgb(", "rgba(").replace(")", ", 0.25)"),
        name: `${count(this.chosen.length)} chosen evaluations`,
      });
      const first = row(this.chosen[0]);
      const whole = this.cloud.ranges.size ? "best of the chosen" : "best fit";
      data.push({ x: sortedX, y: sorted(first), mode: "lines", name: whole, line: { color: orange, width: 2 } });
      Object.assign(columns, { "lowest chosen": sorted(low), "highest chosen": sorted(high), [whole]: sorted(first) });
      told = "The band spans the chosen evaluations: move the threshold or draw a rectangle in the matrix plot.";
    } else if (found) told = "No evaluation is chosen.";
    data.push({
      x: sortedX,
      y: sorted(y),
      mode: "markers",
      name: "measured",
      marker: { color: colour("--ink"), size: many ? 4 : 7, symbol: "circle-open", line: { width: 1.5 } },
    });
    this.note.textContent = told;
    return {
      data,
      layout: {
        height: 360,
        xaxis: { title: { text: withUnit(across, xUnit) } },
        yaxis: { title: { text: withUnit(up, yUnit) }, ...direction(name, up) },
      },
      label: `Fit of ${name}: measured, best fit, and the band of ${this.chosen.length} chosen evaluations`,
      columns,
    };
  }
}
