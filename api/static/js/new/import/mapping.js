// One file becomes readings of one series: what is taken is shown, what is in doubt is asked, then it is confirmed.
import { announce, element, exchange } from "../../dom.js";
import { count } from "../../format.js";
import { request } from "../../http.js";
import { pointsPlot } from "../points_plot.js";
import { button } from "../schema_form.js";
import { plainBase, unitsOf } from "../units.js";
import { messageOf } from "../words.js";
import { askedFields } from "./asked.js";
import {
  CELLS,
  beginning,
  conflicts,
  joinsBlocks,
  open,
  section,
  suit,
  suitUnits,
  taken,
  unitQuestions,
} from "./choices.js";
import { BEFORE, LEAVE_OUT, NO_READING, choice, firstRows, flag, labelHere, ofFile, words, written } from "./inputs.js";
import { columnOfLoads, loadStages } from "./loads.js";
import { byLoad, columnOfX, lies, loadsAsX, likelySeries, readable } from "./matching.js";
import { moreFields } from "./more.js";

const PAUSE = 250; // ms without a change before the file is read again

/**
 * The form that maps a file. `file`: what the service found in it; `content`: the file itself; `context`: {series(),
 * readings(name): how many there are already, openParameters(), staged(), stages(), forwardModel()}; `act`: {sheet(name),
 * take(observation), stages(found), cancel()}.
 */
