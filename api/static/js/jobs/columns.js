// Parameters that are columns of the list, kept in its address.
import { dialog, element, empty } from "../dom.js";
import { symbol } from "../format.js";

const MOST = 8;

/** Ask which parameters of the jobs shown are columns, and go to the list that has them. `field` holds those of now. */
export function chooseColumns(list, field) {
  const now = field.value.split(",").filter(Boolean);
  const rows = [...list.querySelectorAll("tr[data-parameters]")];
  const names = new Set([...now, ...rows.flatMap((row) => row.dataset.parameters.split(" ").filter(Boolean))]);
  const box = (name) =>
    element(
      "label",
      { class: "choice" },
      element("input", { type: "checkbox", name: "column", value: name, checked: now.includes(name) }),
      element("span", {}, symbol(name)),
    );
  const boxes = [...names].sort((a, b) => a.localeCompare(b)).map(box);
  const chosen = () => [...form.querySelectorAll("input:checked")];
  const form = element(
    "form",
    {
      onchange: () => {
        for (const one of form.querySelectorAll("input:not(:checked)")) one.disabled = chosen().length >= MOST;
      },
      onsubmit: (event) => {
        event.preventDefault();
        const words = new URLSearchParams(location.search);
        const columns = chosen().map(({ value }) => value);
        words.delete("cursor");
        words.set("columns", columns.join(","));
        if (!columns.length) words.delete("columns");
        location.assign(words.size ? `/?${words}` : "/");
      },
    },
    boxes.length ? element("div", { class: "choices" }, boxes) : empty("No job of this page has a free parameter."),
    element("p", { class: "help" }, `At most ${MOST}. Without any, the list shows the first parameters of each job.`),
    element("div", { class: "buttons" }, element("button", { type: "submit" }, "Show")),
  );
  dialog("Columns of parameters", form);
}
