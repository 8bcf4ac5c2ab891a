// Plotly in the page's colours; plots that follow the theme and can be read as a table.
import { announce, element, tableHead, wide } from "./dom.js";
import { number } from "./format.js";
import { separators, translate } from "./language.js";

let loading = null;

/** Plotly, loaded with the first plot that is drawn, after what else changed is on the screen: reading it takes long. */
export function plotly() {
  loading ??= new Promise((resolve, reject) => {
    const script = element("script", { src: document.body.dataset.plotly });
    script.addEventListener("load", () => resolve(window.Plotly));
    script.addEventListener("error", () => reject(new Error("The plots could not be loaded. Reload the page.")));
    requestAnimationFrame(() => setTimeout(() => document.head.append(script)));
  });
  return loading;
}

const colours = new Map(); // of the present theme: asking the browser lays the page out anew
document.addEventListener("themechange", () => colours.clear());

/** A colour of tokens.css as the browser computes it now: `colour("--series-1")`. */
export function colour(token) {
  if (!colours.has(token)) {
    const probe = element("span", { hidden: true, style: { color: `var(${token})` } });
    document.body.append(probe);
    colours.set(token, getComputedStyle(probe).color);
    probe.remove();
  }
  return colours.get(token);
}

/** The series' colours, safe for colour-blind readers; `dash` and `symbol` distinguish them without colour. */
export function palette() {
  return [1, 2, 3, 4, 5, 6].map((i) => colour(`--series-${i}`));
}
export const DASHES = ["solid", "dash", "dot", "dashdot", "longdash", "longdashdot"];
export const SYMBOLS = ["circle", "square", "diamond", "cross", "triangle-up", "star"];

/** Readings that do not count: crosses, as they are struck out by hand. */
export function grossErrors(x, y) {
  return {
    type: "scatter",
    mode: "markers",
    name: "gross error",
    x,
    y,
    marker: { color: palette()[1], symbol: "x-thin", size: 9, line: { color: palette()[1], width: 2 } },
  };
}

const merged = (base, over) => {
  const result = { ...base };
  for (const [key, value] of Object.entries(over ?? {})) {
    const both = [value, base[key]].every((one) => one && typeof one === "object" && !Array.isArray(one));
    result[key] = both ? merged(base[key], value) : value;
  }
  return result;
};

function dressed(layout) {
  const [ink, grid, edge, muted] = ["--ink", "--plot-grid", "--edge", "--muted"].map(colour);
  const axis = {
    gridcolor: grid,
    linecolor: edge,
    zerolinecolor: grid,
    tickcolor: edge,
    showline: true,
    ticks: "outside",
    automargin: true,
    exponentformat: "power",
    minexponent: 5,
    title: { standoff: 8 },
  };
  const base = {
    font: { family: "system-ui, sans-serif", size: 12, color: ink },
    paper_bgcolor: "rgba(0,0,0,0)",
    plot_bgcolor: "rgba(0,0,0,0)",
    colorway: palette(),
    margin: { l: 56, r: 16, t: 16, b: 48 },
    legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0, font: { color: ink } },
    hoverlabel: { bgcolor: colour("--raised"), bordercolor: edge, font: { color: ink } },
    modebar: { bgcolor: "rgba(0,0,0,0)", color: muted, activecolor: ink },
    hovermode: "closest",
    separators,
  };
  const dress = merged(base, layout);
  for (const name of new Set([
    "xaxis",
    "yaxis",
    ...Object.keys(layout ?? {}).filter((key) => /^[xy]axis\d*$/.test(key)),
  ])) {
    const sparse = layout?.[name]?.type === "log" ? { nticks: 4 } : {}; // else 9, 8 and 7 lie upon each other
    dress[name] = merged({ ...axis, ...sparse }, layout?.[name]);
  }
  return dress;
}

const WORDED = new Set(["text", "name", "title", "hovertext", "ticktext", "label"]);

/** Data or layout with its texts in the language of the page. */
function inWords(value, worded = false) {
  if (typeof value === "string") return worded ? translate(value) : value;
  if (Array.isArray(value))
    return worded || value[0]?.constructor === Object ? value.map((one) => inWords(one, worded)) : value;
  if (value?.constructor !== Object) return value;
  return Object.fromEntries(Object.entries(value).map(([key, one]) => [key, inWords(one, WORDED.has(key))]));
}

const LETTER = 7.5; // px, on average, of a title; an entry of a legend has a key before it
const KEY = 110;

/** A text that is longer than its room in two lines. */
function wrapped(text, room) {
  const at = text.length * LETTER > room && !text.includes("<br>") ? text.lastIndexOf(" ", room / LETTER) : -1;
  return at > 0 ? `${text.slice(0, at)}<br>${text.slice(at + 1)}` : text;
}

const PHONE = 420;

/** Data and layout whose texts find room in a frame that is so wide: titles and numbers below, entries of the legend. */
function fitted(data, layout, width) {
  for (const [name, axis] of Object.entries(layout)) {
    if (!/^xaxis\d*$/.test(name)) continue;
    if (axis.title?.text) axis.title.text = wrapped(axis.title.text, width - 40);
    if (axis.type === "log" && width < PHONE) axis.nticks = 2;
  }
  for (const one of data) if (one.name) one.name = wrapped(one.name, width - KEY);
  return [data, layout];
}

