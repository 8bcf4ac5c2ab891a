// Inputs that are bound to a place in the draft, with label, unit, help and the place for what is wrong.
import { element } from "../dom.js";
import { number } from "../format.js";
import { pathText } from "./draft.js";
import { valueWithUnit } from "./units.js";
import { placeOf } from "./words.js";

/** Id of the input of a path. */
export const idOf = (path) => `f-${pathText(path).replace(/[^\w]/g, "-")}`;

/** What an input for numbers holds: a number, null for "none", undefined when empty, else the text for the service to judge. "20 mm" is taken where `unit` is a length. */
export function numberOf(text, nullable = false, unit = undefined) {
  const plain = text.trim();
  if (plain === "") return undefined;
  if (nullable && /^(none|null)$/i.test(plain)) return null;
  const value = Number(/^[+-]?\d*,\d+(e[+-]?\d+)?$/i.test(plain) ? plain.replace(",", ".") : plain);
  return Number.isFinite(value) ? value : unit === undefined ? plain : (valueWithUnit(plain, unit) ?? plain);
}

export function shown(value) {
  if (value === null) return "none";
  if (value === undefined) return "";
  return typeof value === "object" ? JSON.stringify(value) : String(value);
}

/** Where messages about a path appear. */
export function errorPlace(path) {
  const text = pathText(path);
  return element("p", { class: "error", id: `${idOf(path)}-error`, dataset: { error: text } });
}

/**
 * A labelled input. `kind`: number, text, mixed (a number or text), numbers (a list) or select (`options`: [value, label]).
 * `fallback` is what holds when nothing is given; choosing it gives nothing. `bare` hides the label (in tables), `blank` is
 * what an empty input writes: undefined, which removes the key, unless given.
 */
export function field(
  draft,
  path,
  {
    label,
    kind = "text",
    unit,
    help,
    fallback,
    nullable,
    options,
    typical,
    required,
    bare,
    onchange,
    wide,
    blank,
  } = {},
) {
  const id = idOf(path);
  const unusual = typical || unit ? element("p", { class: "unusual", role: "status", hidden: true }) : null;
  const write = (value) => {
    draft.write(path, value === undefined ? blank : value);
    warn(unusual, value, typical, unit);
    onchange?.(value);
  };
  const given = draft.read(path) === blank ? undefined : draft.read(path);
  const input =
    kind === "select" ? select(given, fallback, options, write) : text(given, kind, nullable, fallback, write, unit);
  input.id = id;
  input.dataset.path = pathText(path);
  const described = [help || typical ? `${id}-help` : null, `${id}-error`].filter(Boolean).join(" ");
  input.setAttribute("aria-describedby", described);
  if (required) input.setAttribute("aria-required", "true");
  warn(unusual, given, typical, unit);
  const unitText = unit && unit !== "1" && unit !== "-" && unit !== "dimensionless" ? unit : null;
  return element(
    "div",
    { class: `field ${wide ? "wide-field" : ""}` },
    element(
      "label",
      { for: id, class: bare ? "visually-hidden" : null },
      label,
      unitText && bare ? ` [${unitText}]` : null,
    ),
    element(
      "div",
      { class: "with-unit" },
      input,
      unitText && !bare ? element("span", { class: "unit" }, unitText) : null,
    ),
    help || typical
      ? element(
          "p",
          { class: bare ? "visually-hidden" : "help", id: `${id}-help` },
          help ?? null,
          typical ? ` Usual: ${number(typical[0])} to ${number(typical[1])}${unitText ? ` ${unitText}` : ""}.` : null,
        )
      : null,
    unusual,
    errorPlace(path),
  );
}

/** A word beside a number outside its usual range: no mistake, but often a slip of units. */
function warn(place, value, typical, unit) {
  if (!place) return;
  if (typeof value === "string" && /^[+-]?[\d.,]+\s*[a-z°%µ]/i.test(value)) {
    // refused: the service would only ask for a number
    place.hidden = false;
    place.textContent = `${value} cannot be given in ${unit}: write a number without a thousands separator, or such a value with a unit of the same kind.`;
    return;
  }
  if (!typical) return void (place.hidden = true);
  const [low, high] = typical;
  place.hidden = typeof value !== "number" || (value >= low && value <= high);
  if (!place.hidden)
    place.textContent = `⚠ Outside the usual range, ${number(low)} to ${number(high)}${unit ? ` ${unit}` : ""}: is the unit right?`;
}

