// The table of evaluations: filter, order, leaf through, open one.
import { element, empty, exchange, failure, tableHead, wide } from "../dom.js";
import { duration, number, symbol, withUnit } from "../format.js";
import { address, get } from "../http.js";
import { paced } from "../pace.js";
import { ENDED, EVALUATION_STATES } from "../states.js";
import { openEvaluation } from "./evaluation.js";

const PAGE = 25,
  INTERVAL = 3000;

export function evaluations(view) {
  const place = document.getElementById("evaluations");
  const cursors = [null]; // of the pages so far
  let next = null,
    asked = 0,
    sort = "generation";

  const control = (label, input) => element("label", {}, label, input);
  const state = element(
    "select",
    { name: "state" },
    element("option", { value: "" }, "all"),
    [...EVALUATION_STATES].map((name) => element("option", {}, name)),
  );
  const generation = element("input", { name: "generation", type: "number", min: 0, step: 1, placeholder: "all" });
  const most = element("input", { name: "max_objective", type: "number", step: "any", placeholder: "any" });
  const filters = element(
    "form",
    { class: "controls", "aria-label": "Filter the evaluations" },
    control("State", state),
    control("Generation", generation),
    control("Objective up to", most),
  );
  const table = element("div", {});
  const first = element(
    "button",
    { type: "button", class: "quiet", onclick: () => leaf(() => cursors.splice(1)) },
    "First page",
  );
  const back = element(
    "button",
    { type: "button", class: "quiet", onclick: () => leaf(() => cursors.pop()) },
    "Previous",
  );
  const on = element(
    "button",
    { type: "button", class: "quiet", onclick: () => leaf(() => cursors.push(next)) },
    "Next",
  );
  const csv = element("a", { class: "button quiet" }, "Download as CSV");
  place.replaceChildren(filters, table, element("div", { class: "buttons" }, first, back, on, csv));

  function leaf(turn) {
    turn();
    show();
  }

  const filter = () => ({ state: state.value, generation: generation.value, max_objective: most.value });
  const query = () => ({ ...filter(), sort: sort === "generation" ? "" : sort });

  const head = (text, kind) => element("th", { scope: "col", class: kind }, text);

  /** The head of a column by which the rows can be ordered. */
  function sortHead(key, text, title, kind) {
    const act = () => {
      sort = key;
      leaf(() => cursors.splice(1));
    };
    const here = sort === key;
    const button = element(
      "button",
      { type: "button", class: "link sort", id: `sort-${key}`, title, onclick: act },
      text,
    );
    const arrow = here && element("span", { "aria-hidden": "true" }, " ▲");
    return element("th", { scope: "col", class: kind, "aria-sort": here && "ascending" }, button, arrow);
  }

  async function show() {
    const turn = ++asked;
    try {
      const page = await get(`/jobs/${view.id}/evaluations`, { ...query(), limit: PAGE, cursor: cursors.at(-1) });
      if (turn !== asked) return;
      next = page.next_cursor;
      exchange(
        table,
        page.items.length
          ? filled(page.items)
          : empty(Object.values(filter()).some(Boolean) ? "No evaluation matches." : "No evaluation has started yet."),
      );
    } catch (error) {
      if (turn === asked) exchange(table, failure(error));
    }
    first.hidden = back.hidden = cursors.length === 1;
    on.hidden = next === null;
    csv.href = address(`/jobs/${view.id}/evaluations`, { format: "csv", ...filter() });
  }

  function filled(items) {
    const names = view.job.free_parameters;
    const units = new Map((view.fit?.parameters ?? []).map(({ name, unit }) => [name, unit]));
    const failed = items.some(({ reason }) => reason);
    const heads = [
      sortHead("generation", "Generation · particle", "In the order of the search"),
      head("State"),
      sortHead("objective", withUnit("Objective", view.fit?.objective_unit), "Lowest objective first", "n"),
      ...names.map((name) => head(withUnit(symbol(name), units.get(name)), "n")),
      head("Time", "n"),
      head("Tries", "n"),
      ...(failed ? [head("Why it failed")] : []),
    ];
    const rows = items.map((one) =>
      element(
        "tr",
        {
          onclick: ({ target }) => {
            if (!target.closest("button")) open(one);
          },
        },
        element(
          "td",
          {},
          element(
            "button",
            {
              type: "button",
              class: "link",
              onclick: () => open(one),
              "aria-label": `${one.generation} · ${one.particle}: Open evaluation of particle ${one.particle} in generation ${one.generation}`,
            },
            `${one.generation} · ${one.particle}`,
          ),
        ),
        element("td", {}, one.state),
        element("td", { class: "n" }, number(one.objective, 6)),
        names.map((name) => element("td", { class: "n" }, number(one.parameters[name], 5))),
        element("td", { class: "n" }, duration(one.seconds)),
        element("td", { class: "n" }, String(one.attempts)),
        failed
          ? element(
              "td",
              { class: "why" },
              one.reason ? `${one.reason.replaceAll("_", " ")}: ${one.message ?? ""}` : "",
            )
          : null,
      ),
    );
    return wide(
      "Evaluations",
      element("table", { class: "evaluations" }, tableHead(heads), element("tbody", {}, rows)),
    );
  }

  const open = (one) => openEvaluation(view, one.generation, one.particle);

  let typing = null;
  filters.addEventListener("submit", (event) => event.preventDefault());
  filters.addEventListener("input", () => {
    clearTimeout(typing);
    typing = setTimeout(() => {
      cursors.splice(1);
      show();
    }, 300);
  });

  // Who is in the table with the keyboard stays there.
  const renew = paced(
    async () => {
      if (!table.contains(document.activeElement) || !table.querySelector("tbody")) await show();
    },
    INTERVAL,
    place,
  );
  return {
    job: renew,
    generation: () => {
      if (!ENDED.has(view.job.state)) renew();
    },
    fit: renew,
  };
}
