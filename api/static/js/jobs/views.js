// Views of the list that somebody keeps in this browser: filters and order, by a name.
import { announce, dialog, element, exchange } from "../dom.js";

const KEY = "job-views";

function kept() {
  try {
    const views = JSON.parse(localStorage.getItem(KEY) ?? "[]");
    return Array.isArray(views) ? views.filter(({ name, query } = {}) => name && query) : [];
  } catch {
    return []; // storage may be forbidden, or hold something else
  }
}

/** Filters and order of the address; a page of the list is no view. */
function here() {
  const words = new URLSearchParams(location.search);
  for (const [name, value] of [...words]) if (name === "cursor" || !value) words.delete(name);
  words.sort();
  return words.toString();
}

function keep(views) {
  try {
    localStorage.setItem(KEY, JSON.stringify(views));
  } catch {
    announce("This browser keeps no views: its storage is full or switched off.", 12);
  }
  showViews();
}

function ask() {
  const name = element("input", { required: true, maxlength: 40, placeholder: "running jobs of the dam" });
  const form = element(
    "form",
    {},
    element("label", {}, "Name of the view", name),
    element("p", { class: "help" }, "Filters and order of the list, kept in this browser."),
    element("div", { class: "buttons" }, element("button", { type: "submit" }, "Keep")),
  );
  const made = dialog("Keep this view", form);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    if (!name.value.trim()) return;
    made.close();
    const view = { name: name.value.trim(), query: here() };
    keep([...kept().filter((other) => other.name !== view.name), view]);
  });
}

/** Show the views, and a button that keeps the present one where it is not kept. */
export function showViews() {
  const place = document.getElementById("views"),
    views = kept(),
    now = here();
  exchange(
    place,
    views.map(({ name, query }) =>
      element(
        "span",
        { class: "tag" },
        element("a", { href: `/?${query}`, "aria-current": query === now && "true" }, name),
        " ",
        element(
          "button",
          {
            type: "button",
            class: "link",
            "aria-label": `Remove the view ${name}`,
            onclick: () => keep(kept().filter((other) => other.name !== name)),
          },
          "×",
        ),
      ),
    ),
    now && !views.some(({ query }) => query === now)
      ? element("button", { type: "button", class: "quiet small", onclick: ask }, "Keep this view …")
      : null,
  );
  place.hidden = !place.childElementCount;
}