function text(value, kind, nullable, fallback, write, unit) {
  const numeric = kind === "number";
  const place = fallback === undefined || fallback === null || typeof fallback === "object" ? null : String(fallback);
  const input = element("input", {
    type: "text",
    value: Array.isArray(value) ? value.join(", ") : shown(value),
    placeholder: place,
    spellcheck: "false",
    autocomplete: "off",
    inputmode: numeric ? "decimal" : null,
    class: numeric ? "n" : null,
  });
  input.addEventListener("input", () => write(parsed(input.value, kind, nullable, unit)));
  if (numeric && unit)
    input.addEventListener("change", () => {
      // "20 mm" becomes what it is in the unit beside the field
      const taken = numberOf(input.value, nullable, unit);
      if (typeof taken === "number" && !Number.isFinite(Number(input.value.replace(",", "."))))
        input.value = shown(taken);
    });
  return input;
}

function parsed(given, kind, nullable, unit) {
  if (kind === "number") return numberOf(given, nullable, unit || undefined);
  if (kind === "mixed") return numberOf(given, nullable);
  if (kind === "numbers")
    return given.trim() === ""
      ? undefined
      : given
          .split(/[;\s]+|,\s*/)
          .filter(Boolean)
          .map((one) => numberOf(one));
  if (kind === "texts") return given.trim() === "" ? undefined : given.split(/\s*,\s*/).filter(Boolean);
  if (kind === "json") return jsonOf(given);
  return given === "" ? undefined : given;
}

function jsonOf(given) {
  try {
    return given.trim() === "" ? undefined : JSON.parse(given);
  } catch {
    return given;
  }
}

function select(value, fallback, options, write) {
  const given = value === undefined ? fallback : value;
  const known = options.some(([one]) => one === given);
  const all = known ? options : [[given, given === undefined ? "choose …" : String(given)], ...options];
  const made = element(
    "select",
    {},
    all.map(([one, name], i) => element("option", { value: String(i), selected: one === given }, name)),
  );
  made.addEventListener("change", () => {
    const chosen = all[Number(made.value)][0];
    write(chosen === fallback ? undefined : chosen);
  });
  return made;
}

/** A checkbox; unchecked and the default are not written. */
export function checkbox(draft, path, { label, help, fallback = false, onchange } = {}) {
  const id = idOf(path);
  const input = element("input", {
    type: "checkbox",
    id,
    checked: draft.read(path) ?? fallback,
    dataset: { path: pathText(path) },
    "aria-describedby": help ? `${id}-help` : null,
  });
  input.addEventListener("change", () => {
    draft.write(path, input.checked === fallback ? undefined : input.checked);
    onchange?.(input.checked);
  });
  return element(
    "div",
    { class: "field check" },
    element("label", { for: id }, input, ` ${label}`),
    help ? element("p", { class: "help", id: `${id}-help` }, help) : null,
    errorPlace(path),
  );
}

const MISSING = /^is missing|, not null$/;

/** Whether an issue is something that is still to be given, not a mistake. */
export const isTodo = (issue) => MISSING.test(issue.message);

/** Show issues at their fields, or at the nearest thing around them; what is only missing, when `strict`. */
export function showIssues(root, issues, strict) {
  for (const input of root.querySelectorAll("[aria-invalid]")) input.removeAttribute("aria-invalid");
  const places = new Map();
  for (const place of root.querySelectorAll("[data-error]")) {
    place.textContent = "";
    places.set(place.dataset.error, place);
  }
  for (const issue of issues) {
    if (isTodo(issue) && !strict) continue;
    let path = issue.path;
    while (path && !places.has(path)) path = path.slice(0, Math.max(path.lastIndexOf("."), path.lastIndexOf("["), 0));
    const place = places.get(path);
    if (!place) continue;
    const rest = path === issue.path ? "" : `${placeOf(issue.path.slice(path.length).replace(/^\./, ""))}: `;
    place.textContent += `${place.textContent ? "\n" : ""}${rest}${issue.message}`;
    root.querySelector(`[data-path="${CSS.escape(path)}"]`)?.setAttribute("aria-invalid", "true");
  }
}
