// Numbers, units and times for readers.
import { locale } from "./language.js";

/** A number with this number of significant digits, `1.2·10⁻⁵` where that is shorter; a dash for what is not a number. */
export function number(value, digits = 4) {
  if (value === null || value === undefined || !Number.isFinite(value)) return "–";
  if (value === 0) return "0";
  const size = Math.abs(value);
  if (size >= 1e-3 && size < 1e6) return String(Number(value.toPrecision(digits)));
  return scientific(...value.toExponential(digits - 1).split("e"));
}

/** A power of ten with its factor, both given as text: 1.45·10⁻⁸. */
export function scientific(mantissa, exponent) {
  const raised = [...String(Number(exponent))].map((sign) => "⁻⁰¹²³⁴⁵⁶⁷⁸⁹"["-0123456789".indexOf(sign)]).join("");
  return Number(mantissa) === 1 ? `10${raised}` : `${String(Number(mantissa))}·10${raised}`;
}

/** Both ends of an interval, with as many digits as its width needs, `least` at least: "2.3481 … 2.3519". */
export function ends(low, high, least = 4) {
  const width = high - low;
  const size = Math.max(Math.abs(low), Math.abs(high));
  const digits =
    width > 0
      ? Math.min(Math.max(Math.floor(Math.log10(size)) - Math.floor(Math.log10(0.1 * width)) + 1, least), 15)
      : 4;
  return `${number(low, digits)} … ${number(high, digits)}`;
}

/** A value with the digits that an interval of this width leaves it: to a tenth of the width, two at least. */
export function precise(value, width) {
  if (!(width > 0) || !value) return number(value);
  return number(
    value,
    Math.min(Math.max(Math.floor(Math.log10(Math.abs(value))) - Math.floor(Math.log10(width)) + 2, 2), 10),
  );
}

/** A coefficient with two decimals, never "-0.00". */
export function coefficient(value) {
  return (Math.abs(value) < 0.005 ? 0 : value).toFixed(2);
}

/** A name as words. */
export function plain(name) {
  return name.replaceAll("_", " ");
}

/** The test that a series of several tests belongs to; of one test: "". */
export function partOf(series) {
  return series.slice(0, Math.max(series.indexOf("."), 0));
}

/** A whole number with thin spaces: 20 000. */
export function count(value) {
  return value === null || value === undefined ? "–" : String(Math.round(value)).replace(/\B(?=(\d{3})+$)/g, "\u202f");
}

/** A share from 0 to 1 in per cent. */
export function percent(share, digits = 0) {
  return Number.isFinite(share) ? `${(100 * share).toFixed(digits)} %` : "–";
}

/** A label with its unit: `settlement [mm]`; units of one ("", "1", "-") are left out. */
export function withUnit(label, unit) {
  return unit && unit !== "1" && unit !== "-" ? `${label} [${unit}]` : label;
}

/** What the y axis of a series is beside its title: that of a settlement points downwards. */
export function direction(series, quantity) {
  return quantity === "settlement" || /settlement$/.test(series) ? { autorange: "reversed" } : {};
}

/** A value with its unit. */
export function amount(value, unit, digits = 3) {
  return value === null || !unit || ["1", "-", "dimensionless"].includes(unit)
    ? number(value, digits)
    : `${number(value, digits)} ${unit}`;
}

/** Unit of the objective: the square of that of the series ([{y_unit}]), nothing where they differ. */
export function objectiveUnit(series) {
  const units = [...new Set(series.map(({ y_unit }) => y_unit))];
  return units.length === 1 && units[0] && !["1", "-", "dimensionless"].includes(units[0]) ? `${units[0]}²` : "";
}

/** A duration [s] as one reads it: 12 ms, 0.8 s, 42 s, 3 min 5 s, 2 h 10 min, 3 d 4 h. */
export function duration(seconds) {
  if (seconds === null || seconds === undefined || !Number.isFinite(seconds)) return "–";
  if (seconds > 0 && seconds < 0.1) return `${number(1000 * seconds, 2)} ms`;
  if (seconds < 10) return `${number(seconds, 2)} s`;
  const whole = Math.round(seconds);
  const steps = [
    ["d", 86400],
    ["h", 3600],
    ["min", 60],
    ["s", 1],
  ];
  const first = steps.findIndex(([, size]) => whole >= size);
  const [unit, size] = steps[first];
  const next = steps[first + 1];
  const rest = next ? Math.floor((whole % size) / next[1]) : 0;
  return `${Math.floor(whole / size)} ${unit}` + (rest ? ` ${rest} ${next[0]}` : "");
}

/** How long ago a timestamp of the service (ISO 8601, UTC) was. */
export function age(timestamp, now = Date.now()) {
  if (!timestamp) return "–";
  const seconds = Math.max(0, (now - new Date(timestamp).getTime()) / 1000);
  return seconds < 10
    ? "just now"
    : `${duration(seconds < 60 ? 10 * Math.floor(seconds / 10) : seconds - (seconds % 60))} ago`;
}

/** A timestamp in the reader's own time zone. */
export function moment(timestamp) {
  return timestamp ? new Date(timestamp).toLocaleString(locale(), { dateStyle: "medium", timeStyle: "medium" }) : "–";
}

const SYMBOLS = {
  lambda_star: "λ*",
  kappa_star: "κ*",
  mu_star: "μ*",
  lambda: "λ",
  kappa: "κ",
  phi: "φ",
  psi: "ψ",
  nu: "ν",
  nu_ur: "ν_ur",
};

const POWERS = /(?<![\w.])(\d+(?:\.\d+)?)e([+-]?\d+)(?![\w.]*\w)/g;
const NAMES = new RegExp(`(?<!\\w)(${Object.keys(SYMBOLS).join("|")})(?!\\w)`, "g");

/** A sentence of the service as the page writes names and numbers: λ* and 1.45·10⁻⁸ for lambda_star and 1.45e-08; 95 % is not broken. */
export function typeset(text) {
  return text
    .replace(POWERS, (_, mantissa, exponent) => scientific(mantissa, exponent))
    .replace(NAMES, (name) => SYMBOLS[name])
    .replace(/(?<=\d) %/g, "\u00a0%");
}

/** A parameter's label in the field's letters; names with a part before a dot keep it. */
export function symbol(name) {
  const cut = name.lastIndexOf(".") + 1;
  return name.slice(0, cut) + (SYMBOLS[name.slice(cut)] ?? name.slice(cut));
}

/** The tags of a text with commas between them. */
export const tagsIn = (text) =>
  text
    .split(",")
    .map((tag) => tag.trim())
    .filter(Boolean);
