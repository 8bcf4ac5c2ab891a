// What few files need: cells or names, a second gauge, times of day, weights, gross errors, further quantities, remarks.
import { element } from "../../dom.js";
import { button } from "../schema_form.js";
import { choice, flag, ofFile, ofNumbers, words } from "./inputs.js";
import { CELLS, doubts, specimenColumn } from "./choices.js";

export const SIGNS = ofNumbers([
  ["point", "1.5 and 1,000: a point before decimals"],
  ["comma", "1,5 and 1.000: a comma before decimals"],
]);
export const DATES = [
  ["day_first", "31/12/2024: the day first"],
  ["month_first", "12/31/2024: the month first"],
  ["year_first", "24/12/31: the year first"],
];
export const CLOCKS = [
  ["hh:mm:ss", "00:01:30: hours, minutes, seconds since the start"],
  ["hh:mm", "00:15: hours and minutes since the start"],
  ["mm:ss", "00:15: minutes and seconds since the start"],
];

/** The fields below "More about these columns"; `change(redraw)` after each. `open` parameters: a formula may use inputs. */
export function moreFields(file, state, change, open) {
  const of = state.more;
  const columns = file.columns.map((column, i) => ofFile(i, column.name));
  const set =
    (key, redraw = false) =>
    (value) => {
      of[key] = value;
      change(redraw);
    };
  const column = (key, label, help) =>
    choice(`map-${key}`, label, [[undefined, "none"], ...columns], of[key], set(key), { help });
  const asked = doubts(file, state);
  const entries = file.columns[of.whereColumn]?.entries ?? {};
  return element(
    "div",
    { class: "fields" },
    column("y_minus", "Subtract from y", "The other gauge, or that of the frame: row by row."),
    column("weight_column", "Weights"),
    column("gross_error_column", "Gross errors", "A column with an entry in the row of each gross error."),
    column("load_column", "Loads of the stages", "Constant over each stage: fills in the stages of the forward model."),
    column("x_time_column", "Time of day", "Where the column of x holds dates alone."),
    words("map-origin", "x = 0 is at", of.x_origin ?? "", set("x_origin"), {
      placeholder: "2024-03-01 08:30",
      help: "Where x holds dates; the first of them unless given.",
    }),
    asked.dates || asked.clock
      ? null
      : choice(
          "map-dates",
          "Dates of x",
          [[null, "as they are"], ...DATES, ["serial", "numbers of days, as spreadsheets count"], ...CLOCKS],
          state.dates,
          (value) => {
            state.dates = value;
            change(true);
          },
        ),
    asked.numbers
      ? null
      : choice("map-sign", "Numbers", [[null, "as they are"], ...SIGNS], state.decimal, (value) => {
          state.decimal = value;
          change(false);
        }),
    specimenColumn(file, state) === null
      ? choice(
          "map-where",
          "Only rows with",
          [[undefined, "all rows"], ...columns.filter(([i]) => Object.keys(file.columns[i].entries).length)],
          of.whereColumn,
          (value) => {
            of.whereEntry = undefined;
            set("whereColumn", true)(value);
          },
          { help: "An empty cell means the entry above it." },
        )
      : null,
    Object.keys(entries).length
      ? choice(
          "map-entry",
          `${file.columns[of.whereColumn].name} is`,
          Object.entries(entries).map(([entry, rows]) => [entry, `${entry} (${rows} rows)`]),
          of.whereEntry,
          set("whereEntry"),
        )
      : null,
    words("map-notes", "Where the readings come from", of.notes ?? "", set("notes"), {
      help: "For the report: laboratory, standard, date.",
    }),
    words("map-x-factor", "Multiply x by", of.x_factor ?? "", set("x_factor"), {
      placeholder: "0.001/0.02",
      help: "Makes a strain of a length: give the unit “dimensionless”, and 0.001/0.02 for mm of a specimen of 20 mm.",
    }),
    words("map-y-factor", "Multiply y by", of.y_factor ?? "", set("y_factor"), {
      placeholder: "1/0.00385",
      help: "Makes a stress of a force: give the unit “kPa”, and 1/0.00385 for kN on 38.5 cm².",
    }),
    flag("map-reverse", "Reverse the sign of y", state.reverse, (on) => {
      state.reverse = on;
      change(false);
    }),
    open ? inputFields(columns, of, change) : null,
    state.x === CELLS || state.y === CELLS
      ? null
      : element(
          "p",
          { class: "help wide-field" },
          "Cells such as B5:B30, a letter (B:B) or a name of the workbook: choose “by cells or name” as the column.",
        ),
  );
}

/** Further quantities that a formula uses: name and column of each. */
function inputFields(columns, of, change) {
  const given = of.inputs ?? [];
  const rows = given.map(([name, from], i) =>
    element(
      "div",
      { class: "fields wide-field" },
      words(
        `map-input-${i}`,
        `Name of quantity ${i + 1}`,
        name,
        (value) => {
          given[i][0] = value;
          change(false);
        },
        { help: "As the formula calls it." },
      ),
      choice(`map-input-${i}-column`, "Column", columns, from, (value) => {
        given[i][1] = value;
        change(false);
      }),
      button(`Remove quantity ${i + 1}`, () => {
        of.inputs = given.filter((_, one) => one !== i);
        change(true);
      }),
    ),
  );
  return [
    rows,
    element(
      "div",
      { class: "wide-field" },
      button("Add a further quantity", () => {
        of.inputs = [...given, ["", null]];
        change(true);
      }),
    ),
  ];
}
