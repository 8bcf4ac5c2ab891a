// Parallel coordinates: each evaluation a line from its objective through its parameters, whose axes can be brushed.
// All evaluations are painted on one canvas, good fits inside the ranges on another one before it.
import { element, svg } from "../dom.js";
import { withUnit } from "../format.js";
import { colour } from "../plot.js";
import { tickText, thinned, ticks } from "../scales.js";
import { place } from "./cloud.js";
import { saveButtons } from "./save.js";

const [LEFT, RIGHT, TOP, HEIGHT, BOTTOM] = [64, 56, 30, 220, 14];
const PITCH = 84; // least distance of two axes
const REACH = 14; // a pointer this near to an axis is at it
const CLICK = 4;
const MOST = 3000; // lines of a canvas: more take longer than a frame, and only fill it

export class Parallel {
  /** `onRanges()`: somebody has limited a parameter, or taken the limit away. */
  constructor(holder, { onRanges }) {
    this.onRanges = onRanges;
    this.back = element("canvas", { "aria-hidden": true });
    this.front = element("canvas", { "aria-hidden": true });
    this.marks = svg("svg", { role: "img", class: "marks" });
    this.frame = element(
      "div",
      { class: "wide", tabindex: "0", role: "region", "aria-label": "Parallel coordinates" },
      (this.stage = element("div", { class: "stage" }, this.back, this.front, this.marks)),
    );
    holder.replaceChildren(this.frame, saveButtons(this, "parallel-coordinates"));
    this.marks.addEventListener("pointerdown", (event) => this.begin(event));
    new ResizeObserver(() => this.cloud && this.frame.clientWidth !== this.width && this.paint()).observe(this.frame);
    document.addEventListener("themechange", () => this.cloud && this.paint());
  }

  /** Show other data; `chosen`: the good fits inside the ranges, best first. */
  show(cloud, threshold, chosen, unit) {
    Object.assign(this, { cloud, threshold, chosen, objectiveUnit: unit });
    this.paint();
  }

  /** Other good fits. */
  update(threshold, chosen) {
    Object.assign(this, { threshold, chosen });
    const paint = this.cloud.colours(threshold);
    const lines = thinned(chosen, MOST).slice().reverse(); // the best on top; few of them are a view of the cloud
    this.lines(this.front, lines, paint, chosen.length < 300 ? 1.4 : 0.8, chosen.length < 300 ? 0.9 : 0.5);
    this.annotate();
  }

  paint() {
    const { cloud } = this;
    this.width = this.frame.clientWidth;
    const across = Math.max(this.width, LEFT + RIGHT + PITCH * cloud.size);
    this.pitch = (across - LEFT - RIGHT) / cloud.size;
    const ratio = Math.min(2, devicePixelRatio || 1);
    const down = TOP + HEIGHT + BOTTOM;
    for (const canvas of [this.back, this.front]) {
      [canvas.width, canvas.height] = [across * ratio, down * ratio];
      canvas.getContext("2d").setTransform(ratio, 0, 0, ratio, 0, 0);
    }
    for (const layer of [this.back, this.front, this.stage])
      Object.assign(layer.style, { width: `${across}px`, height: `${down}px` });
    for (const [name, value] of [
      ["viewBox", `0 0 ${across} ${down}`],
      ["width", across],
      ["height", down],
    ])
      this.marks.setAttribute(name, value);
    this.scale = cloud.objectiveScale();
    this.lines(this.back, thinned(cloud.order, MOST), () => colour("--muted"), 0.6, 0.18);
    this.update(this.threshold, this.chosen);
  }

