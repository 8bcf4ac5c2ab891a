// Inputs of the import, which belong to no place of the draft yet, and the first rows of a file.
import { element, tableHead } from "../../dom.js";
import { count } from "../../format.js";
import { translate } from "../../language.js";

export const BEFORE = "Leave out readings before"; // the beginning of a series: strain or time 0, stage 1
export const LEAVE_OUT = "Leave out rows without a number in every column";
export const NO_READING = "Numbers that stand for no reading";

const BOXES = { incomplete_rows: LEAVE_OUT, no_reading: NO_READING, x_from: `${BEFORE} stage` };
const FIELDS = {
  sheet: "map-sheet",
  x_column: "map-x",
  y_column: "map-y",
  x_unit: "map-x-unit",
  y_unit: "map-y-unit",
  x_dates: "map-dates",
  x_time_column: "map-x_time_column",
  x_origin: "map-origin",
  y_minus: "map-y_minus",
  decimal_sign: "map-sign",
  x_factor: "map-x-factor",
  y_factor: "map-y-factor",
  load_unit: "map-load-unit",
  load_column: "map-load_column",
};

/** What the field for a key of the observation is called here; nothing for one that the import does not ask for. */
export const labelHere = (key) => BOXES[key] ?? document.getElementById(FIELDS[key])?.labels[0].textContent;

const NUMERAL = /\d(?:[.,]?\d)*/g;

/** A text in the language of the page whose numbers stay as the file writes them: “1.000” is in doubt, not “1,000”. */
function asWritten(text) {
  const own = text.match(NUMERAL) ?? [];
  return translate(text).replace(NUMERAL, (numeral) => own.shift() ?? numeral);
}

/** An element with such a text. */
export const written = (tag, text) => element(tag, { translate: "no" }, asWritten(text));

/** Names that the file gives, as options: [value, name, disabled?]. */
export const ofFile = (value, name, disabled = false) => [value, name, disabled, true];

/** Choices whose names show how numbers are written. */
export const ofNumbers = (options) => options.map(([value, name]) => ofFile(value, asWritten(name)));

/** A choice among [value, name, disabled?, of the file?]; a value that is none of them is still to be chosen. */
export function choice(id, label, options, value, act, { help = null, asked = false, wide = false } = {}) {
  const known = options.some(([one]) => one === value);
  const all = known ? options : [[value, "choose …"], ...options];
  const made = element(
    "select",
    { id, "aria-describedby": help ? `${id}-help` : null, onchange: () => act(all[Number(made.value)][0]) },
    all.map(([one, name, disabled, own], i) =>
      element("option", { value: String(i), selected: one === value, disabled, translate: own ? "no" : null }, name),
    ),
  );
  return element(
    "div",
    { class: `field ${asked && !known ? "asked" : ""} ${wide ? "wide-field" : ""}` },
    element("label", { for: id }, label),
    made,
    help ? element("p", { class: "help", id: `${id}-help` }, help) : null,
  );
}

export function words(
  id,
  label,
  value,
  act,
  { help = null, placeholder = null, list = null, wrong = null, asked = false } = {},
) {
  const input = element("input", {
    type: "text",
    id,
    value,
    placeholder,
    list: list ? `${id}-list` : null,
    spellcheck: "false",
    autocomplete: "off",
    "aria-describedby": help || wrong ? `${id}-help` : null,
    "aria-invalid": wrong ? "true" : null,
    oninput: () => act(input.value.trim()),
  });
  return element(
    "div",
    { class: `field ${asked ? "asked" : ""}` },
    element("label", { for: id }, label),
    input,
    list
      ? element(
          "datalist",
          { id: `${id}-list` },
          list.map((one) => element("option", { value: one })),
        )
      : null,
    help || wrong ? element("p", { class: wrong ? "error" : "help", id: `${id}-help` }, wrong ?? help) : null,
  );
}

export function flag(id, label, on, act) {
  const input = element("input", { type: "checkbox", id, checked: on, onchange: () => act(input.checked) });
  return element("div", { class: "field check" }, element("label", { for: id }, input, ` ${label}`));
}

/** The first rows as they stand in the file; `roles` says of which columns x and y are taken: {index: "x"}. */
export function firstRows(file, roles) {
  const shown = Math.max(0, ...file.columns.map((column) => column.first.length));
  const role = (i) => (roles[i] ? element("span", { class: "role" }, roles[i]) : null);
  const number = (column) => (column.kind === "number" ? "n" : "");
  return element(
    "div",
    { class: "wide first-rows", tabindex: "0", role: "region", "aria-label": "First rows of the file" },
    element(
      "table",
      {},
      element("caption", {}, file.rows > shown ? `First rows of ${count(file.rows)}` : `${count(file.rows)} rows`),
      tableHead(
        file.columns.map((column, i) =>
          element(
            "th",
            { scope: "col", class: `${number(column)} ${roles[i] ? "taken" : ""}`, translate: "no" },
            column.name,
            role(i),
          ),
        ),
      ),
      element(
        "tbody",
        {},
        Array.from({ length: shown }, (_, row) =>
          element(
            "tr",
            {},
            file.columns.map((column, i) =>
              element(
                "td",
                { class: `${number(column)} ${roles[i] ? "taken" : ""}`, translate: "no" },
                column.first[row] ?? "",
              ),
            ),
          ),
        ),
      ),
    ),
  );
}