const NARROW = 720; // px: the toolbar would lie upon the legend, and fingers zoom without it
const CONFIG = {
  responsive: true,
  displaylogo: false,
  modeBarButtonsToRemove: ["select2d", "lasso2d"],
  showSendToCloud: false,
};

/**
 * A plot in `place`. `make()` returns {data, layout, config?, label, columns?}: it is called again for every theme, so it
 * takes its colours from `palette()` and `colour()`. `label` says in one sentence what is to be seen; `columns`,
 * {heading: values}, are the numbers as a table for readers who cannot see it. Returns {draw, remove}; `draw()` after new data.
 */
export function plot(place, make) {
  const frame = element("div", { class: "plot", role: "figure" });
  const table = element(
    "details",
    { class: "plot-table", hidden: true },
    element("summary", {}, "Numbers of this plot"),
  );
  const files = fileButtons((form) => saved(frame, shown, form));
  files.hidden = true;
  place.replaceChildren(frame, files, table);
  let shown = null;
  const onTheme = () => draw();
  table.addEventListener("toggle", () => {
    if (table.open && shown?.columns) fillTable(table, shown);
  });
  document.addEventListener("themechange", onTheme);

  async function draw() {
    const Plotly = await plotly();
    shown = make();
    frame.setAttribute("aria-label", shown.label);
    table.hidden = files.hidden = !shown.columns;
    if (table.open && shown.columns) fillTable(table, shown);
    const [data, layout] = fitted(inWords(shown.data), inWords(dressed(shown.layout)), frame.clientWidth || innerWidth);
    await Plotly.react(frame, data, layout, {
      ...CONFIG,
      displayModeBar: innerWidth < NARROW ? false : "hover",
      ...shown.config,
    });
    return frame;
  }

  function remove() {
    document.removeEventListener("themechange", onTheme);
    window.Plotly?.purge(frame);
    place.replaceChildren();
  }
  return { draw, remove, frame };
}

/** Buttons below a plot; `save(form)` hands it over as svg, png or csv. */
export function fileButtons(save) {
  const button = (form) =>
    element(
      "button",
      {
        type: "button",
        class: "link",
        "aria-label": `This plot as ${form.toUpperCase()}`,
        onclick: () => save(form).catch((error) => announce(error.message)),
      },
      form.toUpperCase(),
    );
  return element("p", { class: "plot-files" }, "Save as ", ...["svg", "png", "csv"].map(button));
}

const MOST_ROWS = 500;

function fillTable(details, { label, columns }) {
  const names = Object.keys(columns);
  const length = Math.max(0, ...names.map((name) => columns[name].length));
  const cell = (value) =>
    element(
      "td",
      { class: typeof value === "number" ? "n" : null },
      typeof value === "number" ? number(value, 6) : String(value ?? "–"),
    );
  const rows = Array.from({ length: Math.min(length, MOST_ROWS) }, (_, i) =>
    element(
      "tr",
      {},
      names.map((name) => cell(columns[name][i])),
    ),
  );
  details.querySelector(".wide")?.remove();
  details.append(
    wide(
      `Numbers: ${label}`,
      element("table", {}, tableHead(names), element("tbody", {}, rows)),
      length > MOST_ROWS ? element("p", { class: "help" }, `The first ${MOST_ROWS} of ${length} rows.`) : null,
    ),
  );
}

/** Hand a plot to the browser as a file, in the colours of the page. */
async function saved(frame, { label, columns }, form) {
  const filename =
    label
      .toLowerCase()
      .replace(/[^a-z0-9]+/g, "-")
      .replace(/^-|-$/g, "")
      .slice(0, 60) || "plot";
  if (form !== "csv") {
    const Plotly = await plotly();
    const figure = { data: frame.data, layout: { ...frame.layout, paper_bgcolor: colour("--paper") } };
    await Plotly.downloadImage(figure, {
      format: form,
      filename,
      width: frame.clientWidth,
      height: frame.clientHeight,
      scale: form === "png" ? 2 : 1,
    });
    return;
  }
  handOver(new Blob([csvOf(columns)], { type: "text/csv" }), `${filename}.csv`);
}

/** Give the browser a file to save. */
export function handOver(content, download) {
  const address = URL.createObjectURL(content);
  element("a", { href: address, download }).click();
  setTimeout(() => URL.revokeObjectURL(address), 60_000);
}

/** Columns as CSV with all their digits; what a table of calculation would take for a formula is not a number and is quoted. */
export function csvOf(columns) {
  const names = Object.keys(columns);
  const cell = (value) =>
    value === null || value === undefined
      ? ""
      : typeof value === "number"
        ? String(value)
        : `"${String(value)
            .replace(/^(?=[=+\-@\t])/, "'")
            .replaceAll('"', '""')}"`;
  const rows = Array.from({ length: Math.max(0, ...names.map((name) => columns[name].length)) }, (_, i) =>
    names.map((name) => cell(columns[name][i])).join(","),
  );
  return [names.map((name) => cell(name)).join(","), ...rows].join("\r\n") + "\r\n";
}
