// Six-node triangles: their straight pieces, their outline, and filled contours.

/** Four triangles of three nodes, as places in the list of six, that make up one of six. */
export const PIECES = [
  [0, 3, 5],
  [3, 1, 4],
  [5, 4, 2],
  [3, 4, 5],
];
const SIDES = [
  [0, 3, 1],
  [1, 4, 2],
  [2, 5, 0],
];

/** Sides that belong to one triangle only: [start, mid, end]. */
export function outline(triangles) {
  const sides = new Map();
  for (const triangle of triangles) {
    for (const [a, m, b] of SIDES) {
      const key = triangle[m];
      if (sides.has(key)) sides.delete(key);
      else sides.set(key, [triangle[a], triangle[m], triangle[b]]);
    }
  }
  return [...sides.values()];
}

/** Round levels between two values, at most this number. */
export function levels(low, high, most = 10) {
  const rough = (high - low) / most;
  if (!(rough > 0)) return [low, low + 1];
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((digit) => digit * power).find((one) => one >= rough * 0.999);
  const first = Math.floor(low / step + 1e-9),
    last = Math.ceil(high / step - 1e-9);
  return Array.from({ length: Math.max(2, last - first + 1) }, (_, i) => Number(((first + i) * step).toPrecision(8)));
}

/**
 * The part of a polygon where a linear quantity lies between two values.
 * `corners`: [x, y, value] each; returns the same, fewer than three where nothing is left.
 */
export function between(corners, low, high) {
  return clipped(
    clipped(corners, (value) => value - low),
    (value) => high - value,
  );
}

function clipped(corners, excess) {
  const kept = [];
  for (let i = 0; i < corners.length; i += 1) {
    const here = corners[i],
      next = corners[(i + 1) % corners.length];
    const a = excess(here[2]),
      b = excess(next[2]);
    if (a >= 0) kept.push(here);
    if (a < 0 !== b < 0) {
      const share = a / (a - b);
      kept.push(here.map((value, k) => value + share * (next[k] - value)));
    }
  }
  return kept;
}

/** Smallest box around places: [left, bottom, right, top]. */
export function box(places) {
  const found = [Infinity, Infinity, -Infinity, -Infinity];
  for (const [x, y] of places) {
    if (x < found[0]) found[0] = x;
    if (y < found[1]) found[1] = y;
    if (x > found[2]) found[2] = x;
    if (y > found[3]) found[3] = y;
  }
  return found;
}

/** The smallest height of a triangle. */
export function thickness(a, b, c) {
  const side = ([x, y], [u, v]) => Math.hypot(x - u, y - v);
  const twice = Math.abs((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]));
  return twice / Math.max(side(a, b), side(b, c), side(c, a));
}

/** The largest round number (1, 2 or 5 times a power of ten) that is not above a value. */
export function roundDown(value) {
  const power = 10 ** Math.floor(Math.log10(Math.max(value, 1e-300)));
  return power * [5, 2, 1].find((step) => step * power <= value * (1 + 1e-9));
}

/**
 * The largest factor up to which displacements turn no piece of a triangle inside out; Infinity where none ever does.
 * The area of a piece is a + b s + c s² at a factor s.
 */
export function largestFactor(nodes, displacement, triangles) {
  let least = Infinity;
  for (const triangle of triangles) {
    for (const piece of PIECES) {
      const [p, q, r] = piece.map((k) => nodes[triangle[k]]),
        [u, v, w] = piece.map((k) => displacement[triangle[k]]);
      const [ex, ey, fx, fy] = [q[0] - p[0], q[1] - p[1], r[0] - p[0], r[1] - p[1]];
      const [gx, gy, hx, hy] = [v[0] - u[0], v[1] - u[1], w[0] - u[0], w[1] - u[1]];
      const a = ex * fy - ey * fx,
        b = ex * hy + gx * fy - ey * hx - gy * fx,
        c = gx * hy - gy * hx;
      least = Math.min(least, firstRoot(a, b, c));
    }
  }
  return least;
}

/** The smallest positive root of a + b s + c s²; Infinity without one. */
function firstRoot(a, b, c) {
  if (a === 0) return Infinity;
  const inside = b * b - 4 * a * c;
  if (inside < 0) return Infinity;
  const half = -0.5 * (b + Math.sign(b || 1) * Math.sqrt(inside));
  return Math.min(...[half === 0 ? NaN : a / half, c === 0 ? NaN : half / c].filter((root) => root > 0));
}
