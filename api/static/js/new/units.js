// Units that are offered for a dimension; others may be written.
const OFFERED = {
  day: ["s", "min", "h", "day", "week", "year"],
  m: ["um", "mm", "cm", "m"],
  kPa: ["Pa", "kPa", "MPa", "bar", "kN/m^2"],
  degree: ["degree", "rad"],
  dimensionless: ["dimensionless", "%"],
};

export const plainBase = (unit) => (["", "1", "-"].includes(unit) ? "dimensionless" : unit);

/** Units that suit a base unit, that one first of all known. */
export function unitsOf(base) {
  const plain = plainBase(base ?? "");
  return OFFERED[plain] ?? [plain];
}

/** Fitting columns for a series' x and y: by dimension, else by place. */
export function guessedColumns(columns, series) {
  const usable = columns.map((column, i) => ({ ...column, i })).filter((column) => column.kind !== "text");
  const suits = (base, taken) => usable.find((one) => one.i !== taken && one.base === plainBase(base));
  const x = suits(series?.x_unit ?? "day", -1) ?? usable[0];
  const y = suits(series?.y_unit ?? "m", x?.i) ?? usable.find((one) => one.i !== x?.i && one.base === null) ?? usable.find((one) => one.i !== x?.i);
  return { x: x?.i ?? null, y: y?.i ?? null };
}
