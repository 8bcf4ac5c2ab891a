import assert from "node:assert/strict";
import { test } from "node:test";

import {
  age,
  amount,
  coefficient,
  count,
  duration,
  ends,
  number,
  objectiveUnit,
  partOf,
  percent,
  precise,
  symbol,
  typeset,
} from "../../api/static/js/format.js";

test("numbers have significant digits, in powers of ten only where these are shorter", () => {
  assert.deepEqual(
    [0, 0.0123456, 123456.7, 1234567, -2.5e-7, null, NaN].map((one) => number(one)),
    ["0", "0.01235", "123500", "1.235·10⁶", "-2.5·10⁻⁷", "–", "–"],
  );
});

test("sentences of the service have the letters and the powers of ten of the page", () => {
  assert.equal(
    typeset(
      "Widen the upper bound of soil.lambda_star to 1.45e-08 (objective 4.9e-9, not 1e-3): nu_ur of stage2e1 stays.",
    ),
    "Widen the upper bound of soil.λ* to 1.45·10⁻⁸ (objective 4.9·10⁻⁹, not 10⁻³): ν_ur of stage2e1 stays.",
  );
  assert.equal(
    typeset("the series philosophy and my_lambda_star, phi_s"),
    "the series philosophy and my_lambda_star, phi_s",
  );
  assert.equal(typeset("its 95 % interval"), "its 95\u00a0% interval");
});

test("ends of an interval differ in their last digits, however narrow it is", () => {
  assert.equal(ends(2.34812, 2.35191), "2.3481 … 2.3519");
  assert.equal(ends(1, 1), "1 … 1");
  assert.equal(ends(0.08, 0.12), "0.08 … 0.12");
});

test("a value has the digits that its interval leaves it", () => {
  assert.equal(precise(0.0825413, 0.002), "0.0825");
  assert.equal(precise(0.0825413, 0.2), "0.083");
  assert.equal(precise(0.0825413, 0), "0.08254");
});

test("a coefficient is never minus zero", () => {
  assert.deepEqual([-0.001, 0.994, -0.006].map(coefficient), ["0.00", "0.99", "-0.01"]);
});

test("large numbers are grouped, shares are per cent", () => {
  assert.equal(count(20000), "20\u202f000");
  assert.equal(count(undefined), "–");
  assert.equal(percent(0.256), "26 %");
  assert.equal(percent(NaN), "–");
});

test("durations have two units at most", () => {
  const seconds = [0.012, 0.8, 42, 185, 7800, 273600, null];
  assert.deepEqual(seconds.map(duration), ["12 ms", "0.8 s", "42 s", "3 min 5 s", "2 h 10 min", "3 d 4 h", "–"]);
});

test("ages are rounded, so that they do not change each second", () => {
  const now = Date.parse("2026-01-01T12:00:00Z");
  assert.equal(age("2026-01-01T11:59:55Z", now), "just now");
  assert.equal(age("2026-01-01T11:59:23Z", now), "30 s ago");
  assert.equal(age("2026-01-01T11:56:55Z", now), "3 min ago");
});

test("units of one are left out", () => {
  assert.equal(amount(0.00512, "m"), "0.00512 m");
  assert.equal(amount(0.3, "dimensionless"), "0.3");
  assert.equal(objectiveUnit([{ y_unit: "m" }, { y_unit: "m" }]), "m²");
  assert.equal(objectiveUnit([{ y_unit: "m" }, { y_unit: "kPa" }]), "");
});

test("a parameter of a part keeps the part and has the letter of the field", () => {
  assert.equal(symbol("clay.lambda_star"), "clay.λ*");
  assert.equal(symbol("k0"), "k0");
  assert.equal(partOf("first.settlement"), "first");
  assert.equal(partOf("settlement"), "");
});
