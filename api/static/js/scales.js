// What plots share: round values for an axis, fewer items where not all can be shown, and colours.

import { scientific } from "./format.js";

// Colours of a quantity from low to high: the part of viridis that is visible on white and on black, as in the report.
export const COLOURS = [
  "#46327e",
  "#3f4889",
  "#365d8d",
  "#2e6f8e",
  "#277f8e",
  "#21918c",
  "#1fa187",
  "#2db27d",
  "#46c06f",
  "#6ccd5a",
  "#a2da37",
];

/** Round values between two limits, at most this number; powers of ten on a log scale where two fit. */
export function ticks(lower, upper, scale, most = 4) {
  if (scale === "log" && lower > 0) {
    const first = Math.ceil(Math.log10(lower) - 1e-9),
      last = Math.floor(Math.log10(upper) + 1e-9);
    if (last > first) {
      const step = Math.ceil((last - first + 1) / most);
      return range(first, last, step).map((power) => 10 ** power);
    }
    const found = range(first - 1, last, 1)
      .flatMap((power) => [1, 2, 5].map((digit) => digit * 10 ** power))
      .filter((value) => value >= lower && value <= upper);
    if (found.length > 1) return found.slice(0, most);
  }
  const rough = (upper - lower) / most;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((digit) => digit * power).find((one) => one >= rough * 0.999);
  return range(Math.ceil(lower / step - 1e-9), Math.floor(upper / step + 1e-9), 1).map((n) =>
    Number((n * step).toPrecision(6)),
  );
}

function range(first, last, step) {
  return Array.from({ length: Math.max(0, Math.floor((last - first) / step) + 1) }, (_, n) => first + n * step);
}

/** A tick as short text: 10⁻³, 0.01, 25. */
export function tickText(value) {
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-2 && size < 1e5) return String(Number(value.toPrecision(3)));
  return scientific(...value.toExponential(1).split("e"));
}

/** At most about `most` of the items, evenly chosen, with the first, the last, and (by `keep`) all that matter. */
export function thinned(items, most, keep = () => false) {
  if (items.length <= most) return items;
  const step = (items.length - 1) / (most - 1);
  const chosen = new Set(Array.from({ length: most }, (_, i) => Math.round(i * step)));
  return items.filter((item, i) => chosen.has(i) || keep(item, i));
}
