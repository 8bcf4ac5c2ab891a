// The matrix plot: below the diagonal scatter plots of two parameters, on it the objective over one, above it correlations.
// Points are painted on two canvases (all evaluations behind, good fits in front), so that the slider paints few of them.
import { element, svg } from "../dom.js";
import { coefficient, withUnit } from "../format.js";
import { colour } from "../plot.js";
import { place } from "./cloud.js";
import { saveButtons } from "./save.js";
import { tickText, ticks } from "../scales.js";

const LEFT = 70,
  TOP = 10,
  BOTTOM = 54,
  RIGHT = 14,
  GAP = 8;
const SMALLEST = 86,
  LARGEST = 190;
const CLICK = 5;

export class Matrix {
  /** `onRanges(ranges)`: somebody has drawn a rectangle or taken one away. */
  constructor(holder, { onRanges }) {
    this.onRanges = onRanges;
    this.back = element("canvas", { "aria-hidden": true });
    this.front = element("canvas", { "aria-hidden": true });
    this.marks = svg("svg", { role: "img", class: "marks" });
    this.stage = element("div", { class: "stage" }, this.back, this.front, this.marks);
    this.frame = element(
      "div",
      { class: "wide matrix", tabindex: "0", role: "region", "aria-label": "Matrix plot" },
      this.stage,
    );
    holder.replaceChildren(this.frame, saveButtons(this, "matrix-plot"));
    this.marks.addEventListener("pointerdown", (event) => this.begin(event));
    new ResizeObserver(() => this.resized()).observe(this.frame);
    document.addEventListener("themechange", () => this.cloud && this.paint());
  }

  /** Show other data; returns the chosen evaluations. */
  show(cloud, threshold, unit) {
    Object.assign(this, { cloud, threshold, objectiveUnit: unit });
    this.measure();
    return this.paint();
  }

  resized() {
    if (!this.cloud || this.frame.clientWidth === this.width) return;
    this.measure();
    this.paint();
  }

  measure() {
    const size = this.cloud.size;
    this.width = this.frame.clientWidth;
    const room = (this.width - LEFT - RIGHT - GAP * (size - 1)) / size;
    this.cell = Math.floor(Math.max(SMALLEST, Math.min(LARGEST, room)));
    const side = size * this.cell + (size - 1) * GAP;
    const [width, height] = [LEFT + side + RIGHT, TOP + side + BOTTOM];
    this.ratio = Math.min(2, devicePixelRatio || 1);
    for (const canvas of [this.back, this.front]) {
      [canvas.width, canvas.height] = [width * this.ratio, height * this.ratio];
      canvas.style.width = `${width}px`;
      canvas.style.height = `${height}px`;
    }
    this.stage.style.width = `${width}px`;
    this.stage.style.height = `${height}px`;
    this.marks.setAttribute("viewBox", `0 0 ${width} ${height}`);
    this.marks.setAttribute("width", width);
    this.marks.setAttribute("height", height);
  }

  /** Redraw everything: other data, size or colours. */
  paint() {
    const { cloud } = this;
    this.colours = {
      faint: colour("--muted"),
      best: colour("--series-2"),
      line: colour("--series-2"),
      grid: colour("--line"),
    };
    this.scale = cloud.objectiveScale();
    this.points(this.back, cloud.order, () => this.colours.faint, {
      size: cloud.count < 5000 ? 1.6 : 1,
      alpha: cloud.count < 5000 ? 0.4 : 0.25,
    });
    return this.update(this.threshold);
  }

  /** Another threshold or other ranges: only the good fits are painted. */
  update(threshold) {
    this.threshold = threshold;
    const { cloud } = this;
    const chosen = cloud.chosen(threshold);
    const size = chosen.length < 300 ? 3.6 : chosen.length < 3000 ? 2.6 : 1.8;
    this.points(this.front, chosen, cloud.colours(threshold), { size, alpha: 1, backwards: true });
    this.annotate(chosen);
    return chosen;
  }

