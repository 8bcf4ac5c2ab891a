// Follow-ups that evaluate more around the optimum, and what they have found: intervals and profiles.
import { doubt } from "../alarm.js";
import { element, once } from "../dom.js";
import { ends, number, percent, symbol } from "../format.js";
import { get, post } from "../http.js";
import { colour, palette, plot } from "../plot.js";
import { ENDED } from "../states.js";

const BASES = { bent: " (approximate: the model bends there; profiles give it)", correlated: " (widened for correlated residuals)", uneven: " (widened for uneven residuals)", profile: " (by likelihood)" };
const AGAIN_SECONDS = 2;

export class Uncertainty {
  constructor(holder, { job, maySubmit, units, objectiveUnit, onFound }) {
    Object.assign(this, { job, units, objectiveUnit, onFound });
    this.message = element("p", { class: "error", role: "alert" });
    const act = (path, text, help) => element("button", { type: "button", class: "quiet", title: help, onclick: ({ currentTarget }) => once(currentTarget, () => this.begin(path)) }, text);
    const buttons = maySubmit ? element("div", { class: "buttons" },
      act("sensitivity", "Sensitivities at the optimum", "Goes to the minimum; standard errors, intervals, combinations"),
      act("profile", "Profiles of all parameters", "The lowest objective for every value of a parameter; needs the sensitivities first"),
      act("global-sensitivity", "Global sensitivity (Sobol)", "Influence over the whole searched space")) : null;
    this.jobs = element("ul");
    this.table = element("div");
    this.profiles = element("div");
    this.indices = element("div");
    holder.append(element("p", { class: "help" }, "Each is a job of its own; what it finds is shown here and enters the verdicts and the report."), buttons, this.message, this.jobs, this.table, this.profiles, this.indices);
  }

  async begin(path) {
    this.message.textContent = "";
    try {
      await post(`/jobs/${this.job}/${path}`, {});
      await this.refresh();
    } catch (error) {
      this.message.textContent = error.message;
    }
  }

  async refresh() {
    clearTimeout(this.timer);
    let found;
    try {
      found = await get(`/jobs/${this.job}/uncertainty`);
    } catch (error) {
      this.message.textContent = error.message;
      return;
    }
    const open = found.follow_ups.filter(({ state }) => !ENDED.has(state)).length;
    this.jobs.replaceChildren(...found.follow_ups.map(({ id, kind, state, evaluations }) => element("li", {}, element("a", { href: `/jobs/${id}` }, kind), " ", element("span", { class: `state ${state}` }, state), ` ${evaluations} evaluations`)));
    this.table.replaceChildren(...this.intervals(found));
    this.showProfiles(found.profiles);
    this.indices.replaceChildren(...this.influences(found.global_sensitivities));
    if (this.open && open < this.open) this.onFound();
    this.open = open;
    if (open) this.timer = setTimeout(() => this.refresh(), 1000 * AGAIN_SECONDS);
  }

  intervals({ linearisation, notes, fit }) {
    const remarks = notes.map((text) => element("p", { class: "help" }, text));
    if (!linearisation) return [element("p", { class: "empty" }, "No sensitivities at the optimum have been evaluated yet."), ...remarks];
    const rows = Object.entries(linearisation.parameters).map(([name, at]) => element("tr", {}, element("th", { scope: "row" }, `${symbol(name)}${this.units[name] === "-" ? "" : ` [${this.units[name]}]`}`),
      element("td", { class: "n" }, number(at.value, 5)), element("td", { class: "n" }, number(at.standard_error, 3)),
      element("td", {}, at.interval ? `${ends(...at.interval)}${BASES[at.bent ? "bent" : at.interval_basis] ?? ""}` : at.why_no_interval ?? "–"), element("td", { class: "n" }, number(at.influence, 3))));
    const head = ["Parameter", "At the optimum", "Standard error", `${percent(linearisation.level)} interval${doubt(fit) ? `: does not hold. ${doubt(fit)}` : ""}`, "Influence"];
    const where = linearisation.at_optimum || linearisation.distance.every((d) => d === null) ? "" : "The search had not reached the minimum: these values are those of a point near it.";
    return [element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "Intervals" }, element("table", {}, element("thead", {}, element("tr", {}, head.map((text, i) => element("th", { scope: "col", class: [1, 2, 4].includes(i) ? "n" : null }, text)))), element("tbody", {}, rows))), where ? element("p", { class: "help" }, where) : "", ...remarks];
  }

  showProfiles(profiles) {
    if (!profiles.length) return;
    this.shown = profiles;
    if (!this.profile) {
      const choose = element("select", { "aria-label": "Parameter of the profile", onchange: () => this.profile.draw() }, profiles.map(({ parameter }) => element("option", { value: parameter }, symbol(parameter))));
      this.choose = choose;
      const place = element("div");
      this.profiles.replaceChildren(element("h3", {}, "Profiles"), element("p", {}, element("label", {}, "Parameter ", choose)), place);
      this.profile = plot(place, () => this.profileFigure());
    }
    this.profile.draw();
  }

  profileFigure() {
    const { parameter, values, objectives, limit, lower, upper } = this.shown.find((one) => one.parameter === this.choose.value) ?? this.shown[0];
    const unit = this.units[parameter] === "-" ? "" : ` [${this.units[parameter]}]`;
    const f = this.objectiveUnit ? `f [${this.objectiveUnit}]` : "f";
    const [blue] = palette();
    const line = { type: "line", line: { color: colour("--ink"), dash: "dash", width: 1 } };
    const marks = [lower, upper].filter((value) => value !== null).map((value) => ({ ...line, x0: value, x1: value, yref: "paper", y0: 0, y1: 1, line: { ...line.line, dash: "dot" } }));
    const title = (text) => ({ title: { text } });
    return {
      data: [{ x: values, y: objectives, mode: "lines+markers", name: "lowest objective", line: { color: blue } }],
      layout: { height: 320, xaxis: title(symbol(parameter) + unit), yaxis: title(f), shapes: [{ ...line, xref: "paper", x0: 0, x1: 1, y0: limit, y1: limit }, ...marks], showlegend: false },
      label: `Profile of ${parameter}; dashed: the limit, dotted: the ends of the interval`,
      columns: { [parameter]: values, [f]: objectives },
    };
  }

  influences(found) {
    if (!found.length) return [];
    const index = (value, half) => (value === null ? "–" : half === null ? value.toFixed(2) : `${value.toFixed(2)} ± ${half.toFixed(2)}`);
    return [element("h3", {}, "Global sensitivity"), ...found.map(({ kind, output, indices }) => element("div", { class: "wide" }, element("table", {}, element("caption", { class: "help" }, `${kind}: ${output}`),
      element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Parameter"), (kind === "sobol" ? ["First order", "Total"] : ["Mean effect", "Spread"]).map((text) => element("th", { scope: "col", class: "n" }, text)))),
      element("tbody", {}, indices.map((one) => element("tr", {}, element("th", { scope: "row" }, symbol(one.parameter)), element("td", { class: "n" }, index(one.main, one.main_half_width)), element("td", { class: "n" }, index(one.total, one.total_half_width))))))))];
  }
}
