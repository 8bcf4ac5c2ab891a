// The slider of the threshold: how good a fit must be to count.
import { element } from "../dom.js";
import { count, number } from "../format.js";

const STEPS = 1000;

/** Fills `holder`; `onInput(threshold)` while it moves, `onRest(threshold)` a moment after it has stopped. */
export class ThresholdSlider {
  constructor(holder, { onInput, onRest, onProposed }) {
    this.onInput = onInput;
    this.onRest = onRest;
    this.slider = element("input", {
      type: "range",
      id: "threshold",
      min: 0,
      max: STEPS,
      step: 1,
      "aria-describedby": "threshold-why",
    });
    this.exact = element("input", { type: "number", min: 0, step: "any", "aria-label": "Threshold as a number" });
    this.told = element("output", { for: "threshold" });
    this.why = element("p", { class: "help", id: "threshold-why" });
    this.proposed = element(
      "button",
      { type: "button", class: "quiet small", onclick: onProposed },
      "Proposed threshold",
    );
    holder.replaceChildren(
      element("label", { for: "threshold" }, "Good fits up to f ="),
      this.slider,
      this.exact,
      this.proposed,
      this.told,
      this.why,
    );
    this.slider.addEventListener("input", () => this.moved(this.fromSlider()));
    this.exact.addEventListener("change", () => {
      if (Number(this.exact.value) > 0) this.moved(Number(this.exact.value));
    });
  }

  /** Limits of the slider after the cloud. */
  fit(cloud, unit) {
    this.cloud = cloud;
    this.unit = unit;
    const low = cloud.quantile(0),
      high = cloud.quantile(1);
    this.log = low > 0 && high / low > 3;
    this.low = this.log ? low : Math.min(0, low);
    this.high = Math.max(high, this.log ? low * 3 : low + 1e-300);
  }

  fromSlider() {
    const share = Number(this.slider.value) / STEPS;
    return this.log
      ? this.low * (this.high / this.low) ** share * (1 + 1e-6)
      : this.low + share * (this.high - this.low);
  }

  moved(threshold) {
    this.set(threshold);
    this.onInput(threshold);
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.onRest(threshold), 300);
  }

  /** Show a threshold. */
  set(threshold) {
    const share = this.log
      ? Math.log(threshold / this.low) / Math.log(this.high / this.low)
      : (threshold - this.low) / (this.high - this.low);
    this.slider.value = String(Math.round(STEPS * Math.max(0, Math.min(1, share))));
    this.slider.setAttribute("aria-valuetext", `${number(threshold, 3)} ${this.unit}`);
    if (document.activeElement !== this.exact) this.exact.value = String(Number(threshold.toPrecision(4)));
  }

  /** Say how many are chosen. */
  tell(chosen, kept) {
    const { cloud } = this;
    const left = cloud.points.left_out;
    const limited = cloud.ranges.size ? `; ${count(chosen)} inside the ranges` : "";
    this.told.textContent = `${count(kept)} of ${count(cloud.count)} evaluations${limited}${left ? ` (${count(left)} more are left out of the statistics)` : ""}`;
  }
}