  /** Paint some evaluations into all cells; runs of one colour are cheap, and `order` is sorted by the objective. */
  points(canvas, order, paintOf, { size, alpha, backwards = false }) {
    const context = canvas.getContext("2d");
    const { cloud, cell, ratio } = this;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, canvas.width, canvas.height);
    context.globalAlpha = alpha;
    const sequence = backwards ? order.slice().reverse() : order; // the best on top
    const paints = Array.from(sequence, paintOf);
    const half = size / 2;
    for (let row = 0; row < cloud.size; row += 1) {
      for (let column = 0; column <= row; column += 1) {
        const [left, top] = this.corner(row, column);
        const x = cloud.unit[column],
          y = row === column ? null : cloud.unit[row];
        let last = null;
        for (let k = 0; k < sequence.length; k += 1) {
          const n = sequence[k];
          const height = y === null ? this.scale.level(cloud.objective[n]) : y[n];
          if (!(height >= 0 && height <= 1)) continue;
          if (paints[k] !== last) context.fillStyle = last = paints[k];
          context.fillRect(left + x[n] * cell - half, top + (1 - height) * cell - half, size, size);
        }
      }
    }
    context.globalAlpha = 1;
  }

  corner(row, column) {
    return [LEFT + column * (this.cell + GAP), TOP + row * (this.cell + GAP)];
  }

  annotate(chosen) {
    const { cloud, cell } = this;
    const parts = [];
    for (let row = 0; row < cloud.size; row += 1) {
      for (let column = 0; column < cloud.size; column += 1) {
        const [x, y] = this.corner(row, column);
        parts.push(svg("rect", { class: row < column ? "cell upper" : "cell", x, y, width: cell, height: cell }));
        if (row < column) parts.push(...this.correlation(row, column, chosen, x, y));
        else if (row === column) parts.push(...this.projection(row, x, y));
        else parts.push(...this.cross(row, column, x, y));
        if (row >= column) parts.push(...this.brushed(row, column, x, y));
      }
    }
    this.marks.replaceChildren(...parts, ...this.axes());
    this.marks.setAttribute(
      "aria-label",
      `Matrix plot of ${cloud.size} parameters: ${chosen.length} of ${cloud.count} evaluations are chosen; correlations and verdicts are listed as text as well.`,
    );
  }

  correlation(row, column, chosen, x, y) {
    const { cloud, cell } = this;
    const r = cloud.correlation(row, column, chosen);
    const strong = r !== null && Math.abs(r) >= 0.5;
    const middle = x + cell / 2;
    return [
      svg("rect", {
        class: "strength",
        x,
        y,
        width: cell,
        height: cell,
        style: { opacity: r === null ? 0 : 0.45 * r * r },
      }),
      svg(
        "text",
        { x: middle, y: y + cell / 2, class: strong ? "r strong" : "r", "text-anchor": "middle" },
        r === null ? "r = ?" : `r = ${coefficient(r).replace("-", "−")}`,
      ),
      svg("text", { x: middle, y: y + cell / 2 + 16, "text-anchor": "middle" }, `n = ${chosen.length}`),
    ];
  }

  projection(index, x, y) {
    const { cloud, cell } = this;
    const envelope = cloud.envelopes[index];
    const wide = cell / envelope.length;
    let path = "";
    envelope.forEach((f, bin) => {
      const height = Number.isFinite(f) ? this.scale.level(f) : NaN;
      if (!(height <= 1)) return;
      const top = y + (1 - Math.max(0, height)) * cell;
      const joined = path && Number.isFinite(envelope[bin - 1]) && this.scale.level(envelope[bin - 1]) <= 1;
      path += `${joined ? "L" : "M"}${x + bin * wide} ${top}h${wide}`;
    });
    const limit = this.scale.level(this.threshold);
    const line =
      limit >= 0 && limit <= 1
        ? [svg("line", { class: "limit", x1: x, x2: x + cell, y1: y + (1 - limit) * cell, y2: y + (1 - limit) * cell })]
        : [];
    return [svg("path", { class: "envelope", d: path }), ...line];
  }

  cross(row, column, x, y) {
    const { cloud, cell } = this;
    const [a, b] = [x + cloud.unit[column][cloud.best] * cell, y + (1 - cloud.unit[row][cloud.best]) * cell];
    return [svg("path", { class: "best-cross", d: `M${a - 6} ${b}h12M${a} ${b - 6}v12` })];
  }

  brushed(row, column, x, y) {
    const { cell } = this;
    const across = this.cloud.ranges.get(column),
      up = row === column ? undefined : this.cloud.ranges.get(row);
    if (!across && !up) return [];
    const [left, right] = across ?? [0, 1],
      [low, high] = up ?? [0, 1];
    return [
      svg("rect", {
        class: "brush",
        x: x + left * cell,
        y: y + (1 - high) * cell,
        width: (right - left) * cell,
        height: (high - low) * cell,
      }),
    ];
  }

  axes() {
    const { cloud, cell } = this;
    const last = cloud.size - 1,
      parts = [];
    const most = cell > 130 ? 4 : 2;
    const label = ({ symbol, unit }) => withUnit(symbol, unit);
    const edge = (share) => (share < 0.15 ? "start" : share > 0.85 ? "end" : "middle");
    cloud.parameters.forEach((parameter, index) => {
      const [x] = this.corner(last, index),
        [, y] = this.corner(index, 0);
      const bottom = this.corner(last, 0)[1] + cell;
      for (const value of ticks(parameter.lower, parameter.upper, parameter.scale, most)) {
        const share = place(parameter, value);
        const at = x + share * cell;
        parts.push(
          svg("path", { class: "tick", d: `M${at} ${bottom}v4` }),
          svg("text", { x: at, y: bottom + 16, "text-anchor": edge(share) }, tickText(value)),
        );
        if (index > 0) {
          const height = y + (1 - share) * cell;
          const down = share > 0.9 ? 9 : share < 0.1 ? 0 : 4;
          parts.push(
            svg("path", { class: "tick", d: `M${LEFT} ${height}h-4` }),
            svg("text", { x: LEFT - 7, y: height + down, "text-anchor": "end" }, tickText(value)),
          );
        }
      }
      parts.push(
        svg("text", { class: "label", x: x + cell / 2, y: bottom + 36, "text-anchor": "middle" }, label(parameter)),
      );
      if (index > 0) parts.push(sideways(label(parameter), y + cell / 2));
    });
    for (const f of ticks(...this.scale.span, this.scale.logarithmic ? "log" : "linear", most)) {
      const height = TOP + (1 - this.scale.level(f)) * cell;
      parts.push(
        svg("path", { class: "tick", d: `M${LEFT} ${height}h-4` }),
        svg("text", { x: LEFT - 7, y: height + 4, "text-anchor": "end" }, tickText(f)),
      );
    }
    parts.push(sideways(this.objectiveUnit ? `f [${this.objectiveUnit}]` : "f", TOP + cell / 2));
    return parts;
  }

  /** The cell below a point of the screen, and the place in it. */
  find(event) {
    const box = this.marks.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left - LEFT, event.clientY - box.top - TOP];
    const pitch = this.cell + GAP;
    return { column: Math.floor(x / pitch), row: Math.floor(y / pitch), x, y };
  }

  begin(event) {
    if (event.button !== 0) return;
    const { row, column, x: x0, y: y0 } = this.find(event);
    if (!(row >= column && column >= 0 && row < this.cloud.size)) return;
    event.preventDefault();
    this.frame.focus({ preventScroll: true });
    this.marks.setPointerCapture(event.pointerId);
    const pitch = this.cell + GAP;
    const inside = (value, index) => Math.max(0, Math.min(1, (value - index * pitch) / this.cell));
    const drag = (moved) => {
      const { x, y } = this.find(moved);
      if (Math.hypot(x - x0, y - y0) < CLICK) return false;
      const across = [inside(x0, column), inside(x, column)].sort((a, b) => a - b);
      this.cloud.limit(column, across);
      if (row !== column)
        this.cloud.limit(
          row,
          [1 - inside(y0, row), 1 - inside(y, row)].sort((a, b) => a - b),
        );
      this.onRanges();
      return true;
    };
    let dragged = false;
    const move = (moved) => {
      dragged = drag(moved) || dragged;
    };
    const end = () => {
      this.marks.removeEventListener("pointermove", move);
      this.marks.removeEventListener("pointerup", end);
      this.marks.removeEventListener("pointercancel", end);
      if (dragged) return;
      this.cloud.limit(column, null);
      this.cloud.limit(row, null);
      this.onRanges();
    };
    this.marks.addEventListener("pointermove", move);
    this.marks.addEventListener("pointerup", end);
    this.marks.addEventListener("pointercancel", end);
  }
}

function sideways(text, y) {
  return svg("text", { class: "label", transform: `translate(14 ${y}) rotate(-90)`, "text-anchor": "middle" }, text);
}
