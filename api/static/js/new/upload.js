// A dropped file becomes readings: columns and units are mapped, with a look at the points.
import { announce, element, failure } from "../dom.js";
import { count } from "../format.js";
import { request } from "../http.js";
import { pointsPlot } from "./points_plot.js";
import { button } from "./schema_form.js";
import { guessedColumns, plainBase, unitsOf } from "./units.js";

const ROWS_SHOWN = 6;

/** The place for files; `series()` lists the forward model's series, `take(observation)` gets what was mapped. */
export function uploader(series, used, take) {
  const place = element("div", {});
  const input = element("input", { type: "file", id: "file", class: "visually-hidden", accept: ".csv,.txt,.tsv,.xlsx,.ods", onchange: () => { if (input.files[0]) read(input.files[0]); input.value = ""; } });
  const zone = element("div", { class: "drop" },
    element("p", {}, "Drop a file of measurements here (CSV, XLSX or ODS)"),
    input, element("label", { for: "file", class: "button quiet" }, "Choose a file"),
    element("p", { class: "help" }, "A heading, then a row for each reading. Units are taken from headings such as ", element("code", {}, "settlement [mm]"), ". The file goes to this service only, and is not stored."));
  zone.addEventListener("dragover", (event) => { event.preventDefault(); zone.classList.add("over"); });
  zone.addEventListener("dragleave", () => zone.classList.remove("over"));
  zone.addEventListener("drop", (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    if (event.dataTransfer.files[0]) read(event.dataTransfer.files[0]);
  });

  async function read(file, sheet) {
    place.replaceChildren(element("p", { class: "help" }, `Reading ${file.name} …`));
    try {
      const query = { name: file.name, sheet };
      const answer = await (await request("POST", "/measurements", { query, body: new Blob([file]), headers: { "Content-Type": "application/octet-stream" } })).json();
      place.replaceChildren(mapping(answer, (other) => read(file, other)));
      place.querySelector("select")?.focus();
    } catch (error) {
      place.replaceChildren(failure(error));
    }
  }

  function mapping(file, readSheet) {
    const state = { series: null, x: null, y: null, weight: null, xUnit: "", yUnit: "", reverse: false, sort: false };
    const known = series();
    const fields = element("div", { class: "fields" }), notes = element("p", { class: "help", role: "status" }), preview = element("div", {});
    const plot = pointsPlot(preview, () => ({ ...points(), label: state.series ?? file.name, xLabel: quantity("x"), yLabel: quantity("y") }));
    const info = () => known.find((one) => one.name === state.series);
    const quantity = (axis) => [info()?.[`${axis}_quantity`] ?? file.columns[state[axis]]?.label ?? axis, state[`${axis}Unit`]];
    const use = button("Use these readings", accept, { class: "" });

    function guess() {
      Object.assign(state, guessedColumns(file.columns, info()));
      guessUnits();
    }

    function guessUnits() {
      for (const axis of ["x", "y"]) {
        const column = file.columns[state[axis]];
        const base = info()?.[`${axis}_unit`];
        const suits = column?.unit && (base === undefined || plainBase(base) === column.base);
        state[`${axis}Unit`] = suits ? column.unit : base === undefined ? "" : plainBase(base);
      }
    }

    /** The chosen columns without rows that lack a number, in order if wanted. */
    function points() {
      const [x, y, weight] = ["x", "y", "weight"].map((role) => file.columns[state[role]]?.values ?? null);
      if (!x || !y) return { x: [], y: [], weight: null, left: 0, unsorted: false };
      let rows = x.map((one, i) => [one, state.reverse && y[i] !== null ? -y[i] : y[i], weight?.[i] ?? null]).filter(([a, b, c]) => a !== null && b !== null && (!weight || c !== null));
      const left = x.length - rows.length;
      const unsorted = rows.some(([one], i) => i > 0 && one <= rows[i - 1][0]);
      let doubles = 0;
      if (state.sort) {
        const sorted = [...rows].sort((one, other) => one[0] - other[0]);
        rows = sorted.filter(([one], i) => i === 0 || one !== sorted[i - 1][0]);
        doubles = sorted.length - rows.length;
      }
      return { x: rows.map((row) => row[0]), y: rows.map((row) => row[1]), weight: weight ? rows.map((row) => row[2]) : null, left, unsorted, doubles };
    }

    function refresh() {
      const { x, left, unsorted, doubles } = points();
      const bad = ["x", "y", "weight"].map((role) => file.columns[state[role]]).filter((column) => column?.bad);
      notes.textContent = [
        `${count(x.length)} readings.`,
        left ? `${count(left)} rows without both numbers are left out.` : "",
        ...bad.map((column) => `${count(column.bad)} cells of “${column.name}” hold no number.`),
        ["x", "y"].some((axis) => file.columns[state[axis]]?.kind === "time") ? "Dates count as days since the first of them." : "",
        unsorted && !state.sort && info()?.x_increasing ? `The values of ${quantity("x")[0]} do not increase from row to row, which this series needs.` : "",
        doubles ? `${count(doubles)} rows with a repeated value are left out.` : "",
      ].filter(Boolean).join(" ");
      order.hidden = !unsorted && !state.sort;
      use.disabled = !state.series || x.length === 0;
      plot.draw();
    }

    function draw() {
      const columns = file.columns.map((column, i) => [i, column.name, column.kind === "text"]);
      fields.replaceChildren(
        choice("map-series", "Series", known.map((one) => [one.name, one.name]), state.series, (value) => { state.series = value; guess(); draw(); }, info()?.description),
        choice("map-x", "Column of x", columns, state.x, (value) => { state.x = value; guessUnits(); draw(); }),
        unit("map-x-unit", "Unit of x", "x"),
        choice("map-y", "Column of y", columns, state.y, (value) => { state.y = value; guessUnits(); draw(); }),
        unit("map-y-unit", "Unit of y", "y"),
        choice("map-weight", "Column of weights", [[null, "none"], ...columns], state.weight, (value) => { state.weight = value; refresh(); }));
      refresh();
    }

    function unit(id, label, axis) {
      const base = info()?.[`${axis}_unit`];
      const input = element("input", { type: "text", id, list: `${id}-list`, value: state[`${axis}Unit`], spellcheck: "false", autocomplete: "off", oninput: () => { state[`${axis}Unit`] = input.value.trim(); refresh(); } });
      const offered = unitsOf(base ?? file.columns[state[axis]]?.base ?? "");
      return element("div", { class: "field" }, element("label", { for: id }, label), input, element("datalist", { id: `${id}-list` }, offered.map((one) => element("option", { value: one }))));
    }

    function accept() {
      const { x, y, weight } = points();
      const observation = { series: state.series };
      if (state.xUnit) observation.x_unit = state.xUnit;
      if (state.yUnit) observation.y_unit = state.yUnit;
      take({ ...observation, points: weight ? { x, y, weight } : { x, y } });
      plot.remove();
      place.replaceChildren();
      announce(`${count(x.length)} readings of ${state.series} were taken from ${file.name}.`);
      document.getElementById("file").focus();
    }

    const order = flag("map-sort", "Put the rows in order and keep the first of equal ones", (on) => { state.sort = on; refresh(); });
    state.series = (known.find((one) => !used().includes(one.name)) ?? known[0])?.name ?? null;
    guess();
    const made = element("fieldset", { class: "group mapping" }, element("legend", {}, file.name),
      file.sheets.length > 1 ? choice("map-sheet", "Sheet", file.sheets.map((one) => [one, one]), file.sheet, readSheet) : null,
      known.length ? null : element("p", { class: "error", role: "alert" }, "Describe the forward model first: then its series are known, and a file can be given to one of them."),
      rowsTable(file), fields,
      flag("map-reverse", "Reverse the sign of y", (on) => { state.reverse = on; refresh(); }), order, notes, preview,
      element("div", { class: "buttons" }, use, button("Cancel", () => { plot.remove(); place.replaceChildren(); })));
    draw();
    return made;
  }
  return element("div", {}, zone, place);
}

