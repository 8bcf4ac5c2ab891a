// What the response surface of the stored runs says: importance, contours of two parameters, slices of all; no further runs.
import { announce, element, empty, exchange } from "../dom.js";
import { amount, count, number, percent, symbol, typeset, withUnit } from "../format.js";
import { get } from "../http.js";
import { colour, palette, plot } from "../plot.js";
import { COLOURS, tickText } from "../scales.js";

const LEVELS = [1, 2, 5, 10, 20, 50, 100, 200, 500, 1000];
const OTHERS = "run, with other values of the rest";
const NARROW = 720,
  ROW = 240,
  PAIR = 560,
  TOP = { narrow: 1000, wide: 420 }; // px

/** How far the surface misses f. */
function missed(error) {
  if (error === null) return "more than can be told";
  return error < 0.001 ? "less than 0.1 %" : percent(error, error < 0.1 ? 1 : 0);
}

/** `parameters`: of the points, with unit and scale; `unit`: of the objective. */
export class Surface {
  constructor(holder, { job, parameters, unit }) {
    Object.assign(this, { job, parameters, unit });
    this.names = parameters.map(({ name }) => name);
    [this.x, this.y] = this.names;
    this.said = element("div");
    this.places = Object.fromEntries(
      ["importance", "contours", "slices"].map((kind) => [kind, element("div", { class: kind })]),
    );
    this.plots = {};
    holder.append(this.said, ...Object.values(this.places));
    this.holder = holder;
    this.narrow = () => holder.clientWidth < NARROW;
    this.columns = () => Math.min(this.narrow() ? 1 : 3, this.names.length);
    const rows = Math.ceil(this.names.length / this.columns());
    holder.style.setProperty(
      "min-height",
      `${TOP[this.narrow() ? "narrow" : "wide"] + (this.names.length > 1 ? PAIR : 0) + ROW * rows}px`,
    ); // else what is below moves
  }

  /** Read it again: the runs are others now. */
  async show() {
    try {
      this.found = await get(`/jobs/${this.job}/surface`, { x: this.x, y: this.y });
    } catch (error) {
      const { message } = error;
      for (const place of Object.values(this.places)) place.replaceChildren();
      this.plots = {};
      this.holder.style.removeProperty("min-height");
      return exchange(this.said, empty(`${message[0].toUpperCase()}${typeset(message.slice(1)).replace(/\.$/, "")}.`));
    }
    this.tell();
    if (this.found.importance) this.figure("importance", "What matters most?", () => this.importance());
    if (this.found.contours) this.figure("contours", "Two parameters together", () => this.contours(), this.chooser());
    this.figure("slices", "Each parameter alone, the others as in the best run", () => this.slices());
  }

  tell() {
    const { evaluations, error, checked, trusted, limit, objective } = this.found;
    const left = `For runs left out of it, it misses f by ${missed(error)} (root mean square, ${count(checked)} runs)`;
    exchange(
      this.said,
      element(
        "p",
        { class: "help" },
        `A response surface of ${count(evaluations)} stored runs, cut through the best one; no further runs. ${trusted ? `${left}. ` : ""}f is shown over ${amount(limit, this.unit)}, the limit up to which the data cannot tell a fit from the best one (${amount(objective, this.unit)})${trusted ? ": below 1 fits are alike. Blank: not known, as no run came near, runs failed there, or a constraint forbids it" : ""}.`,
      ),
      trusted
        ? null
        : element(
            "p",
            { class: "poor" },
            `${left}: too much for a surface to be drawn. What follows are the runs alone; more runs near the best one would help.`,
          ),
    );
  }

  figure(kind, title, make, ...controls) {
    const place = this.places[kind];
    if (!this.plots[kind]) {
      const frame = element("div");
      place.replaceChildren(element("h3", {}, title), ...controls.filter(Boolean), frame);
      this.plots[kind] = plot(frame, make);
    }
    this.plots[kind].draw();
  }

  /** Which two parameters; with two there is nothing to choose. */
  chooser() {
    if (this.names.length < 3) return null;
    const choose = (key, other) =>
      element(
        "select",
        {
          onchange: ({ target }) => {
            if (target.value === this[other]) this[other] = selects[other].value = this[key];
            this[key] = target.value;
            this.show().catch(({ message }) => announce(message));
          },
        },
        this.names.map((name) => element("option", { value: name, selected: name === this[key] }, symbol(name))),
      );
    const selects = { x: choose("x", "y"), y: choose("y", "x") };
    return element(
      "div",
      { class: "controls" },
      element("label", {}, "Across", selects.x),
      element("label", {}, "Up", selects.y),
    );
  }

