// Follow-ups that evaluate more around the optimum, and what they have found: intervals and profiles.
import { doubt } from "../alarm.js";
import { BUTTONS, FOLLOW_UPS, affordable, costWords } from "../costs.js";
import { element, exchange, once, tableHead, wide } from "../dom.js";
import { count, ends, number, percent, symbol, typeset } from "../format.js";
import { get, post } from "../http.js";
import { colour, palette, plot } from "../plot.js";
import { ENDED, OPEN } from "../states.js";
import { posterior } from "./posterior.js";

const BASES = {
  needs_profile: " (approximate: the model is nonlinear there; profiles give it)",
  correlated: " (widened{by} for correlated residuals)",
  uneven: " (widened{by} for uneven residuals)",
  possible: " (widened{by} for a correlation that so few readings cannot exclude)",
  stated: " (widened{by} for correlated noise, as stated)",
  tests: " (widened{by} for tests that differ)",
  moved: " (by likelihood from one run at each end)",
  profile: " (by likelihood)",
};

/** What an interval rests on; a factor that rounds to 1 is not said. */
function basisOf({ needs_profile: needed, interval_basis: basis, widening }) {
  const words = BASES[needed ? "needs_profile" : basis] ?? "";
  if (words.includes("{by}") && widening && widening < 1.05) return "";
  return words.replace("{by}", widening ? ` by a factor of ${number(widening, 2)}` : "");
}

const AGAIN_SECONDS = 2;
const LATER = new Set(["profile", "jackknife"]); // they start from the sensitivities

const KINDS = [
  ["sensitivity", "sensitivity", BUTTONS.sensitivity, "Goes to the minimum; standard errors, intervals, combinations"],
  [
    "profile",
    "profile",
    BUTTONS.profile,
    "The lowest objective for every value of a parameter; from the sensitivities",
  ],
  [
    "jackknife",
    "jackknife",
    BUTTONS.jackknife,
    "Fits the parameters again without each test: which test pulls; from the sensitivities",
  ],
  [
    "explore",
    "explore",
    BUTTONS.explore,
    "Runs where a second basin is most likely: swapped values, other good runs, unexplored places",
  ],
  ["sobol", "global-sensitivity", "Global sensitivity (Sobol)", "Influence over the whole searched space"],
];

export class Uncertainty {
  constructor(holder, { job, maySubmit, units, objectiveUnit, onFound, onCosts, onAnswer }) {
    Object.assign(this, { job, maySubmit, units, objectiveUnit, onFound, onCosts, onAnswer });
    this.message = element("p", { class: "error", role: "alert" });
    this.costs = new Map();
    this.starts = new Map(
      KINDS.map(([kind, path, words, help]) => [
        kind,
        element(
          "button",
          {
            type: "button",
            class: "quiet",
            title: help,
            onclick: ({ currentTarget }) => once(currentTarget, () => this.begin(kind, path, words)),
          },
          words,
        ),
      ]),
    );
    this.buttons = maySubmit ? element("div", { class: "buttons" }, [...this.starts.values()]) : null;
    this.jobs = element("ul");
    this.table = element("div");
    this.profiles = element("div");
    this.indices = element("div");
    holder.append(
      element(
        "p",
        { class: "help" },
        "Each is a separate job; its results appear here, in the verdicts and in the report.",
      ),
      ...[this.buttons, this.message, this.jobs, this.table, this.profiles, this.indices].filter(Boolean),
      posterior(job, units),
    );
  }

  /** Runs and time on every button, before it is pressed. */
  async price() {
    if (!this.maySubmit) return;
    const { items } = await get(`/jobs/${this.job}/follow-ups`);
    this.costs = new Map(items.map((cost) => [cost.kind, cost]));
    this.onCosts(this.costs);
    for (const [kind, , words] of KINDS) {
      const cost = this.costs.get(kind),
        button = this.starts.get(kind);
      button.hidden = !cost; // of one test none can be left out
      if (cost) exchange(button, words, element("small", {}, this.words(kind, cost)));
    }
  }

  words(kind, cost) {
    if (!cost.refused) return costWords(cost);
    return LATER.has(kind) ? `with the sensitivities first: ${costWords(this.both(cost))}` : "";
  }

