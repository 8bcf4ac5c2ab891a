import assert from "node:assert/strict";
import { test } from "node:test";

import { beginning, open, suit, taken } from "../../api/static/js/new/import/choices.js";
import { conflict, likelySeries, reference } from "../../api/static/js/new/import/matching.js";

const column = (name, letters, about) => ({
  ...{
    name,
    letters,
    kind: "number",
    quantities: [],
    label: name,
    unit: null,
    base: null,
    first: [],
    values: [1, 2, 3],
  },
  ...{ entries: {}, sheet: null },
  ...about,
});
const FILE = {
  name: "test.csv",
  columns: [
    column("Zeit [min]", "A", { quantities: ["time"], unit: "min", base: "day" }),
    column("Setzung [mm]", "B", { quantities: ["settlement"], unit: "mm", base: "m" }),
    column("Druck [kPa]", "C", { quantities: ["vertical_stress"], unit: "kPa", base: "kPa" }),
  ],
};
const SETTLEMENT = {
  name: "settlement",
  x_quantity: "time",
  x_unit: "day",
  y_quantity: "settlement",
  y_unit: "m",
  x_increasing: true,
};
const POINTS = {
  ...{ x: [1, 2], y: [0.1, 0.2], weight: null, readings: null, independent: null, range: null, inputs: {} },
  ...{ gross_errors: [], notes: [] },
};

test("headings and units choose series, columns and units", () => {
  const likely = likelySeries(FILE, [SETTLEMENT]);
  assert.equal(likely.series, "settlement");
  const state = { ...beginning(), series: "settlement" };
  suit(state, FILE, SETTLEMENT, likely.y);
  assert.deepEqual([state.x, state.y, state.xUnit, state.yUnit], [0, 1, "min", "mm"]);
  assert.deepEqual(open(FILE, state, SETTLEMENT), []);
});

test("a unit of another dimension is a conflict, which says what is needed", () => {
  assert.equal(conflict(SETTLEMENT, "y", "mm", FILE.columns[1]), null);
  const words = conflict(SETTLEMENT, "y", "kPa", FILE.columns[2]);
  assert.match(words, /“Druck \[kPa\]” is in kPa, but settlement needs a unit such as um, mm, cm/);
});

test("a column is called by its heading, or by its letters where two have the same", () => {
  assert.equal(reference(FILE, 1), "Setzung [mm]");
  const twice = { columns: [column("s", "A"), column("S ", "B")] };
  assert.equal(reference(twice, 1), "B:B");
});

test("what was read is taken with its units, and with what was chosen", () => {
  const state = { ...beginning(), series: "settlement", xUnit: "day", yUnit: "mm" };
  assert.deepEqual(taken(POINTS, state, SETTLEMENT), {
    series: "settlement",
    y_unit: "mm",
    points: { x: [1, 2], y: [0.1, 0.2] },
  });
  const chosen = { ...state, reverse: true, sort: true, early: true };
  const noted = { ...POINTS, range: [0, 3], gross_errors: [2], notes: ["one row without a number"] };
  assert.deepEqual(taken(noted, chosen, SETTLEMENT, 0), {
    ...{ series: "settlement", y_unit: "mm", points: { x: [1, 2], y: [0.1, 0.2], range: [0, 3] }, y_factor: -1 },
    ...{ sort: true, repeated_x: "average", x_from: 0, gross_errors: [2], notes: ["one row without a number"] },
  });
  assert.equal("x_from" in taken(POINTS, { ...state, early: true }, SETTLEMENT), false);
});