  title(name) {
    return withUnit(symbol(name), this.parameters.find((one) => one.name === name).unit);
  }

  axis(name, values) {
    const log = this.parameters.find((one) => one.name === name).scale === "log";
    const ends = [values[0], values.at(-1)].map((end) => (log ? Math.log10(end) : end));
    return { title: { text: this.title(name) }, type: log ? "log" : "linear", range: ends };
  }

  ratios(objectives) {
    return objectives.map((f) => (f === null ? null : Math.max(f / this.found.limit, 1e-6)));
  }

  /** Runs over one or two parameters, in the colour of their f; those that failed are crosses. */
  runs(x, y, { colours, ...more }) {
    const { parameters, objectives } = this.found.runs;
    const good = objectives.map((f, i) => i).filter((i) => objectives[i] !== null);
    const bad = objectives.map((f, i) => i).filter((i) => objectives[i] === null);
    const level = this.ratios(objectives);
    const of = (rows, name) => rows.map((i) => (name === null ? level[i] : parameters[name][i]));
    const text = good.map((i) => `f = ${number(objectives[i])}`);
    return [
      {
        type: "scatter",
        mode: "markers",
        name: "run",
        x: of(good, x),
        y: of(good, y),
        text,
        hoverinfo: "text",
        marker: { size: 6, line: { color: colour("--ink"), width: 0.7 }, ...colours(good.map((i) => level[i])) },
        ...more,
      },
      ...(y === null || !bad.length
        ? []
        : [
            {
              type: "scatter",
              mode: "markers",
              name: "failed run",
              x: of(bad, x),
              y: of(bad, y),
              hoverinfo: "name",
              marker: { symbol: "x-thin", size: 9, line: { color: colour("--bad"), width: 2 } },
            },
          ]),
    ];
  }

  contours() {
    const { contours, best, limit, runs, trusted } = this.found;
    const { x, y, x_values: across, y_values: up, objectives } = contours;
    const z = objectives.map((row) => this.ratios(row).map((ratio) => ratio && Math.log10(ratio)));
    const top = Math.max(...z.flat().filter((value) => value !== null), Math.log10(this.found.trusted ? 2 : 20));
    const shown = LEVELS.filter((level) => Math.log10(level) <= top);
    const scale = COLOURS.map((paint, i) => [i / (COLOURS.length - 1), paint]);
    const colorbar = {
      title: { text: "f over the limit", side: "right" },
      tickvals: shown.map(Math.log10),
      ticktext: shown.map(tickText),
      thickness: 12,
      outlinewidth: 0,
      tickfont: { color: colour("--ink") },
    };
    const scaled = { colorscale: scale, cmin: 0, cmax: top };
    const cells = up.flatMap((to, j) => across.map((at, i) => [at, to, objectives[j][i]]));
    const filled = [
      {
        type: "contour",
        x: across,
        y: up,
        z,
        zmin: 0,
        zmax: top,
        colorscale: scale,
        connectgaps: false,
        contours: { start: 0, end: top, size: top / 12, showlines: false },
        hovertemplate: `${symbol(x)} = %{x:.4g}<br>${symbol(y)} = %{y:.4g}<br>f/limit = %{customdata:.3g}<extra></extra>`,
        customdata: objectives.map((row) => this.ratios(row)),
        colorbar,
      },
      {
        type: "contour",
        x: across,
        y: up,
        z,
        name: "limit: fits are alike inside",
        showlegend: true,
        showscale: false,
        connectgaps: false,
        hoverinfo: "skip",
        contours: { start: 0, end: 0, size: 1, coloring: "none" },
        line: { color: palette()[1], width: 2.5 },
      },
    ];
    return {
      data: [
        ...(trusted ? filled : []),
        ...this.runs(x, y, {
          colours: (levels) => ({ color: levels.map(Math.log10), ...scaled, ...(trusted ? {} : { colorbar }) }),
          name: this.names.length > 2 ? OTHERS : "run",
        }),
        {
          type: "scatter",
          mode: "markers",
          name: "best run",
          x: [best[x]],
          y: [best[y]],
          hoverinfo: "name",
          marker: { symbol: "star", size: 14, color: palette()[1], line: { color: "#ffffff", width: 1 } },
        },
      ],
      layout: {
        height: 460,
        xaxis: { ...this.axis(x, across), showgrid: false },
        yaxis: { ...this.axis(y, up), showgrid: false },
        showlegend: true,
      },
      label: `Contours of the objective over ${symbol(x)} and ${symbol(y)}, by the response surface, with ${runs.objectives.length} stored runs`,
      columns: {
        [this.title(x)]: cells.map(([at]) => at),
        [this.title(y)]: cells.map(([, to]) => to),
        f: cells.map(([, , f]) => f),
        "f over the limit": cells.map(([, , f]) => (f === null ? null : f / limit)),
      },
    };
  }

