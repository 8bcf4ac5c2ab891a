// Which column of a file suits which series: by the words of headings, which the service knows, and by dimension.
import { plainBase, unitsOf } from "../units.js";

const PREFIX = /^(stage|time|path|consolidation)_/;

const key = (words) => words.toLowerCase().replace(/[^\p{L}\p{N}]+/gu, "_");
const short = (name) => name.split(".").at(-1).replace(PREFIX, "");
const heading = (column) => column.name.trim().replace(/\s+/g, " ").toLowerCase();

/** Whether a column can be read as numbers, dates or, once it is said how, times. */
export const readable = (column) => column.kind !== "text";

/** How a problem file calls a column: by its heading where no other has it, else by its letters; by its cells where it is a row. */
export function reference(file, i) {
  const column = file.columns[i];
  if (lies(column)) return column.letters;
  const alone = file.columns.filter((one) => heading(one) === heading(column)).length === 1;
  return alone && column.name.length < 200 && !/^column \d+$/.test(column.name)
    ? column.name
    : `${column.letters}:${column.letters}`;
}

/** Models that know no quantities (formulas, programs) take numbers as they are where they declare no unit. */
export const unitless = (info, axis) => info.x_quantity === "x" && plainBase(info[`${axis}_unit`]) === "dimensionless";

/** The dimension that a unit belongs to, of those that are offered; null for one that is not known here. */
function dimensionOf(unit) {
  return ["day", "m", "kPa", "degree", "dimensionless"].find((base) => unitsOf(base).includes(plainBase(unit))) ?? null;
}

/** Whether a column is a heave, whose sign is to be asked for, or a height: lengths, and no settlements. */
const otherLength = (column) => ["heave", "height"].some((one) => column.quantities.includes(one));

/** Whether x are numbers of stages, which the service finds by their loads, too. */
export const byLoad = (info, axis) => axis === "x" && info?.x_quantity === "stage";

/** What is wrong with a unit for an axis of a series; null where nothing is known to be. */
export function conflict(info, axis, unit, column) {
  if (!info || unitless(info, axis) || (byLoad(info, axis) && dimensionOf(unit) === "kPa")) return null;
  const wanted = plainBase(info[`${axis}_unit`]);
  const base = column?.unit === unit ? column.base : dimensionOf(unit);
  if (!unit || base === null || base === undefined || base === wanted || dimensionOf(wanted) === null) return null;
  const what = column?.unit === unit ? `“${column.name}” is in ${unit}` : `${unit} is given`;
  const divided =
    wanted === "dimensionless" && info[`${axis}_quantity`].includes("strain") && dimensionOf(unit) === "m"
      ? ` A strain needs the unit “dimensionless”, and “Multiply ${axis} by” below.`
      : "";
  const needed =
    wanted === "dimensionless"
      ? "has no unit but % or 1"
      : `needs a unit such as ${unitsOf(wanted).slice(0, 3).join(", ")}`;
  const quantity = info[`${axis}_quantity`];
  const whose = quantity === info.name ? quantity : `${quantity} of ${info.name}`;
  return `${what}, but ${whose} ${needed}. Choose another column or series; correct the unit only if the heading is wrong.${divided}`;
}

/** Place among what a heading may mean, of a series' quantity; -1: none. */
function meaning(column, info) {
  const names = [short(info.name), key(info.y_quantity)];
  const place = column.quantities.findIndex((one) => names.includes(one));
  return place >= 0 || !names.includes(key(column.label)) ? place : 0;
}

/** Numbers of stages that come again choose a part of a table, they are no x. */
const meansX = (column, info) =>
  column.quantities.some((one) => key(info.x_quantity) === one || key(info.x_quantity).endsWith(`_${one}`)) &&
  !(info.x_quantity === "stage" && new Set(column.values).size < column.values.length);

/** Whether a column is a row of the sheet. */
export const lies = (column) => column?.letters.includes(":") ?? false;

const LOADS = ["axial_stress", "normal_stress", "effective_stress"];

/** Whether a column seems to hold loads, by its words. */
export const meansLoad = (column) =>
  column.kind === "number" && (column.base ?? "kPa") === "kPa" && column.quantities.some((one) => LOADS.includes(one));

