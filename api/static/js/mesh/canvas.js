// The canvas of a body: its size, what part is seen (drag, buttons, keys), and which node is pointed at.
import { element } from "../dom.js";
import { paint } from "./drawing.js";
import { box } from "./geometry.js";

const SCALES = 110; // px of the canvas for axes, scales and buttons
const CHROME = 470; // px of the window for what stands above the body: what is shown, its legend, its readings
const MARGIN = 0.06,
  STEP = 1.4,
  MOVE = 60,
  RING = 7;
const WAYS = { ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

export class BodyCanvas {
  /** `onNode(node | null)`: the pointer is at a node. */
  constructor(holder, { onNode }) {
    this.onNode = onNode;
    this.marked = null; // the node that the keyboard has reached
    this.canvas = element("canvas", { role: "img", "aria-label": "Body" });
    const button = (text, name, act) =>
      element("button", { type: "button", class: "quiet", "aria-label": name, title: name, onclick: act }, text);
    const buttons = element(
      "div",
      { class: "zoom" },
      button("+", "Zoom in", () => this.zoom(STEP)),
      button("−", "Zoom out", () => this.zoom(1 / STEP)),
      button("Whole", "The whole body", () => this.whole()),
    );
    this.frame = element(
      "div",
      {
        class: "body",
        tabindex: "0",
        role: "region",
        "aria-label": "Mesh: arrow keys move, + and - zoom, 0 shows all, Shift and arrow keys go from node to node",
      },
      this.canvas,
      buttons,
    );
    holder.append(this.frame);
    this.frame.addEventListener("keydown", (event) => this.key(event));
    this.canvas.addEventListener("pointerdown", (event) => this.drag(event));
    this.canvas.addEventListener("pointermove", (event) => this.point(event));
    this.canvas.addEventListener("pointerleave", () => this.onNode(null));
    this.canvas.addEventListener("wheel", (event) => this.wheel(event), { passive: false });
    new ResizeObserver(() => {
      if (this.view && this.frame.clientWidth !== this.width) this.resize();
    }).observe(this.frame);
    document.addEventListener("themechange", () => this.draw());
  }

  /** Show something else; `anew` resets the visible part. */
  show(view, anew = false) {
    this.view = view;
    if (anew || this.marked >= view.places.length) this.marked = null;
    if (anew || !this.width) this.resize();
    else this.draw();
  }

  resize() {
    const [left, bottom, right, top] = box(this.view.mesh.nodes);
    this.width = this.frame.clientWidth;
    const slim = (top - bottom) / (right - left || 1);
    this.height = Math.round(
      Math.max(240, Math.min(620, innerHeight - CHROME, this.width * (slim + 2 * MARGIN) + SCALES)),
    );
    this.ratio = Math.min(2, devicePixelRatio || 1);
    this.canvas.width = this.width * this.ratio;
    this.canvas.height = this.height * this.ratio;
    this.canvas.style.height = `${this.height}px`;
    this.whole();
  }

  whole() {
    const [left, bottom, right, top] = box(this.view.mesh.nodes);
    this.pixels = Math.min(
      (this.width * (1 - 2 * MARGIN)) / (right - left || 1),
      (this.height - SCALES) / (top - bottom || 1),
    );
    this.centre = [(left + right) / 2, (bottom + top) / 2];
    this.draw();
  }

  zoom(factor) {
    this.pixels *= factor;
    this.draw();
  }

  key(event) {
    const way = WAYS[event.key];
    if (way && event.shiftKey) this.step(...way);
    else if (way) this.move(MOVE * way[0], MOVE * way[1]);
    else if (event.key === "+") this.zoom(STEP);
    else if (event.key === "-") this.zoom(1 / STEP);
    else if (event.key === "0") this.whole();
    else return;
    event.preventDefault();
  }

  /** Go to the next node in a direction, at first to the one in the middle of what is seen. */
  step(across, up) {
    const from = this.marked === null ? this.centre : this.view.places[this.marked];
    let next = this.marked,
      least = Infinity;
    this.view.places.forEach(([x, y], node) => {
      const [ahead, aside] = [
        (x - from[0]) * across + (y - from[1]) * up,
        Math.abs((x - from[0]) * up) + Math.abs((y - from[1]) * across),
      ];
      const distance =
        this.marked === null ? ahead ** 2 + aside ** 2 : ahead > 1e-9 && aside <= ahead ? ahead + 2 * aside : Infinity;
      if (distance < least) [next, least] = [node, distance];
    });
    this.marked = next;
    this.onNode(next);
    this.draw();
  }

  move(x, y) {
    this.centre = [this.centre[0] + x / this.pixels, this.centre[1] + y / this.pixels];
    this.draw();
  }

  wheel(event) {
    if (!event.ctrlKey && !event.metaKey) return; // the page scrolls
    event.preventDefault();
    this.zoom(event.deltaY < 0 ? STEP : 1 / STEP);
  }

  drag(event) {
    this.canvas.setPointerCapture(event.pointerId);
    let last = [event.clientX, event.clientY];
    const move = ({ clientX, clientY }) => {
      this.move(last[0] - clientX, clientY - last[1]);
      last = [clientX, clientY];
    };
    const end = () => {
      this.canvas.removeEventListener("pointermove", move);
      this.canvas.removeEventListener("pointerup", end);
      this.canvas.removeEventListener("pointercancel", end);
    };
    this.canvas.addEventListener("pointermove", move);
    this.canvas.addEventListener("pointerup", end);
    this.canvas.addEventListener("pointercancel", end);
  }

  point(event) {
    if (!this.view || event.buttons) return;
    const frame = this.canvas.getBoundingClientRect();
    const [x, y] = [event.clientX - frame.left, event.clientY - frame.top];
    let nearest = null,
      least = 15 ** 2;
    this.view.places.forEach((place, node) => {
      const [a, b] = this.map(place);
      const distance = (a - x) ** 2 + (b - y) ** 2;
      if (distance < least) [nearest, least] = [node, distance];
    });
    this.onNode(nearest);
  }

  map([x, y]) {
    return [this.width / 2 + (x - this.centre[0]) * this.pixels, this.height / 2 - (y - this.centre[1]) * this.pixels];
  }

  draw() {
    if (!this.view || !this.width) return; // nothing to draw, or no room yet
    const context = this.canvas.getContext("2d");
    context.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    paint(context, this.view, (place) => this.map(place), [this.width, this.height]);
    if (this.marked !== null) {
      const [x, y] = this.map(this.view.places[this.marked]);
      context.beginPath();
      context.arc(x, y, RING, 0, 2 * Math.PI);
      context.lineWidth = 3;
      context.strokeStyle = getComputedStyle(this.frame).color;
      context.stroke();
    }
    this.canvas.setAttribute("aria-label", this.view.label);
  }
}