  /** What a follow-up takes with the sensitivities that it starts from. */
  both({ evaluations, seconds }) {
    const first = this.costs.get("sensitivity");
    const known = first.seconds !== null && seconds !== null;
    return {
      evaluations: first.evaluations + evaluations,
      exact: false,
      seconds: known ? first.seconds + seconds : null,
    };
  }

  /** As if its button had been pressed. */
  start(kind) {
    const button = this.starts.get(kind);
    button.scrollIntoView({ block: "center" });
    button.click();
  }

  async begin(kind, path, words) {
    this.message.textContent = "";
    try {
      if (!this.costs.has(kind)) await this.price();
      const cost = this.costs.get(kind);
      const both = cost?.refused && LATER.has(kind);
      if ((both || !cost?.refused) && !(await affordable(words, both ? this.both(cost) : cost))) return;
      const made = await post(`/jobs/${this.job}/${both ? "sensitivity" : path}`, {});
      this.next = both ? { after: made.id, path } : null;
      await this.refresh();
    } catch (error) {
      this.message.textContent = error.message;
    }
  }

  async cancel(id) {
    try {
      await post(`/jobs/${id}/cancel`);
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
    const first = this.next && found.follow_ups.find(({ id }) => id === this.next.after);
    if (first && ENDED.has(first.state)) return void (await this.goOn(first.state));
    const open = found.follow_ups.filter(({ state }) => !ENDED.has(state)).length;
    exchange(
      this.jobs,
      found.follow_ups.map(({ id, kind, state, evaluations }) =>
        element(
          "li",
          {},
          element("a", { href: `/jobs/${id}` }, FOLLOW_UPS[kind] ?? kind),
          " ",
          element("span", { class: `state ${state}` }, state),
          ` ${count(evaluations)} evaluations `,
          this.maySubmit && OPEN.has(state)
            ? element(
                "button",
                {
                  type: "button",
                  class: "danger small",
                  "aria-label": `Cancel ${FOLLOW_UPS[kind] ?? kind}`,
                  onclick: ({ currentTarget }) => once(currentTarget, () => this.cancel(id)),
                },
                "Cancel",
              )
            : null,
        ),
      ),
    );
    this.table.replaceChildren(...this.intervals(found));
    this.showProfiles(found.profiles);
    this.indices.replaceChildren(...this.influences(found.global_sensitivities));
    this.onAnswer?.(found);
    if (this.open && open < this.open) this.onFound();
    if (open !== this.open) this.price().catch(() => {}); // the buttons say no costs, then
    this.open = open;
    if (open) this.timer = setTimeout(() => this.refresh(), 1000 * AGAIN_SECONDS);
  }

  /** The sensitivities have ended: start what was to come after them. */
  async goOn(state) {
    const { path } = this.next;
    this.next = null;
    try {
      if (state === "finished") await post(`/jobs/${this.job}/${path}`, {});
    } catch (error) {
      this.message.textContent = error.message;
    }
    this.onFound();
    await this.refresh();
  }

  intervals({ linearisation, jackknife, notes, fit }) {
    const remarks = [
      ...this.withoutTests(jackknife ?? linearisation?.without_tests, Boolean(jackknife)),
      ...notes.map((text) => element("p", { class: "help" }, typeset(text))),
    ];
    if (!linearisation)
      return [element("p", { class: "empty" }, "No sensitivities at the optimum have been evaluated yet."), ...remarks];
    const rows = Object.entries(linearisation.parameters).map(([name, at]) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, `${symbol(name)}${this.units[name] === "-" ? "" : ` [${this.units[name]}]`}`),
        element("td", { class: "n" }, number(at.value, 5)),
        element("td", { class: "n" }, number(at.standard_error, 3)),
        element("td", {}, at.interval ? `${ends(...at.interval)}${basisOf(at)}` : typeset(at.why_no_interval ?? "–")),
        element("td", { class: "n" }, number(at.influence, 3)),
      ),
    );
    const head = [
      "Parameter",
      "At the optimum",
      "Standard error",
      `${percent(linearisation.level)} interval${doubt(fit) ? `: does not hold. ${doubt(fit)}` : ""}`,
      "Influence",
    ];
    const where =
      linearisation.at_optimum || linearisation.distance.every((d) => d === null)
        ? ""
        : "The search had not reached the minimum: these values are those of a point near it.";
    return [
      wide(
        "Intervals",
        element(
          "table",
          {},
          tableHead(head, (i) => [1, 2, 4].includes(i)),
          element("tbody", {}, rows),
        ),
      ),
      where ? element("p", { class: "help" }, where) : "",
      ...remarks,
    ];
  }

  /** The values without each of the tests, and the interval between tests. */
  withoutTests(found, fitted) {
    if (!found) return [];
    const each = Object.entries(found.parameters);
    const row = (head, cell) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, head),
        each.map(([, one]) => element("td", { class: "n" }, cell(one))),
      );
    return [
      element("h3", {}, "Does one test pull?"),
      wide(
        "Values without each test",
        element(
          "table",
          {},
          tableHead(["Tests", ...each.map(([name]) => symbol(name))], (i) => i > 0),
          element(
            "tbody",
            {},
            row("all tests", ({ value }) => number(value, 4)),
            found.tests.map((test) =>
              row(`without ${test}`, ({ values }) => (values[test] === null ? "–" : number(values[test], 4))),
            ),
            row("95 % interval between tests", ({ interval }) => (interval ? ends(...interval) : "–")),
            row("pulled most by", ({ pulls }) => pulls ?? "–"),
          ),
        ),
      ),
      element(
        "p",
        { class: "help" },
        `${fitted ? "Fitted again without each test" : "By linearisation, without further runs"}; each test counts as one piece of information. A dash: one test alone determines the parameter.`,
      ),
    ];
  }

  showProfiles(profiles) {
    if (!profiles.length) return;
    this.shown = profiles;
    if (!this.profile) {
      const choose = element(
        "select",
        { "aria-label": "Parameter of the profile", onchange: () => this.profile.draw() },
        profiles.map(({ parameter }) => element("option", { value: parameter }, symbol(parameter))),
      );
      this.choose = choose;
      const place = element("div");
      this.profiles.replaceChildren(
        element("h3", {}, "Profiles"),
        element("p", {}, element("label", {}, "Parameter ", choose)),
        place,
      );
      this.profile = plot(place, () => this.profileFigure());
    }
    this.profile.draw();
  }

  profileFigure() {
    const { parameter, values, objectives, limit, lower, upper } =
      this.shown.find((one) => one.parameter === this.choose.value) ?? this.shown[0];
    const unit = this.units[parameter] === "-" ? "" : ` [${this.units[parameter]}]`;
    const f = this.objectiveUnit ? `f [${this.objectiveUnit}]` : "f";
    const [blue] = palette();
    const line = { type: "line", line: { color: colour("--ink"), dash: "dash", width: 1 } };
    const marks = [lower, upper]
      .filter((value) => value !== null)
      .map((value) => ({
        ...line,
        x0: value,
        x1: value,
        yref: "paper",
        y0: 0,
        y1: 1,
        line: { ...line.line, dash: "dot" },
      }));
    const title = (text) => ({ title: { text } });
    return {
      data: [{ x: values, y: objectives, mode: "lines+markers", name: "lowest objective", line: { color: blue } }],
      layout: {
        height: 320,
        xaxis: title(symbol(parameter) + unit),
        yaxis: title(f),
        shapes: [{ ...line, xref: "paper", x0: 0, x1: 1, y0: limit, y1: limit }, ...marks],
        showlegend: false,
      },
      label: `Profile of ${symbol(parameter)}; dashed: the limit, dotted: the ends of the interval`,
      columns: { [symbol(parameter)]: values, [f]: objectives },
    };
  }

  influences(found) {
    if (!found.length) return [];
    const index = (value, half) =>
      value === null ? "–" : half === null ? value.toFixed(2) : `${value.toFixed(2)} ± ${half.toFixed(2)}`;
    return [
      element("h3", {}, "Global sensitivity"),
      ...found.map(({ kind, output, indices }) =>
        element(
          "div",
          { class: "wide" },
          element(
            "table",
            {},
            element("caption", { class: "help" }, `${kind}: ${output}`),
            tableHead(
              ["Parameter", ...(kind === "sobol" ? ["First order", "Total"] : ["Mean effect", "Spread"])],
              (i) => i > 0,
            ),
            element(
              "tbody",
              {},
              indices.map((one) =>
                element(
                  "tr",
                  {},
                  element("th", { scope: "row" }, symbol(one.parameter)),
                  element("td", { class: "n" }, index(one.main, one.main_half_width)),
                  element("td", { class: "n" }, index(one.total, one.total_half_width)),
                ),
              ),
            ),
          ),
        ),
      ),
    ];
  }
}
