// A list of like entries as a table, into which rows of a spreadsheet can be pasted.
import { element, exchange, tableHead } from "../dom.js";
import { errorPlace, field, idOf, numberOf } from "./fields.js";
import { words } from "./schema.js";

/** Rows that were copied from a spreadsheet: cells between tabs (or semicolons), numbers where they are some. */
function pastedRows(text) {
  const lines = text
    .replace(/\r/g, "")
    .split("\n")
    .filter((line) => line.trim());
  return lines.map((line) => line.split(/\t|;/).map((cell) => numberOf(cell)));
}

export function table(context, path, schema, { label, help, onchange }) {
  const { draft, schemas } = context;
  const item = schemas.present(schema.items).schema;
  const columns = Object.entries(item.properties).map(([key, one]) => ({ key, ...schemas.present(one) }));
  const place = element("div", { class: "wide" });
  const rows = () => draft.read(path) ?? [];

  function draw() {
    const head = columns.map(({ key, schema: one }) =>
      element("th", { scope: "col" }, words(key), one["x-unit"] ? ` [${one["x-unit"]}]` : null),
    );
    const body = rows().map((_, i) =>
      element(
        "tr",
        {},
        element("th", { scope: "row", class: "n" }, String(i + 1)),
        columns.map((column) => element("td", {}, cell(column, i))),
        element(
          "td",
          {},
          element(
            "button",
            {
              type: "button",
              class: "quiet small",
              "aria-label": `Remove row ${i + 1} of ${label}`,
              onclick: () => remove(i),
            },
            "×",
          ),
        ),
      ),
    );
    exchange(
      place,
      rows().length
        ? element("table", { class: "rows" }, tableHead(["No.", head, ""]), element("tbody", {}, body))
        : element("p", { class: "help" }, "No rows yet."),
    );
  }

  function cell({ key, schema: one, nullable }, i) {
    const made = field(draft, [...path, i, key], {
      label: `${words(key)} of row ${i + 1}`,
      kind: one.enum ? "select" : schemas.shape(one),
      options: one.enum?.map((name) => [name, words(String(name))]),
      unit: one["x-unit"],
      nullable,
      bare: true,
      fallback: one.default,
      onchange,
    });
    made.querySelector("input")?.addEventListener("paste", (event) => paste(event, i, key));
    return made;
  }

  function paste(event, first, key) {
    const given = pastedRows(event.clipboardData.getData("text"));
    if (given.length < 2 && (given[0]?.length ?? 0) < 2) return; // one value: as usual
    event.preventDefault();
    const from = columns.findIndex((column) => column.key === key);
    const next = rows().map((row) => ({ ...row }));
    given.forEach((cells, r) => {
      next[first + r] ??= {};
      cells.forEach((value, c) => {
        if (columns[from + c] && value !== undefined) next[first + r][columns[from + c].key] = value;
      });
    });
    change(next);
  }

  function change(next) {
    draft.write(path, next);
    draw();
    onchange?.();
  }
  const remove = (i) => change(rows().filter((_, one) => one !== i));
  const add = () => {
    change([...rows(), {}]);
    document.getElementById(idOf([...path, rows().length - 1, columns[0].key]))?.focus();
  };
  draw();
  return element(
    "fieldset",
    { class: "group" },
    element("legend", {}, label),
    element("p", { class: "help" }, help, " Rows of a spreadsheet can be pasted into a cell."),
    place,
    element(
      "div",
      { class: "buttons" },
      element("button", { type: "button", class: "quiet", onclick: add }, "Add a row"),
    ),
    errorPlace(path),
  );
}