  slices() {
    const { slices, best, objective, limit, runs, trusted } = this.found;
    const columns = this.columns();
    const rows = Math.ceil(slices.length / columns);
    const ratios = slices.map(({ objectives }) => this.ratios(objectives));
    const drawn = ratios.flat().filter((ratio) => ratio !== null);
    const low = Math.log10(Math.min(objective / limit || 1, ...drawn, 0.8)),
      high = Math.log10(Math.max(...drawn, 10));
    const [blue, orange] = palette();
    const layout = {
      height: ROW * rows + 60,
      grid: { rows, columns, pattern: "independent", xgap: 0.16, ygap: 0.45 },
      showlegend: true,
    };
    const data = [];
    slices.forEach(({ parameter, values }, i) => {
      const at = i ? String(i + 1) : "";
      const axes = { xaxis: `x${at}`, yaxis: `y${at}`, showlegend: i === 0 };
      layout[`xaxis${at}`] = this.axis(parameter, values);
      layout[`yaxis${at}`] = {
        type: "log",
        range: [low - 0.1, high + 0.1],
        ...(i % columns ? {} : { title: { text: "f over the limit" } }),
      };
      data.push(
        ...this.runs(parameter, null, {
          colours: () => ({ color: colour("--muted"), opacity: 0.5, size: 5, line: { width: 0 } }),
          name: slices.length > 1 ? OTHERS : "run",
          ...axes,
        }),
        {
          type: "scatter",
          mode: "lines",
          name: "response surface",
          visible: trusted,
          x: values,
          y: ratios[i],
          connectgaps: false,
          line: { color: blue, width: 2.5 },
          ...axes,
        },
        {
          type: "scatter",
          mode: "lines",
          name: "limit: fits are alike below",
          x: [values[0], values.at(-1)],
          y: [1, 1],
          hoverinfo: "name",
          line: { color: colour("--ink"), dash: "dash", width: 1 },
          ...axes,
        },
        {
          type: "scatter",
          mode: "markers",
          name: "best run",
          x: [best[parameter]],
          y: this.ratios([objective]),
          hoverinfo: "name",
          marker: { symbol: "star", size: 13, color: orange, line: { color: colour("--paper"), width: 1 } },
          ...axes,
        },
      );
    });
    return {
      data,
      layout,
      label: `Slices of the objective through the best run along ${slices.map(({ parameter }) => symbol(parameter)).join(", ")}, with ${runs.objectives.length} stored runs`,
      columns: Object.assign(
        {},
        ...slices.map(({ parameter, values, objectives }) => ({
          [this.title(parameter)]: values,
          [`f along ${symbol(parameter)}`]: objectives,
        })),
      ),
    };
  }

  importance() {
    const shares = Object.entries(this.found.importance).sort(([, a], [, b]) => a - b);
    return {
      data: [
        {
          type: "bar",
          orientation: "h",
          y: shares.map(([name]) => symbol(name)),
          x: shares.map(([, share]) => 100 * share),
          text: shares.map(([, share]) => percent(share)),
          textposition: "outside",
          cliponaxis: false,
          hoverinfo: "skip",
          marker: { color: palette()[0] },
        },
      ],
      layout: {
        height: 90 + 32 * shares.length,
        xaxis: { title: { text: "share of the variation [%]" }, range: [0, 118] },
        yaxis: { type: "category", showgrid: false },
        bargap: 0.35,
      },
      label: `Importance: ${shares
        .toReversed()
        .map(([name, share]) => `${symbol(name)} ${percent(share)}`)
        .join(", ")}`,
      columns: {
        parameter: shares.toReversed().map(([name]) => name),
        "share [%]": shares.toReversed().map(([, share]) => 100 * share),
      },
    };
  }
}