function choice(id, label, options, value, act, help) {
  const known = options.some(([one]) => one === value);
  const all = known ? options : [[value, "choose …"], ...options];
  const made = element("select", { id, onchange: () => act(all[Number(made.value)][0]) }, all.map(([one, name, disabled], i) => element("option", { value: String(i), selected: one === value, disabled }, name)));
  return element("div", { class: "field" }, element("label", { for: id }, label), made, help ? element("p", { class: "help" }, help) : null);
}

function flag(id, label, act) {
  const input = element("input", { type: "checkbox", id, onchange: () => act(input.checked) });
  return element("div", { class: "field check" }, element("label", { for: id }, input, ` ${label}`));
}

function rowsTable(file) {
  const cells = (i) => file.columns.map((column) => element("td", { class: "n" }, column.kind === "text" ? "text" : column.values[i] ?? "–"));
  const rows = Math.min(file.rows, ROWS_SHOWN);
  return element("details", {}, element("summary", {}, `First rows of ${count(file.rows)}`),
    element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "First rows" }, element("table", {},
      element("thead", {}, element("tr", {}, file.columns.map((column) => element("th", { scope: "col", class: "n" }, column.name)))),
      element("tbody", {}, Array.from({ length: rows }, (_, i) => element("tr", {}, cells(i)))))));
}
