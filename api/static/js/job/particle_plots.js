// The two pictures of particles.
import { number, symbol, withUnit } from "../format.js";
import { colour, palette } from "../plot.js";

export const OBJECTIVE = " objective"; // no parameter's name begins with a space

const succeeded = ({ objective }) => objective !== null;
const valueOf = (row, name) => (name === OBJECTIVE ? row.objective : row.parameters[name]);
const titleOf = (view, name) =>
  name === OBJECTIVE
    ? withUnit("objective", view.fit?.objective_unit)
    : withUnit(symbol(name), infoOf(view, name)?.unit);
const infoOf = (view, name) => view.fit?.parameters.find((one) => one.name === name);
const logarithmic = (view, name) => name === OBJECTIVE || infoOf(view, name)?.scale === "log";

function axis(view, name) {
  const info = infoOf(view, name),
    log = logarithmic(view, name);
  const base = { title: { text: titleOf(view, name) }, type: log ? "log" : "linear" };
  if (!info) return base;
  const ends = [info.lower, info.upper].map((end) => (log ? Math.log10(end) : end));
  const margin = 0.03 * (ends[1] - ends[0]);
  return { ...base, range: [ends[0] - margin, ends[1] + margin] };
}

const told = (row) =>
  `particle ${row.particle}<br>objective ${number(row.objective)}` + (row.reason ? `<br>${row.reason}` : "");

/** Two axes: particles by objective, where each came from, and the best evaluation so far. */
export function pairPlot(view, rows, before, { x, y, number: generation }) {
  const earlier = new Map(before.map((row) => [row.particle, row]));
  const good = rows.filter(succeeded),
    bad = rows.filter((row) => row.state === "failed");
  const levels = good.map(({ objective }) => Math.log10(Math.max(objective, 1e-300)));
  const wanders = document.querySelector("main").dataset.role === "search"; // the runs of a sampling come from nowhere
  const moves = !wanders
    ? []
    : good.filter(({ particle }) => earlier.has(particle)).flatMap((row) => [earlier.get(row.particle), row, null]);
  const best = view.job.parameters;
  const at = (name) => (name === OBJECTIVE ? view.job.objective : best?.[name]);
  return {
    data: [
      {
        type: "scatter",
        mode: "lines",
        name: "move",
        x: moves.map((row) => row && valueOf(row, x)),
        y: moves.map((row) => row && valueOf(row, y)),
        line: { color: colour("--edge"), width: 1 },
        opacity: 0.5,
        hoverinfo: "skip",
        showlegend: moves.length > 0,
      },
      {
        type: "scatter",
        mode: "markers",
        name: "particle",
        x: good.map((row) => valueOf(row, x)),
        y: good.map((row) => valueOf(row, y)),
        text: good.map(told),
        hoverinfo: "text",
        marker: {
          size: 9,
          color: levels,
          colorscale: "Viridis",
          reversescale: true,
          line: { color: colour("--paper"), width: 1 },
          colorbar: {
            title: { text: "log₁₀ f", side: "right" },
            thickness: 10,
            outlinewidth: 0,
            tickfont: { color: colour("--ink") },
          },
        },
      },
      {
        type: "scatter",
        mode: "markers",
        name: "failed",
        x: bad.map((row) => valueOf(row, x)),
        y: bad.map((row) => valueOf(row, y)),
        text: bad.map(told),
        hoverinfo: "text",
        marker: { symbol: "x-thin-open", size: 9, color: colour("--bad") },
        showlegend: bad.length > 0,
      },
      {
        type: "scatter",
        mode: "markers",
        name: "best so far",
        x: best ? [at(x)] : [],
        y: best ? [at(y)] : [],
        hoverinfo: "name",
        marker: { symbol: "star", size: 14, color: palette()[1], line: { color: colour("--paper"), width: 1 } },
        showlegend: Boolean(best),
      },
    ],
    layout: { xaxis: axis(view, x), yaxis: axis(view, y), showlegend: true, height: 340 },
    label: `Generation ${generation}: ${rows.length} particles, ${titleOf(view, y)} over ${titleOf(view, x)}`,
    columns: table(view, rows),
  };
}

const CLASSES = [
  ["best quarter", "--series-1", 2, 1],
  ["second quarter", "--series-3", 1.2, 0.8],
  ["second half", "--edge", 1, 0.5],
];

/** All free parameters side by side, every particle a line; each axis runs from the lower to the upper bound. */
export function parallelPlot(view, rows, { number: generation }) {
  const names = view.job.free_parameters;
  const infos = names.map((name) => infoOf(view, name) ?? boundsOf(rows, name));
  const share = (row, i) => {
    const { lower, upper, scale } = infos[i],
      value = row.parameters[names[i]];
    const [low, high, here] = scale === "log" ? [lower, upper, value].map(Math.log) : [lower, upper, value];
    return high > low ? (here - low) / (high - low) : 0.5;
  };
  const ordered = rows.filter(succeeded).sort((a, b) => a.objective - b.objective);
  const quarter = Math.ceil(ordered.length / 4);
  const groups = [ordered.slice(0, quarter), ordered.slice(quarter, 2 * quarter), ordered.slice(2 * quarter)];
  const places = names.map((_, i) => i);
  const line = (group) => ({
    x: group.flatMap(() => [...places, null]),
    y: group.flatMap((row) => [...places.map((i) => share(row, i)), null]),
  });
  const failed = rows.filter((row) => row.state === "failed");
  const ends = names.flatMap((_, i) =>
    [
      [infos[i].lower, -0.04, "top"],
      [infos[i].upper, 1.04, "bottom"],
    ].map(([value, y, yanchor]) => ({
      x: i,
      y,
      yanchor,
      text: number(value, 3),
      showarrow: false,
      font: { size: 11, color: colour("--muted") },
    })),
  );
  return {
    data: [
      ...CLASSES.map(([name, token, width, opacity], i) => ({
        type: "scatter",
        mode: "lines",
        name,
        ...line(groups[i]),
        line: { color: colour(token), width },
        opacity,
        hoverinfo: "name",
        showlegend: groups[i].length > 0,
      })).reverse(),
      {
        type: "scatter",
        mode: "lines",
        name: "failed",
        ...line(failed),
        line: { color: colour("--bad"), width: 1, dash: "dot" },
        hoverinfo: "name",
        showlegend: failed.length > 0,
      },
    ],
    layout: {
      xaxis: {
        tickvals: places,
        ticktext: names.map((name) => titleOf(view, name)),
        range: [-0.3, names.length - 0.7],
        showgrid: true,
        showline: false,
        zeroline: false,
        ticks: "",
      },
      yaxis: { visible: false, range: [-0.14, 1.14] },
      annotations: ends,
      showlegend: true,
      height: 340,
      margin: { l: 16 },
    },
    label: `Generation ${generation}: ${rows.length} particles in parallel coordinates, each axis from its lower to its upper bound`,
    columns: table(view, rows),
  };
}

function boundsOf(rows, name) {
  const values = rows.map((row) => row.parameters[name]);
  return { lower: Math.min(...values), upper: Math.max(...values), scale: "linear" };
}

function table(view, rows) {
  return {
    particle: rows.map(({ particle }) => particle),
    state: rows.map(({ state }) => state),
    [titleOf(view, OBJECTIVE)]: rows.map(({ objective }) => objective),
    ...Object.fromEntries(
      view.job.free_parameters.map((name) => [titleOf(view, name), rows.map((row) => row.parameters[name])]),
    ),
  };
}
