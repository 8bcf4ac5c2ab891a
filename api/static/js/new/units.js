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

const LENGTH = { um: 1e-6, µm: 1e-6, mm: 1e-3, cm: 1e-2, m: 1, km: 1e3 };
const TIME = { s: 1, min: 60, h: 3600, d: 86400, day: 86400, days: 86400, week: 604800, a: 31557600, year: 31557600 };
const FORCE = { N: 1, kN: 1e3, MN: 1e6 };
const STRESS = { Pa: 1, kPa: 1e3, MPa: 1e6, GPa: 1e9, bar: 1e5 };
const ANGLE = { degree: 1, "°": 1, deg: 1, rad: 180 / Math.PI };
const NUMBER = { "": 1, 1: 1, "-": 1, dimensionless: 1, "%": 0.01 };
// [factor, exponents of length, time, force and angle]
const KNOWN = Object.fromEntries(
  [
    [LENGTH, [1, 0, 0, 0]],
    [TIME, [0, 1, 0, 0]],
    [FORCE, [0, 0, 1, 0]],
    [STRESS, [-2, 0, 1, 0]],
    [ANGLE, [0, 0, 0, 1]],
    [NUMBER, [0, 0, 0, 0]],
  ].flatMap(([units, powers]) => Object.entries(units).map(([name, factor]) => [name, [factor, powers]])),
);

/** Factor and exponents of a unit such as kN/m^3, m2/day or 1/h; null for one that is not known. */
export function measure(unit) {
  let factor = 1;
  const powers = [0, 0, 0, 0];
  for (const [
    ,
    sign,
    name,
    power,
  ] of `*${unit.replaceAll("·", "*").replaceAll("²", "2").replaceAll("³", "3")}`.matchAll(
    /([*/])([^*/^\d]*|1)\^?(\d?)/g,
  )) {
    const known = KNOWN[name.trim()];
    if (!known) return null;
    const times = (sign === "/" ? -1 : 1) * Number(power || 1);
    factor *= known[0] ** times;
    known[1].forEach((exponent, i) => {
      powers[i] += times * exponent;
    });
  }
  return [factor, powers.join()];
}

/** "20 mm" as a number in the unit of a field; null where it is no value with a unit, one of another dimension, or "1,250 mm", which may be either. */
export function valueWithUnit(text, unit) {
  if (/^[+-]?[1-9]\d{0,2},\d{3}(?!\d)/.test(text.trim())) return null;
  const [, given, with_] = text.trim().match(/^([+-]?(?:\d+[.,]?\d*|[.,]\d+)(?:e[+-]?\d+)?)\s*([^\d\s.,+-].*)$/i) ?? [];
  const from = with_ && measure(with_),
    to = measure(unit ?? "");
  return !from || !to || from[1] !== to[1]
    ? null
    : Number(((Number(given.replace(",", ".")) * from[0]) / to[0]).toPrecision(12));
}
