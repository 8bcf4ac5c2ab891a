import assert from "node:assert/strict";
import { test } from "node:test";

import { unitsOf, valueWithUnit } from "../../api/static/js/new/units.js";
import { choices, choose, converted, inUnits } from "../../api/static/js/units.js";

const FIT = {
  series: [
    {
      series: "settlement",
      x_unit: "day",
      y_unit: "m",
      x: [1, 2],
      breaks: [1],
      gross_x: [],
      measured: [0.001, null],
      gross_measured: [],
    },
  ],
  curves: [{ values: { settlement: [0.002, 0.003] }, shares: [{ unit: "m", root_mean_square: 0.0005 }] }],
};

/** Have values stored as a browser does, until the end of a test. */
function stored(context) {
  const values = new Map();
  globalThis.localStorage = {
    getItem: (key) => values.get(key) ?? null,
    setItem: (key, value) => values.set(key, value),
    removeItem: (key) => values.delete(key),
  };
  context.after(() => delete globalThis.localStorage);
}

test("fits are shown in the chosen units, readings that are missing stay so", (context) => {
  stored(context);
  choose("length", "mm");
  choose("time", "h");
  const { series, curves } = converted(FIT);
  assert.deepEqual([series[0].x, series[0].x_unit], [[24, 48], "h"]);
  assert.deepEqual([series[0].measured, series[0].y_unit], [[1, null], "mm"]);
  assert.deepEqual(curves[0].values.settlement, [2, 3]);
  assert.deepEqual(curves[0].shares[0], { unit: "mm", root_mean_square: 0.5 });
});

test("only families that a fit has are offered, with what was chosen", (context) => {
  stored(context);
  choose("length", "cm");
  assert.deepEqual(
    choices(FIT).map(({ family, chosen }) => [family, chosen]),
    [
      ["length", "cm"],
      ["time", null],
    ],
  );
  choose("length", null);
  assert.deepEqual(converted(FIT), FIT);
});

test("without storage the units are those of the data", () => {
  assert.deepEqual(converted(FIT), FIT);
});

test("a field takes a value with its unit, where that has the dimension and can be read in one way", () => {
  assert.equal(valueWithUnit("20 mm", "m"), 0.02);
  assert.equal(valueWithUnit("2,5 MPa", "kPa"), 2500);
  assert.equal(valueWithUnit("1e-9 m/s", "m/day"), 8.64e-5);
  assert.equal(valueWithUnit("18 kN/m³", "kN/m^3"), 18);
  assert.equal(valueWithUnit("5 %", "dimensionless"), 0.05);
  assert.deepEqual(
    ["20 mm", "1,250 mm", "20", "20 furlongs"].map((text) => valueWithUnit(text, text === "20 mm" ? "kPa" : "m")),
    [null, null, null, null],
  );
});

test("units that suit a base unit are offered", () => {
  assert.ok(unitsOf("m").includes("mm"));
  assert.deepEqual(unitsOf("-"), ["dimensionless", "%"]);
  assert.deepEqual(unitsOf("kN"), ["kN"]);
});

test("a fit is shown in the units of another job's, and not in those of another quantity", () => {
  const { series, curves } = inUnits(FIT, { series: "settlement", x_unit: "min", y_unit: "mm" });
  assert.deepEqual([series[0].x, series[0].breaks, series[0].x_unit], [[1440, 2880], [1440], "min"]);
  assert.deepEqual([series[0].measured, series[0].y_unit], [[1, null], "mm"]);
  assert.deepEqual(curves[0].values, { settlement: [2, 3] });
  assert.equal(inUnits(FIT, { series: "settlement", x_unit: "day", y_unit: "kPa" }), null);
  assert.equal(inUnits(FIT, { series: "q", x_unit: "day", y_unit: "m" }), null);
});
