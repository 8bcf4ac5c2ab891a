// The units that a reader has chosen, remembered in this browser: lengths, times and stresses of fits.

import { measure } from "./new/units.js";

const FAMILIES = {
  length: { name: "Lengths", units: ["mm", "cm", "m"] },
  time: { name: "Times", units: ["s", "min", "h", "day"] },
  stress: { name: "Stresses", units: ["kPa", "MPa"] },
};
const KEPT = "geoswarm-unit-";
const ALIASES = { d: "day", days: "day", minute: "min", hour: "h" };

const known = (unit) => ALIASES[unit] ?? unit;
const familyOf = (unit) => Object.keys(FAMILIES).find((name) => FAMILIES[name].units.includes(known(unit))) ?? null;

function chosen(family) {
  try {
    const unit = localStorage.getItem(KEPT + family);
    return FAMILIES[family].units.includes(unit) ? unit : null;
  } catch {
    return null; // storage may be forbidden
  }
}

/** Choose a unit of a family; null: as the data are given. */
export function choose(family, unit) {
  try {
    if (unit === null) localStorage.removeItem(KEPT + family);
    else localStorage.setItem(KEPT + family, unit);
  } catch {
    // the choice then lasts for nothing: the units of the data are shown
  }
}

/** Families that the quantities of a fit have: [{family, name, units, chosen}]. */
export function choices(fit) {
  const there = new Set(
    fit.series.flatMap(({ x_unit, y_unit }) => [familyOf(x_unit), familyOf(y_unit)]).filter(Boolean),
  );
  return Object.keys(FAMILIES)
    .filter((name) => there.has(name))
    .map((family) => ({
      family,
      name: FAMILIES[family].name,
      units: FAMILIES[family].units,
      chosen: chosen(family),
    }));
}

/** The unit to show a unit of the data in, and the number of it in one of these. */
function shownIn(unit) {
  const family = familyOf(unit),
    wanted = family && chosen(family);
  if (!wanted || wanted === known(unit)) return [unit, 1];
  return [wanted, measure(known(unit))[0] / measure(wanted)[0]];
}

/** A fit, as GET …/fit answers, in the chosen units. */
export function converted(fit) {
  return scaled(
    fit,
    new Map(fit.series.map((one) => [one.series, { x: shownIn(one.x_unit), y: shownIn(one.y_unit) }])),
  );
}

/** A fit of the same series alone, in its units; null where it has no such series, or other quantities. */
export function inUnits(fit, { series: name, x_unit: x, y_unit: y }) {
  const series = fit.series.filter((one) => one.series === name);
  if (!series.length) return null;
  const [across, up] = [factor(series[0].x_unit, x), factor(series[0].y_unit, y)];
  if (across === null || up === null) return null;
  const curves = fit.curves
    .filter(({ values }) => values[name])
    .map((curve) => ({ ...curve, values: { [name]: curve.values[name] }, shares: [] }));
  return scaled({ ...fit, series, curves }, new Map([[name, { x: [x, across], y: [y, up] }]]));
}

/** How many of a unit are one of another; null where they measure other things. */
function factor(from, to) {
  if (from === to) return 1;
  const [one, other] = [measure(known(from)), measure(known(to))];
  return one && other && one[1] === other[1] ? one[0] / other[0] : null;
}

function scaled(fit, units) {
  const by = (factor) => (value) => (value === null ? null : value * factor);
  return {
    ...fit,
    series: fit.series.map((one) => {
      const {
        x: [x_unit, across],
        y: [y_unit, up],
      } = units.get(one.series);
      return {
        ...one,
        x_unit,
        y_unit,
        x: one.x.map(by(across)),
        breaks: one.breaks.map(by(across)),
        gross_x: one.gross_x.map(by(across)),
        measured: one.measured.map(by(up)),
        gross_measured: one.gross_measured.map(by(up)),
      };
    }),
    curves: fit.curves.map((curve) => ({
      ...curve,
      values: Object.fromEntries(
        Object.entries(curve.values).map(([name, values]) => [name, values.map(by(units.get(name).y[1]))]),
      ),
      shares: curve.shares.map((share) => {
        const [unit, factor] = shownIn(share.unit);
        return { ...share, unit, root_mean_square: by(factor)(share.root_mean_square) };
      }),
    })),
  };
}
