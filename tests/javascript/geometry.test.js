import assert from "node:assert/strict";
import { test } from "node:test";

import {
  between,
  box,
  largestFactor,
  levels,
  outline,
  roundDown,
  thickness,
} from "../../api/static/js/mesh/geometry.js";

const MIDDLES = (a, b, c) =>
  [a, b, c].map(([x, y], i, all) => [(x + all[(i + 1) % 3][0]) / 2, (y + all[(i + 1) % 3][1]) / 2]);
const TRIANGLE = [
  [0, 0],
  [1, 0],
  [0, 1],
];
const NODES = [...TRIANGLE, ...MIDDLES(...TRIANGLE)];

test("a side of two triangles is inside, the others are the outline", () => {
  const sides = outline([
    [0, 1, 2, 4, 5, 6],
    [1, 3, 2, 7, 8, 5],
  ]);
  assert.deepEqual(sides.map(([, middle]) => middle).sort(), [4, 6, 7, 8]);
});

test("levels are round and take in both values", () => {
  assert.deepEqual(levels(0.1, 0.9, 4), [0, 0.2, 0.4, 0.6, 0.8, 1]);
  assert.deepEqual(levels(3, 3), [3, 4]);
});

test("a polygon is cut where its quantity leaves two values", () => {
  const kept = between(
    [
      [0, 0, 0],
      [1, 0, 1],
      [1, 1, 1],
      [0, 1, 0],
    ],
    0.25,
    0.5,
  );
  assert.deepEqual(box(kept), [0.25, 0, 0.5, 1]);
  assert.ok(
    between(
      [
        [0, 0, 0],
        [1, 0, 0],
        [0, 1, 0],
      ],
      1,
      2,
    ).length < 3,
  );
});

test("displacements are magnified until the first piece is inside out", () => {
  const still = NODES.map(() => [0, 0]);
  assert.equal(largestFactor(NODES, still, [[0, 1, 2, 3, 4, 5]]), Infinity);
  const squeezed = NODES.map(([x]) => [-0.01 * x, 0]);
  assert.ok(Math.abs(largestFactor(NODES, squeezed, [[0, 1, 2, 3, 4, 5]]) - 100) < 1e-9);
});

test("factors are rounded down", () => {
  assert.deepEqual([99, 100, 499, 0.3].map(roundDown), [50, 100, 200, 0.2]);
});

test("a triangle is as thick as its smallest height", () => {
  assert.equal(thickness([0, 0], [4, 0], [0, 3]), 2.4);
  assert.equal(thickness([0, 0], [40, 0], [20, 2]), 2);
  assert.equal(thickness([0, 0], [1, 1], [2, 2]), 0);
});
