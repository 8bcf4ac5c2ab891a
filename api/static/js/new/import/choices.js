// What is chosen of a file: columns, units, rows; how a problem file would say it, and what is still open.
import { plainBase } from "../units.js";
import { byLoad, columnOfX, columnOfY, conflict, loadsAsX, reference, unitless } from "./matching.js";

export const CELLS = "cells"; // a column that is given by its letters, cells or name

/** What is chosen at first; `more` holds what few files need. */
export function beginning() {
  return {
    series: null,
    x: null,
    y: null,
    xCells: "",
    yCells: "",
    xUnit: "",
    yUnit: "",
    reverse: false,
    sort: false,
    early: false,
    decimal: null,
    dates: null,
    specimen: null,
    incomplete: false,
    codes: [],
    noReading: null,
    blocks: null,
    together: false,
    staged: false,
    found: {},
    given: {},
    more: {},
  };
}

/** Columns and units for a series that was chosen. */
export function suit(state, file, info, y = null) {
  state.y = y ?? (info ? columnOfY(file, info) : null);
  state.x = info ? columnOfX(file, info, state.y) : null;
  suitUnits(state, file, info);
  const weight = file.columns.findIndex((column) => column.name.trim().toLowerCase() === "weight");
  if (weight >= 0) state.more.weight_column ??= weight;
}

/** The unit that a heading names, whether it fits or not; where it names none and the series has one, that given by hand, else it is asked for. The only column of times of day belongs to dates. */
export function suitUnits(state, file, info, axes = ["x", "y"]) {
  const clocks = file.columns.flatMap((column, i) => (column.kind === "clock" ? [i] : []));
  if (clocks.length === 1 && file.columns[state.x]?.kind === "time") state.more.x_time_column ??= clocks[0];
  for (const axis of axes) {
    const column = file.columns[state[axis]];
    const clock = axis === "x" && column?.kind === "clock";
    const plain =
      info &&
      plainBase(info[`${axis}_unit`]) === "dimensionless" &&
      !info[`${axis}_quantity`].includes("strain") &&
      !loadsAsX(info, axis, column) &&
      (!column?.unclear || unitless(info, axis));
    state[`${axis}Unit`] =
      column?.unit ?? (clock ? "day" : plain ? "dimensionless" : column?.unclear ? "" : (state.given[axis] ?? ""));
  }
}

/** Units that are to be said: sentences. */
export function unitQuestions(file, state, info) {
  return ["y", "x"]
    .filter((axis) => info && state[axis] !== null && !state[`${axis}Unit`])
    .map((axis) => {
      const column = file.columns[state[axis]];
      return `${column ? `“${column.name}”` : `The column of ${axis}`} ${column?.unclear ?? "has no unit"}: give the unit of ${axis}.`;
    });
}

const MOST_STAGES = 20;

/** The column with the entries of several specimens; else of several stages, where the strains of x fall from one to the next. */
export function specimenColumn(file, state) {
  const entries = ({ entries }) => Object.keys(entries).length;
  const several = (word, most) =>
    file.columns.findIndex(
      (column, i) =>
        i !== state.x && column.quantities.includes(word) && entries(column) > 1 && entries(column) <= most,
    );
  const x = file.columns[state.x],
    known = x?.values.filter((value) => value !== null) ?? [];
  const falls = x?.quantities.some((one) => one.includes("strain")) && known.some((value, i) => value < known[i - 1]);
  const found = [
    several("specimen", file.rows - 1),
    falls ? several("stage", Math.min(MOST_STAGES, file.rows - 1)) : -1,
  ].find((place) => place >= 0);
  return found ?? null;
}

const chosen = (file, state) =>
  [state.x, state.y, state.more.y_minus, state.more.weight_column].map((i) => file.columns[i]).filter(Boolean);

/** Pairs of columns with the headings of those chosen, as stages side by side have them; empty where there is one only. */
function blocksAlike(file, { x, y }) {
  const like = (chosen) =>
    file.columns.flatMap((one, i) =>
      one.label === file.columns[chosen].label &&
      one.kind === file.columns[chosen].kind &&
      one.unit === file.columns[chosen].unit
        ? [i]
        : [],
    );
  if (!file.columns[x] || !file.columns[y] || x === y) return [];
  const [xs, ys] = [like(x), like(y)];
  return xs.length > 1 && xs.length === ys.length && !xs.some((i) => ys.includes(i))
    ? xs.map((i, place) => [i, ys[place]])
    : [];
}

/** What can be joined: blocks side by side, else sheets with the same headings; elapsed times count from the load of their stage. */
export function joinable(file, state) {
  const pairs = blocksAlike(file, state),
    sheets = file.columns[state.x] && file.columns[state.y] ? file.alike : [];
  const blocks =
    pairs.length > 1
      ? pairs.map(([x, y]) => ({ x_column: reference(file, x), y_column: reference(file, y) }))
      : sheets.map((sheet) => ({ sheet }));
  return blocks.map((block, i) =>
    file.columns[state.x].kind === "number" && state.staged ? { ...block, stage: i + 1 } : block,
  );
}

/** Whether several of them are to be taken together. */
export const joinsBlocks = (file, state) => state.together && joinable(file, state).length > 1;