  /** Each evaluation a line; neighbours of one colour are one path. */
  lines(canvas, order, paintOf, width, alpha) {
    const context = canvas.getContext("2d");
    context.clearRect(0, 0, canvas.width, canvas.height);
    Object.assign(context, { globalAlpha: alpha, lineWidth: width, lineJoin: "round" });
    let last = null;
    const end = () => last && context.stroke();
    for (const n of order) {
      const paint = paintOf(n);
      if (paint !== last) {
        end();
        context.beginPath();
        context.strokeStyle = last = paint;
      }
      context.moveTo(this.x(0), this.y(Math.min(1, Math.max(0, this.scale.level(this.cloud.objective[n])))));
      this.cloud.unit.forEach((unit, i) => context.lineTo(this.x(i + 1), this.y(unit[n])));
    }
    end();
  }

  x(axis) {
    return LEFT + axis * this.pitch;
  }

  y(share) {
    return TOP + (1 - share) * HEIGHT;
  }

  annotate() {
    const { cloud, scale, chosen } = this;
    const objective = { label: withUnit("f", this.objectiveUnit), level: scale.level };
    const parameters = cloud.parameters.map((one) => ({
      label: withUnit(one.symbol, one.unit),
      level: (value) => place(one, value),
      marks: ticks(one.lower, one.upper, one.scale, 4),
    }));
    const axes = [
      { ...objective, marks: ticks(...scale.span, scale.logarithmic ? "log" : "linear", 4) },
      ...parameters,
    ];
    const parts = axes.flatMap(({ label, level, marks }, i) => [
      svg("path", { class: "cell", d: `M${this.x(i)} ${TOP}v${HEIGHT}` }),
      svg("text", { class: "label", x: this.x(i), y: TOP - 14, "text-anchor": "middle" }, label),
      ...marks.flatMap((value) => [
        svg("path", { class: "tick", d: `M${this.x(i)} ${this.y(level(value))}h-4` }),
        svg("text", { x: this.x(i) - 6, y: this.y(level(value)) + 4, "text-anchor": "end" }, tickText(value)),
      ]),
    ]);
    const limit = scale.level(this.threshold);
    if (limit >= 0 && limit <= 1)
      parts.push(svg("path", { class: "limit", d: `M${this.x(0) - 10} ${this.y(limit)}h20` }));
    for (const [index, [low, high]] of cloud.ranges) {
      const [x, y, height] = [this.x(index + 1) - 9, this.y(high), (high - low) * HEIGHT];
      parts.push(svg("rect", { class: "brush", x, y, width: 18, height }));
    }
    this.marks.replaceChildren(...parts);
    this.marks.setAttribute(
      "aria-label",
      `Parallel coordinates of ${cloud.size} parameters: ${chosen.length} of ${cloud.count} evaluations are chosen.`,
    );
  }

  /** Draw along an axis to keep a part of it; a click takes the limit away. */
  begin(event) {
    const box = this.marks.getBoundingClientRect();
    const index = Math.round((event.clientX - box.left - LEFT) / this.pitch) - 1;
    if (event.button !== 0 || index < 0 || index >= this.cloud.size) return;
    if (Math.abs(event.clientX - box.left - this.x(index + 1)) > REACH) return;
    event.preventDefault();
    this.frame.focus({ preventScroll: true });
    this.marks.setPointerCapture(event.pointerId);
    const share = ({ clientY }) => Math.max(0, Math.min(1, 1 - (clientY - box.top - TOP) / HEIGHT));
    let dragged = false;
    const move = (moved) => {
      if (!dragged && Math.abs(moved.clientY - event.clientY) < CLICK) return;
      dragged = true;
      this.cloud.limit(
        index,
        [share(event), share(moved)].sort((a, b) => a - b),
      );
      this.onRanges();
    };
    const end = () => {
      this.marks.removeEventListener("pointermove", move);
      for (const name of ["pointerup", "pointercancel"]) this.marks.removeEventListener(name, end);
      if (dragged) return;
      this.cloud.limit(index, null);
      this.onRanges();
    };
    this.marks.addEventListener("pointermove", move);
    for (const name of ["pointerup", "pointercancel"]) this.marks.addEventListener(name, end);
  }
}
