// Other weights of the series: the optimum and the clouds move at once, without a forward run.
import { announce, element, once } from "../dom.js";
import { number, percent, symbol, typeset } from "../format.js";
import { post } from "../http.js";

const DECADES = 2;
const SCHEMES = [
  ["by_error", "By error"],
  ["by_count", "By count"],
  ["by_range", "By range"],
  ["by_test", "By test"],
];

export class Weights {
  /** `onWeights(weights)` while a slider moves. */
  constructor(holder, { job, cloud, maySubmit, onWeights }) {
    Object.assign(this, { job, cloud, maySubmit, onWeights });
    this.own = cloud.ownWeights;
    this.message = element("p", { class: "help", role: "status" });
    this.warnings = element("ul", { class: "notes" });
    this.moved = element("p");
    if (cloud.points.series.length < 2) {
      holder.replaceChildren(
        element("p", { class: "help" }, "There is one series only: its weight does not move the optimum."),
      );
      return;
    }
    this.rows = new Map(cloud.points.series.map(({ name }) => [name, this.row(name)]));
    const schemes = SCHEMES.map(([scheme, words]) =>
      element("button", { type: "button", class: "quiet small", onclick: () => this.scheme(scheme) }, words),
    );
    this.run = element(
      "button",
      { type: "button", class: "small", hidden: true, onclick: () => once(this.run, () => this.submit()) },
      "New job with these weights",
    );
    this.reset = element(
      "button",
      { type: "button", class: "quiet small", hidden: true, onclick: () => this.set(this.own) },
      "Weights of the job",
    );
    holder.replaceChildren(
      element(
        "p",
        { class: "help" },
        "From the stored responses, without a run. The share is that of the series in the objective of the best fit.",
      ),
      ...[...this.rows.values()].map(({ line }) => line),
      element("p", { class: "buttons" }, schemes, this.reset, maySubmit ? this.run : null),
      this.moved,
      this.warnings,
      this.message,
    );
    this.show();
  }

  row(name) {
    const id = `weight-${name}`;
    const slider = element("input", { type: "range", id, min: -DECADES, max: DECADES, step: 0.01, value: "0" });
    const exact = element("input", { type: "number", min: 0, step: "any", "aria-label": `Weight of ${name}` });
    const share = element("output", { class: "n", for: id });
    const base = this.own[name] || 1;
    slider.addEventListener("input", () =>
      this.set({
        ...this.cloud.weights,
        [name]: Number(slider.value) === 0 ? this.own[name] : base * 10 ** Number(slider.value),
      }),
    );
    exact.addEventListener("change", () => {
      if (Number(exact.value) >= 0) this.set({ ...this.cloud.weights, [name]: Number(exact.value) });
    });
    return {
      slider,
      exact,
      share,
      base,
      line: element("div", { class: "weight" }, element("label", { for: id }, name), slider, exact, share),
    };
  }

  /** Show a later state of the job. */
  take(cloud) {
    this.cloud = cloud;
    this.show();
  }

  set(weights) {
    if (!Object.values(weights).some((weight) => weight > 0)) {
      this.message.textContent = "One weight must be above 0.";
      return;
    }
    this.message.textContent = "";
    this.onWeights(weights);
    this.show();
    clearTimeout(this.timer);
    this.timer = setTimeout(() => this.ask(), 400);
  }

  show() {
    if (!this.rows) return;
    const { cloud } = this;
    const shares = cloud.shares(cloud.best);
    for (const [name, { slider, exact, share, base }] of this.rows) {
      const weight = cloud.weights[name];
      slider.value = String(Math.max(-DECADES, Math.min(DECADES, Math.log10(weight / base || 1e-9))));
      slider.setAttribute("aria-valuetext", `${number(weight, 3)}, share ${percent(shares[name])}`);
      if (document.activeElement !== exact) exact.value = String(Number(weight.toPrecision(4)));
      share.textContent = percent(shares[name]);
    }
    this.run.hidden = this.reset.hidden = !cloud.reweighted;
    if (!cloud.reweighted) this.warnings.replaceChildren();
    const values = cloud.parameters.map(({ name }, i) => `${symbol(name)} = ${number(cloud.values(i)[cloud.best], 4)}`);
    this.moved.textContent = `${cloud.reweighted ? "Best under these weights" : "Best"}: ${values.join(", ")}`;
  }

  /** The service knows whether the new optimum can be trusted, and makes the problem of a new job. */
  async ask() {
    if (!this.cloud.reweighted) return;
    try {
      const answer = await post(`/jobs/${this.job}/reweight`, { weights: this.cloud.weights });
      if (this.cloud.reweighted) this.answered(answer);
    } catch (error) {
      this.message.textContent = error.message;
    }
  }

  answered(answer) {
    this.problem = answer.problem;
    this.warnings.replaceChildren(...answer.warnings.map((text) => element("li", {}, typeset(text))));
  }

  async scheme(weighting) {
    try {
      const answer = await post(`/jobs/${this.job}/reweight`, { weighting });
      this.message.textContent = "";
      this.onWeights(Object.fromEntries(answer.weights.map(({ series, weight }) => [series, weight])));
      this.show();
      this.answered(answer);
    } catch (error) {
      this.message.textContent = error.message;
    }
  }

  async submit() {
    try {
      const { problem } = await post(`/jobs/${this.job}/reweight`, { weights: this.cloud.weights });
      const made = await post("/jobs", { ...problem, name: `${problem.name} (other weights)`.slice(0, 200) });
      location.assign(`/jobs/${made.id}`);
    } catch (error) {
      this.message.textContent = error.message;
      announce(error.message);
    }
  }
}
