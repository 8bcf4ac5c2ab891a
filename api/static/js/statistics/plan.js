// The follow-up job: the same problem with parameters fixed, linked or given other bounds.
import { affordable, costWords } from "../costs.js";
import { element, exchange, once, tableHead, wide } from "../dom.js";
import { count, duration, number, symbol } from "../format.js";
import { get, post } from "../http.js";
import { messageOf, placeOf } from "../new/words.js";
import { withParameters } from "../remedies.js";

const WORDS = { fixed: "fixed", linked: "linked", widened: "bounds changed" };

export class Plan {
  constructor(holder, { job, name, parameters, best }) {
    Object.assign(this, { job, name, best });
    this.rows = new Map(parameters.map((parameter) => [parameter.name, this.row(parameter)]));
    this.title = element("input", { id: "plan-name", maxlength: 200, size: 40, value: "" });
    this.message = element("p", { class: "error", role: "alert" });
    this.told = element("p", { class: "help", role: "status" });
    this.start = element(
      "button",
      { type: "button", onclick: () => once(this.start, () => this.submit()) },
      "Start follow-up",
    );
    this.check = element(
      "button",
      { type: "button", class: "quiet", onclick: () => once(this.check, () => this.tryOut()) },
      "Check first",
    );
    holder.append(
      element(
        "p",
        { class: "help" },
        "The same problem and measurements as a new job, with these changes. This job stays as it is.",
      ),
      wide(
        "Parameters of the follow-up",
        element(
          "table",
          {},
          tableHead(["Parameter", "In the follow-up", "Value"]),
          element(
            "tbody",
            {},
            [...this.rows.values()].map(({ line }) => line),
          ),
        ),
      ),
      element("p", {}, element("label", { for: "plan-name" }, "Name of the job "), this.title),
      element("div", { class: "buttons" }, this.start, this.check),
      this.told,
      this.message,
    );
    this.changed();
  }

  row({ name, unit, lower, upper, scale }) {
    const words = `${symbol(name)}${unit === "-" ? "" : ` [${unit}]`}`;
    const number_ = (label, value) =>
      element("input", {
        type: "number",
        step: "any",
        "aria-label": `${label} of ${symbol(name)}`,
        value: String(Number(value.toPrecision(6))),
        oninput: () => this.changed(),
      });
    const value = number_("Value", this.best[name]);
    const expression = element("input", {
      type: "text",
      "aria-label": `Expression of ${symbol(name)}`,
      placeholder: "such as 0.5 * c",
      oninput: () => this.changed(),
    });
    const bounds = [number_("Lower bound", lower), number_("Upper bound", upper)];
    const fields = { free: [], fixed: [value], linked: [expression], widened: bounds };
    const place = element("td", {}, element("small", {}, `free from ${number(lower, 3)} to ${number(upper, 3)}`));
    const free = [...place.childNodes];
    const options = [
      ["free", "free as it is"],
      ["fixed", "fixed at"],
      ["linked", "linked:"],
      ["widened", "free between"],
    ];
    const choice = element(
      "select",
      {
        "aria-label": `${symbol(name)} in the follow-up`,
        onchange: () => {
          show();
          this.changed();
        },
      },
      options.map(([key, text]) => element("option", { value: key }, text)),
    );
    function show() {
      const kind = choice.value;
      place.replaceChildren(
        ...(kind === "free" ? free : kind === "widened" ? [bounds[0], " to ", bounds[1]] : fields[kind]),
      );
    }
    const section = () =>
      ({
        free: () => null,
        fixed: () => ({ value: Number(value.value) }),
        linked: () => ({ expression: expression.value }),
        widened: () => ({ lower: Number(bounds[0].value), upper: Number(bounds[1].value), scale }),
      })[choice.value]();
    const take = (kind, given) => {
      choice.value = kind;
      if (kind === "fixed") value.value = String(given.value);
      if (kind === "linked") expression.value = given.expression;
      if (kind === "widened")
        bounds.forEach((field, i) => {
          field.value = String(Number((i ? given.upper : given.lower).toPrecision(6)));
        });
      show();
      this.changed();
    };
    return {
      choice,
      section,
      take,
      line: element("tr", {}, element("th", { scope: "row" }, words), element("td", {}, choice), place),
    };
  }

  /** What differs from the job, by parameter. */
  changes() {
    return Object.fromEntries(
      [...this.rows].map(([name, row]) => [name, row.section()]).filter(([, section]) => section !== null),
    );
  }

  changed() {
    const kinds = [...this.rows]
      .filter(([, { choice }]) => choice.value !== "free")
      .map(([name, { choice }]) => `${symbol(name)} ${WORDS[choice.value]}`);
    if (!this.title.dataset.own)
      this.title.value = kinds.length ? `${this.name} (${kinds.join(", ")})`.slice(0, 200) : this.name;
    this.title.oninput = () => {
      this.title.dataset.own = "yes";
    };
    const left =
      this.rows.size -
      [...this.rows.values()].filter(({ choice }) => ["fixed", "linked"].includes(choice.value)).length;
    this.start.disabled = this.check.disabled = kinds.length === 0 || left === 0;
    this.message.textContent = "";
    this.told.textContent =
      kinds.length === 0
        ? "Nothing is changed yet: accept a proposal above, or choose here."
        : left === 0
          ? "No free parameter would be left."
          : `${kinds.join(", ")}; ${count(left)} free.`;
  }

  /** Take a proposal of a verdict over. */
  accept({ kind, parameter, changes }) {
    this.rows
      .get(parameter)
      .take({ fix: "fixed", link: "linked", widen: "widened" }[kind], changes.parameters[parameter]);
    this.told.scrollIntoView({ block: "nearest" });
  }

  /** Take one proposal over and start at once. */
  async startWith(proposal, button) {
    this.accept(proposal);
    await once(button, () => this.submit());
  }

  async document() {
    const problem = await get(`/jobs/${this.job}/problem`);
    return { ...withParameters(problem, this.changes()), name: this.title.value || problem.name };
  }

  /** The same search again costs about what it has cost before. */
  price(cost) {
    this.cost = cost;
    exchange(this.start, "Start follow-up", element("small", {}, costWords(cost)));
  }

  async submit() {
    this.message.textContent = "";
    try {
      if (!(await affordable("The follow-up", this.cost))) return;
      const made = await post("/jobs", await this.document());
      location.assign(`/jobs/${made.id}`);
    } catch (error) {
      this.refused(error);
    }
  }

  async tryOut() {
    this.told.textContent = "One forward calculation …";
    try {
      const {
        test_run: run,
        planned_evaluations: planned,
        estimated_seconds: whole,
      } = await post("/problems/check", await this.document());
      const cost = planned ? ` ${count(planned)} evaluations take about ${duration(whole)} on one worker.` : "";
      this.told.textContent =
        run.state === "finished"
          ? `It works: f = ${number(run.objective)} in ${duration(run.seconds)}.${cost}`
          : `The test run failed: ${run.message}`;
    } catch (error) {
      this.told.textContent = "";
      this.refused(error);
    }
  }

  refused(error) {
    this.message.textContent = error.issues.length
      ? error.issues.map((one) => `${placeOf(one.path)}: ${messageOf(one)}`).join("\n")
      : error.message;
  }
}