/** A cell that can be read in two ways, of numbers and of dates, in the columns that are taken; null: none. */
export function doubts(file, state) {
  const columns = chosen(file, state);
  return {
    numbers: columns.find((column) => column.kind === "number" && column.doubt) ?? null,
    dates: file.columns[state.x]?.kind === "time" && file.columns[state.x].doubt ? file.columns[state.x] : null,
    clock: file.columns[state.x]?.kind === "clock" ? file.columns[state.x] : null,
  };
}

/** What is to be said before anything can be taken: sentences. */
export function open(file, state, info) {
  const { numbers, dates, clock } = doubts(file, state);
  const given = (axis) => (state[axis] === CELLS ? state[`${axis}Cells`] : state[axis] !== null);
  return [
    info ? null : "Choose the series that these readings belong to.",
    ...["y", "x"]
      .filter((axis) => !given(axis))
      .map(
        (axis) =>
          `Choose the column of ${axis}${state[`${axis}Unit`] ? "" : ", and give its unit where its heading names none"}.`,
      ),
    numbers && !state.decimal
      ? `“${numbers.doubt}” in ${numbers.name} can be one thousand or one: say how numbers are written.`
      : null,
    clock && !state.dates
      ? `“${clock.first.find(Boolean)}” in ${clock.name} is a time: say how the time since the start is written, or choose the column of the dates.`
      : null,
    dates && !state.dates
      ? `“${dates.doubt}” in ${dates.name} can be read in two ways: say how dates are written.`
      : null,
    specimenColumn(file, state) !== null && state.specimen === null
      ? `Choose the ${file.columns[specimenColumn(file, state)].quantities[0]}.`
      : null,
  ].filter(Boolean);
}

/** Units of another dimension, by axis. */
export function conflicts(file, state, info) {
  return Object.fromEntries(
    ["x", "y"].map((axis) => [axis, conflict(info, axis, state[`${axis}Unit`], file.columns[state[axis]])]),
  );
}

/** A factor as a number, `1/0.0038` too; what is none goes to the service, which says so. */
function factor(text) {
  const [over, under, ...more] = (text ?? "")
    .replaceAll(",", ".")
    .split("/")
    .map((part) => part.trim());
  if (!over) return undefined;
  const value = Number(over) / Number(under ?? 1);
  return under === "" || more.length || !Number.isFinite(value) ? text : value;
}

/** The observation of a problem file that reads these points. */
export function section(file, state) {
  const column = (given) => (typeof given === "number" ? reference(file, given) : given || undefined);
  const axis = (name) => (state[name] === CELLS ? state[`${name}Cells`] : column(state[name]));
  const named =
    [state.x, state.y].every((one) => one === CELLS) && ![state.xCells, state.yCells].some((one) => one.includes(":"));
  const of = state.more,
    blocks = joinsBlocks(file, state) ? joinable(file, state) : undefined;
  const inputs = Object.fromEntries(
    (of.inputs ?? []).filter(([name, from]) => name && from !== null).map(([name, from]) => [name, column(from)]),
  );
  const part = specimenColumn(file, state);
  const where =
    part !== null && state.specimen
      ? { [reference(file, part)]: state.specimen }
      : typeof of.whereColumn === "number" && of.whereEntry
        ? { [reference(file, of.whereColumn)]: of.whereEntry }
        : undefined;
  return {
    series: state.series,
    sheet: file.sheet && !named && !blocks?.[0].sheet ? file.sheet : undefined,
    x_column: axis("x"),
    y_column: axis("y"),
    y_minus: column(of.y_minus),
    weight_column: column(of.weight_column),
    gross_error_column: column(of.gross_error_column),
    inputs: Object.keys(inputs).length ? inputs : undefined,
    where,
    x_dates: state.dates ?? undefined,
    x_time_column: ["time", undefined].includes(file.columns[state.x]?.kind) ? column(of.x_time_column) : undefined,
    x_origin: of.x_origin || undefined,
    decimal_sign: state.decimal ?? undefined,
    incomplete_rows: state.incomplete ? "leave_out" : undefined,
    no_reading: state.noReading === null ? undefined : JSON.parse(state.noReading),
    x_factor: factor(of.x_factor),
    y_factor: factor(of.y_factor),
    blocks: state.blocks ?? blocks,
    notes: of.notes ? [of.notes] : undefined,
  };
}

/** The observation of the points that the service has read; `begin`: where x begin, if readings before it are left out on request. */
export function taken(points, state, info, begin) {
  const { x, y, weight, readings, independent, range, inputs, gross_errors, notes } = points;
  const observation = { series: state.series };
  for (const axis of ["x", "y"]) {
    const unit = state[`${axis}Unit`];
    const own = unit && plainBase(unit) !== plainBase(info?.[`${axis}_unit`]);
    if (own && !byLoad(info, axis)) observation[`${axis}_unit`] = unit;
  }
  observation.points = {
    x,
    y,
    ...(weight ? { weight } : {}),
    ...(readings ? { readings } : {}),
    ...(independent ? { independent } : {}),
    ...(range === null ? {} : { range }),
    ...(Object.keys(inputs).length ? { inputs } : {}),
  };
  if (state.reverse) observation.y_factor = -1;
  if (state.sort) Object.assign(observation, { sort: true, repeated_x: "average" });
  if (state.early && begin !== undefined) observation.x_from = begin;
  if (gross_errors.length) observation.gross_errors = gross_errors;
  if (notes.length) observation.notes = notes;
  return observation;
}
