import assert from "node:assert/strict";
import { test } from "node:test";

import { thinned, tickText, ticks } from "../../api/static/js/scales.js";

test("ticks are round and within the limits", () => {
  assert.deepEqual(ticks(0, 1, "linear"), [0, 0.5, 1]);
  assert.deepEqual(ticks(0.05, 0.11, "linear"), [0.06, 0.08, 0.1]);
  assert.deepEqual(ticks(1e-4, 1e2, "log").map(tickText), ["10⁻⁴", "0.01", "1", "100"]);
  assert.deepEqual(ticks(2, 7, "log"), [2, 5]);
});

test("ticks are short text", () => {
  assert.deepEqual([0, 25, 0.05, 1e-3, 2.5e6].map(tickText), ["0", "25", "0.05", "10⁻³", "2.5·10⁶"]);
});

test("thinned items keep the first, the last and what matters", () => {
  const items = Array.from({ length: 101 }, (_, i) => i);
  const kept = thinned(items, 11, (item) => item === 55);
  assert.deepEqual(kept, [0, 10, 20, 30, 40, 50, 55, 60, 70, 80, 90, 100]);
  assert.deepEqual(thinned([1, 2], 5), [1, 2]);
});
