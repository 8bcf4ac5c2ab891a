// What the matrix plot shows: the evaluations under the present weights, threshold and ranges. No drawing here.

import { COLOURS } from "../scales.js";

const BINS = 30;

/** Natural value of a place from 0 to 1 between the bounds of a parameter, and back. */
export function natural({ scale, lower, upper }, unit) {
  return scale === "log" ? lower * (upper / lower) ** unit : lower + unit * (upper - lower);
}
export function place({ scale, lower, upper }, value) {
  return scale === "log" ? Math.log(value / lower) / Math.log(upper / lower) : (value - lower) / (upper - lower);
}

/** The evaluations of a job with what can be done to them in the browser. */
export class Cloud {
  constructor(points) {
    this.points = points;
    this.count = points.count;
    this.parameters = points.parameters;
    this.size = points.parameters.length;
    this.unit = points.parameters.map((parameter, i) =>
      Float32Array.from(points.values[i], (value) => place(parameter, value)),
    );
    this.ownWeights = Object.fromEntries(points.series.map(({ name, weight }) => [name, weight]));
    this.ranges = new Map();
    this.reweight(this.ownWeights);
  }

  /** Take other weights of the series: objectives, order and envelopes follow. */
  reweight(weights) {
    this.weights = { ...weights };
    this.reweighted = Object.keys(weights).some((name) => weights[name] !== this.ownWeights[name]);
    if (this.reweighted) {
      this.objective = new Float32Array(this.count);
      for (const [series, misfits] of Object.entries(this.points.misfits)) {
        const weight = weights[series];
        for (let n = 0; n < this.count; n += 1) this.objective[n] += weight * misfits[n];
      }
    } else this.objective = this.points.objective;
    const objective = this.objective;
    this.order = Uint32Array.from(objective, (_, n) => n).sort((a, b) => objective[a] - objective[b]);
    this.envelopes = this.unit.map((unit) => {
      const lowest = new Float64Array(BINS).fill(Infinity);
      for (let n = 0; n < this.count; n += 1) {
        const bin = Math.min(BINS - 1, Math.max(0, Math.floor(unit[n] * BINS)));
        if (objective[n] < lowest[bin]) lowest[bin] = objective[n];
      }
      return lowest;
    });
  }

  get best() {
    return this.order[0];
  }

  /** Objective of the evaluation that has a share of all at or below it. */
  quantile(share) {
    return this.objective[this.order[Math.min(this.count - 1, Math.max(0, Math.floor(share * (this.count - 1))))]];
  }

  /** How the objective is drawn over a length: `span` from low to high, and `level(f)`, 0 to 1 inside it. */
  objectiveScale() {
    const low = this.quantile(0),
      high = this.quantile(0.98);
    const logarithmic = low > 0 && high / low > 3;
    const [first, last] = logarithmic ? [low / 1.4, high] : [Math.min(0, low), high > low ? high : low + 1];
    const level = (f) => (logarithmic ? Math.log(f / first) / Math.log(last / first) : (f - first) / (last - first));
    return { span: [first, last], logarithmic, level };
  }

  /** Colour of a good fit, from the best one to the threshold. */
  colours(threshold) {
    const low = this.quantile(0);
    const log = low > 0 && threshold / low > 3;
    return (n) => {
      const f = this.objective[n];
      const share = log ? Math.log(f / low) / Math.log(threshold / low) : (f - low) / (threshold - low || 1);
      return COLOURS[Math.max(0, Math.min(COLOURS.length - 1, Math.floor(share * COLOURS.length)))];
    };
  }

  /** How many evaluations are good fits, at or below a threshold. */
  kept(threshold) {
    const limit = Math.fround(threshold); // objectives are rounded in the same way: the one that sets it is kept
    let low = 0,
      high = this.count;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.objective[this.order[middle]] <= limit) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /** Keep only evaluations with a parameter between two places (0 to 1); null takes the limit away. */
  limit(index, range) {
    if (range) this.ranges.set(index, range);
    else this.ranges.delete(index);
  }

  /** Good fits inside all ranges, best first. */
  chosen(threshold) {
    const good = this.order.subarray(0, this.kept(threshold));
    if (!this.ranges.size) return good;
    const limits = [...this.ranges].map(([index, [low, high]]) => [this.unit[index], low, high]);
    return good.filter((n) => limits.every(([unit, low, high]) => unit[n] >= low && unit[n] <= high));
  }

  /** All evaluations inside all ranges, good or not, best first. */
  inside() {
    return this.chosen(Infinity);
  }

  /** Pearson's correlation of two parameters over some evaluations; null where it is not defined. */
  correlation(first, second, chosen) {
    const [x, y] = [this.values(first), this.values(second)];
    const count = chosen.length;
    if (count < 3) return null;
    let mx = 0,
      my = 0;
    for (const n of chosen) {
      mx += x[n];
      my += y[n];
    }
    mx /= count;
    my /= count;
    let xx = 0,
      yy = 0,
      xy = 0;
    for (const n of chosen) {
      const a = x[n] - mx,
        b = y[n] - my;
      xx += a * a;
      yy += b * b;
      xy += a * b;
    }
    return xx > 0 && yy > 0 ? Math.max(-1, Math.min(1, xy / Math.sqrt(xx * yy))) : null;
  }

  values(index) {
    return this.points.values[index];
  }

  /** Share of each series in the objective of an evaluation. */
  shares(n) {
    const parts = Object.entries(this.points.misfits).map(([series, misfits]) => [
      series,
      this.weights[series] * misfits[n],
    ]);
    const total = parts.reduce((sum, [, part]) => sum + part, 0);
    return Object.fromEntries(parts.map(([series, part]) => [series, total > 0 ? part / total : NaN]));
  }
}