/** Whether a column of loads is chosen in place of numbers of stages. */
export const loadsAsX = (info, axis, column) => byLoad(info, axis) && column !== undefined && meansLoad(column);

/** Whether two columns may be x and y of readings; rows of a sheet differ in length. */
const paired = (one, other) => one !== other && !(lies(other) && one.values.length !== other.values.length);

const only = (found) => (found.length === 1 ? found[0] : undefined);

/** The column of x for a series, null where it is not plain. */
export function columnOfX(file, info, y) {
  const usable = file.columns
    .map((column, i) => ({ column, i }))
    .filter(({ column }) => readable(column) && column.kind !== "clock" && paired(column, file.columns[y]));
  if (lies(file.columns[y])) usable.sort((one, other) => Math.abs(one.i - y) - Math.abs(other.i - y)); // a block has both
  const found =
    usable.find(({ column }) => meansX(column, info)) ??
    usable.find(
      ({ column }) => column.base !== null && column.base === plainBase(info.x_unit) && column.base !== "dimensionless",
    ) ??
    (byLoad(info, "x") ? usable.find(({ column }) => meansLoad(column)) : undefined) ??
    usable.find(({ column }) => plainBase(info.x_unit) === "day" && column.quantities.includes("time")) ??
    (info.x_quantity.includes("strain") ? only(usable.filter(({ column }) => column.unit === "%")) : undefined) ??
    usable.find(({ column }) => key(column.label) === "x") ??
    ((info.x_quantity === "x" && file.columns.length === 2) || usable.length === 1 ? usable[0] : undefined);
  return found?.i ?? null;
}

/** The column of y for a series, null where no heading says so. */
export function columnOfY(file, info) {
  const usable = file.columns.map((column, i) => ({ column, i })).filter(({ column }) => column.kind === "number");
  const named = usable.map((one) => ({ ...one, place: meaning(one.column, info) })).filter(({ place }) => place >= 0);
  named.sort((one, other) => one.place - other.place || one.i - other.i);
  const alike = usable.filter(
    ({ column }) =>
      column.base !== null &&
      column.base !== "dimensionless" &&
      column.base === plainBase(info.y_unit) &&
      !otherLength(column),
  );
  return (
    named[0]?.i ??
    (alike.length === 1 ? alike[0].i : null) ??
    usable.find(({ column }) => key(column.label) === "y")?.i ??
    null
  );
}

/** The only series and column whose units, and those of a column of x, belong together, where no word says so. */
function byUnits(file, pairs) {
  const fits = (column, unit) =>
    column.base !== null && column.base !== "dimensionless" && column.base === plainBase(unit);
  const found = pairs.filter(
    ({ info, column, y }) =>
      !otherLength(column) &&
      fits(column, info.y_unit) &&
      file.columns.some((one, i) => i !== y && fits(one, info.x_unit)),
  );
  return found.length === 1 ? found[0] : undefined;
}

/** Series and column of y that a file seems to be about: {series, y}; both null where its headings do not say. */
export function likelySeries(file, known) {
  const pairs = known.flatMap((info, place) =>
    file.columns.map((column, y) => ({
      info,
      place,
      column,
      y,
      meant: column.kind === "number" ? meaning(column, info) : -1,
    })),
  );
  const rank = ({ info, place, column, y, meant }) => {
    const x = file.columns.some(
      (one) => readable(one) && paired(one, column) && (meansX(one, info) || (byLoad(info, "x") && meansLoad(one))),
    );
    const fits = column.base === null || column.base === plainBase(info.y_unit);
    return [
      meant,
      x ? 0 : 1,
      fits ? 0 : 1,
      info.name.includes(".") ? 1 : 0,
      PREFIX.test(info.name.split(".").at(-1)) ? 1 : 0,
      place,
      y,
    ];
  };
  const ranked = pairs.filter(({ meant }) => meant >= 0).map((pair) => ({ pair, order: rank(pair) }));
  ranked.sort((one, other) => one.order.map((value, i) => value - other.order[i]).find((step) => step !== 0) ?? 0);
  const best = ranked[0]?.pair ?? byUnits(file, pairs);
  return { series: best?.info.name ?? null, y: best?.y ?? null };
}