export function mapping(file, content, context, act) {
  const state = beginning();
  const known = context.series();
  const info = () => known.find((one) => one.name === state.series);
  const top = element("div", {}),
    fields = element("div", { class: "fields" }),
    asked = element("div", { class: "fields" }),
    more = element("div", {}),
    table = element("div", {});
  const notes = element("p", { class: "help", role: "status" }),
    wrong = element("div", { class: "problems" }),
    order = element("div", {}),
    preview = element("div", {});
  const use = button("Use these readings", accept, { class: "", id: "take" });
  let points = null,
    refused = [],
    timer = null,
    running = null;
  const loads = loadStages(file, content, state, context, {
    stages: act.stages,
    joined: (blocks) => {
      if (!state.blocks) {
        state.blocks = blocks;
        load();
      }
    },
  });

  const sign = () => (state.reverse ? -1 : 1);
  const quantity = (axis) => [
    info()?.[`${axis}_quantity`] ?? file.columns[state[axis]]?.label ?? axis,
    state[`${axis}Unit`],
  ];
  const plot = pointsPlot(preview, () => ({
    x: points?.x ?? [],
    y: (points?.y ?? []).map((y) => sign() * y),
    gross: points?.gross_errors,
    label: state.series ?? file.name,
    xLabel: quantity("x"),
    yLabel: quantity("y"),
  }));

  /** The points as they would be taken, from the service: it reads files for problems, too, by the same rules. */
  function load() {
    clearTimeout(timer);
    running?.abort();
    points = null;
    refused = [];
    show();
    loads.renew();
    if (!open(file, state, info()).length) timer = setTimeout(read, PAUSE);
  }

  async function read() {
    const mine = new AbortController();
    running = mine;
    try {
      const loads =
        byLoad(info(), "x") && plainBase(state.xUnit) !== "dimensionless" ? state.xUnit || undefined : undefined;
      const joined =
        joinsBlocks(file, state) && file.columns[state.x].kind === "number" ? state.xUnit || undefined : undefined;
      const query = {
        name: file.name,
        observation: JSON.stringify({
          ...section(file, state),
          x_unit: loads ?? joined,
          x_from: state.early && begin() > 0 ? begin() : undefined,
        }),
        forward_model: context.forwardModel(),
      };
      points = await (
        await request("POST", "/measurements/points", {
          query,
          body: content,
          headers: { "Content-Type": "application/octet-stream" },
          signal: mine.signal,
        })
      ).json();
      ["x", "y"].filter((axis) => state[axis] === CELLS && !byLoad(info(), axis)).forEach(found);
    } catch (error) {
      if (error.name === "AbortError") return;
      refused = error.issues?.length ? error.issues : [error];
      if (refusedFor("no_reading"))
        state.codes = refused
          .flatMap(({ parts }) => parts ?? [])
          .filter(({ path }) => path === "no_reading")
          .map(({ value }) => value);
    }
    show();
  }

  /** The unit that the service found for chosen cells, unless another one was given by hand. */
  function found(axis) {
    const name = `${axis}Unit`,
      now = points[`${axis}_unit`] === "unstated" ? "" : points[`${axis}_unit`];
    if (["", state.found[axis]].includes(state[name])) {
      const input = fields.querySelector(`#map-${axis}-unit`);
      input.value = now;
      input.dispatchEvent(new Event("input"));
    }
    state.found[axis] = now;
  }

  const unsorted = () => points !== null && points.x.some((x, i) => i > 0 && x <= points.x[i - 1]);

  /** Where x of the series begin, where readings before it are noise or the state before the first stage. */
  const begin = () => (/strain|^time$/.test(info()?.x_quantity ?? "") ? 0 : byLoad(info(), "x") ? 1 : -Infinity);
  const before = () => (points?.x.some((x) => x >= begin()) ? points.x.filter((x) => x < begin()).length : 0);
  const refusedFor = (key) => refused.some(({ parts }) => parts?.some(({ path }) => path === key));

  /** What is open, wrong or done, and what the button would do. */
  function show() {
    const questions = [...open(file, state, info()), ...unitQuestions(file, state, info())],
      units = Object.values(conflicts(file, state, info())).filter(Boolean);
    const incomplete = state.incomplete || refusedFor("incomplete_rows"),
      early = before() > 0 || (state.early && !points && begin() > 0) || refusedFor("x_from");
    exchange(
      wrong,
      questions.length && known.length
        ? element(
            "ul",
            { class: "todo" },
            questions.map((text) => written("li", text)),
          )
        : null,
      [...units, ...refused.map((issue) => messageOf(issue, labelHere))].map((text) =>
        element("p", { class: "error", role: "alert" }, text),
      ),
      incomplete
        ? flag("map-incomplete", LEAVE_OUT, state.incomplete, (on) => {
            state.incomplete = on;
            load();
          })
        : null,
      state.codes.length
        ? choice(
            "map-no-reading",
            NO_READING,
            state.codes.map((codes) => [codes, codes === "[]" ? "none: these are readings" : codes.slice(1, -1)]),
            state.noReading,
            (codes) => {
              state.noReading = codes;
              load();
            },
            { asked: true },
          )
        : null,
    );
    exchange(
      order,
      early
        ? flag(
            "map-before",
            `${BEFORE} ${quantity("x")[0]} ${begin()}${before() ? ` (${count(before())})` : ""}`,
            state.early,
            (on) => {
              state.early = on;
              if (begin() > 0) load();
            },
          )
        : null,
      unsorted() && info()?.x_increasing
        ? [
            element(
              "p",
              { class: "help stale" },
              `The values of ${quantity("x")[0]} do not increase from row to row, which this series needs.`,
            ),
            flag("map-sort", "Put the rows in order, with the mean of those of equal x", state.sort, (on) => {
              state.sort = on;
            }),
          ]
        : null,
    );
    notes.textContent = points
      ? [
          `${count(points.x.length)} readings.`,
          points.gross_errors.length ? `${count(points.gross_errors.length)} of them are gross errors.` : "",
          ...points.notes.map((note) => `${note[0].toUpperCase()}${note.slice(1)}.`),
        ]
          .filter(Boolean)
          .join(" ")
      : questions.length || refused.length
        ? ""
        : "Reading …";
    const there = state.series ? context.readings(state.series) : 0;
    use.textContent = !state.series
      ? "Use these readings"
      : there
        ? `Replace ${state.series} (${count(there)} readings)`
        : `Add ${state.series}`;
    use.disabled = !points?.x.length || units.length > 0 || questions.length > 0;
    preview.hidden = !points?.x.length;
    if (points?.x.length) plot.draw();
  }

  function draw() {
    const about = info();
    const name = (column) =>
      file.columns.filter((one) => one.name === column.name).length > 1
        ? `${column.name} (${column.letters})`
        : column.name;
    const columns = (kinds) => [
      ...file.columns.map((column, i) => ofFile(i, name(column), !kinds(column))),
      [CELLS, "by cells or name …"],
    ];
    const pick = (axis, kinds) => [
      choice(`map-${axis}`, `Column of ${axis}`, columns(kinds), state[axis], (value) => choose(axis, value)),
      state[axis] === CELLS
        ? words(
            `map-${axis}-cells`,
            `Cells of ${axis}`,
            state[`${axis}Cells`],
            (value) => {
              state[`${axis}Cells`] = value;
              change(false);
            },
            { placeholder: "B5:B30", help: "B5:B30, B5:M5 in a row, B:B, or a name of the workbook." },
          )
        : null,
      unit(axis),
    ];
    exchange(
      fields,
      choice(
        "map-series",
        "Series",
        known.map((one) => [
          one.name,
          context.readings(one.name) ? `${one.name}: replaces ${count(context.readings(one.name))} readings` : one.name,
        ]),
        state.series,
        (value) => {
          state.series = value;
          suit(state, file, info());
          change(true);
        },
        { help: about?.description, asked: true, wide: true },
      ),
      element(
        "div",
        { class: "fields wide-field" },
        pick("y", (column) => column.kind === "number"),
      ),
      element("div", { class: "fields wide-field" }, pick("x", readable)),
    );
    exchange(asked, askedFields(file, state, about, context, change));
    exchange(more, moreFields(file, state, change, context.openParameters()));
    exchange(table, file.columns.length ? firstRows(file, { [state.x]: "x", [state.y]: "y" }) : null);
    load();
  }

  function choose(axis, value) {
    const pair = axis === "y" && info() !== undefined && lies(file.columns[value]);
    state[axis] = value;
    if (pair) state.x = columnOfX(file, info(), value);
    suitUnits(state, file, info(), pair ? ["x", "y"] : [axis]);
    change(true);
  }

  function change(redraw) {
    if (redraw) draw();
    else load();
  }

  function unit(axis) {
    const base = info()?.[`${axis}_unit`];
    const listed = unitsOf(
      loadsAsX(info(), axis, file.columns[state[axis]]) ? "kPa" : (base ?? file.columns[state[axis]]?.base ?? ""),
    );
    const dates = axis === "x" && ["time", "clock"].includes(file.columns[state.x]?.kind);
    const made = words(
      `map-${axis}-unit`,
      `Unit of ${axis}`,
      state[`${axis}Unit`],
      (value) => {
        state[`${axis}Unit`] = value;
        state.given[axis] = value;
        made.classList.toggle("asked", !value);
        if (byLoad(info(), axis)) load();
        else show();
      },
      {
        list: listed,
        help: dates ? "Dates are read as days." : null,
        asked: info() !== undefined && !state[`${axis}Unit`],
      },
    );
    if (dates) made.querySelector("input").readOnly = true;
    return made;
  }

  function accept() {
    const observation = taken(points, state, info(), before() ? begin() : undefined);
    plot.remove();
    if (!act.take(observation, file.name))
      announce(`${count(points.x.length)} readings of ${observation.series} were taken from ${file.name}.`);
  }

  state.more.load_column = columnOfLoads(file);
  const likely = likelySeries(file, known);
  state.series = likely.series ?? (known.length === 1 ? known[0].name : null);
  suit(state, file, info(), likely.y);
  exchange(
    top,
    file.sheets.length > 1
      ? element(
          "div",
          { class: "fields" },
          choice(
            "map-sheet",
            "Sheet",
            file.sheets.map((one) => ofFile(one, one)),
            file.sheet,
            act.sheet,
            { help: `${file.sheets.length} sheets: ${file.sheets.join(", ")}` },
          ),
        )
      : null,
    known.length
      ? null
      : element(
          "p",
          { class: "error", role: "alert" },
          "Describe the forward model first; then a file can be assigned to one of its series.",
        ),
    file.columns.some((column) => column.kind === "number")
      ? null
      : element(
          "p",
          { class: "error", role: "alert" },
          `Sheet “${file.sheet}” has no column of numbers: choose another one.`,
        ),
    file.formulas.length
      ? element(
          "p",
          { class: "error", role: "alert" },
          `Formulas without a stored value, which cannot be read: ${file.formulas.join(", ")}. Let a spreadsheet program calculate and save the workbook.`,
        )
      : null,
  );
  const made = element(
    "fieldset",
    { class: "group mapping" },
    element("legend", {}, file.name),
    top,
    table,
    loads.place,
    fields,
    asked,
    element("details", { class: "more" }, element("summary", {}, "More about these columns"), more),
    wrong,
    notes,
    order,
    preview,
    element(
      "div",
      { class: "buttons" },
      use,
      button("Cancel", () => {
        running?.abort();
        plot.remove();
        act.cancel();
      }),
    ),
  );
  draw();
  return made;
}
