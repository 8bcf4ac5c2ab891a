// Small helpers for elements, dialogs and messages.
import { age, moment } from "./format.js";
import { translateBelow } from "./language.js";

/**
 * An element: `element("button", {type: "button", class: "quiet", onclick: act, dataset: {job: id}}, "Pause")`.
 * Properties with on… are listeners; true sets an empty attribute; false, null and undefined set none.
 * Children are nodes or text (never markup), in lists of any depth; null and false are left out.
 */
export function element(name, properties = {}, ...children) {
  return filled(document.createElement(name), properties, children);
}

/** The same for SVG. */
export function svg(name, properties = {}, ...children) {
  return filled(document.createElementNS("http://www.w3.org/2000/svg", name), properties, children);
}

/** Ages as words, with the moment itself as their title. */
export function renewAges(place = document) {
  for (const time of place.querySelectorAll("time.age")) {
    const words = age(time.dateTime);
    if (time.textContent !== words) time.textContent = words;
    time.title ||= moment(time.dateTime);
  }
}

/** How long ago something was; it grows while the page is looked at, and is the moment itself on paper. */
export function when(timestamp) {
  return element("time", { class: "age", datetime: timestamp, title: moment(timestamp) }, age(timestamp));
}

function filled(made, properties, children) {
  for (const [key, value] of Object.entries(properties)) {
    if (value === null || value === undefined || value === false) continue;
    if (key.startsWith("on")) made.addEventListener(key.slice(2), value);
    else if (key === "dataset") Object.assign(made.dataset, value);
    else if (key === "style") for (const [what, how] of Object.entries(value)) made.style.setProperty(what, how);
    else if (key === "value" || key === "checked" || key === "selected") made[key] = value;
    else made.setAttribute(key, value === true ? "" : String(value));
  }
  made.append(...children.flat(Infinity).filter((child) => child !== null && child !== undefined && child !== false));
  return made;
}

/** A region that scrolls sideways, also by keyboard. */
export function wide(label, ...children) {
  return element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": label }, ...children);
}

/** The head of a table, of texts ("": an empty cell) or cells; `numeric(i)` says which columns hold numbers. */
export function tableHead(heads, numeric = () => false) {
  const cell = (head, i) => {
    if (typeof head !== "string") return head;
    return head ? element("th", { scope: "col", class: numeric(i) && "n" }, head) : element("td");
  };
  return element("thead", {}, element("tr", {}, heads.flat().map(cell)));
}

/** Say something to everybody, screen readers too; it goes after some seconds. */
export function announce(text, seconds = 6) {
  const place = document.getElementById("status");
  place.textContent = text;
  clearTimeout(announce.timer);
  announce.timer = setTimeout(() => {
    place.textContent = "";
  }, 1000 * seconds);
}

/** Show that the connection is lost (a text) or there again (null). */
export function connection(text) {
  const place = document.getElementById("connection");
  place.textContent = text ?? "";
  place.hidden = text === null;
}

/** A message in the place of what could not be shown. */
export function failure(error) {
  return element("p", { class: "error", role: "alert" }, error.message);
}

/** What stands where there is nothing yet. */
export function empty(...children) {
  return element("p", { class: "empty" }, ...children);
}

const control = (node) =>
  [node.localName, node.getAttribute("href"), node.getAttribute("aria-label") ?? node.textContent].join(" ");

/**
 * Who is in a place with the keyboard: a function that brings them, when what stood there was replaced, to the control with
 * the same id, its cursor where it was, or else to one of the same kind and name.
 */
function held(place) {
  const active = document.activeElement;
  if (!place.contains(active) || active === place) return () => {};
  const { id, localName: kind, selectionStart: start, selectionEnd: end } = active,
    name = control(active);
  return () => {
    translateBelow(place);
    const again = id
      ? document.getElementById(id)
      : [...place.querySelectorAll(kind)].find((node) => control(node) === name);
    again?.focus({ preventScroll: true });
    if (again?.setSelectionRange && typeof start === "number") again.setSelectionRange(start, end);
  };
}

/** Replace the contents of a place (nested lists are flattened, null and false left out); the focus stays. */
export function exchange(place, ...made) {
  const back = held(place);
  place.replaceChildren(...made.flat(Infinity).filter(Boolean));
  back();
}

/** While `work` is running its button does nothing. It keeps the focus, which a disabled one would lose. */
export async function once(button, work) {
  if (button.ariaDisabled === "true") return;
  button.ariaDisabled = "true";
  try {
    await work();
  } finally {
    button.ariaDisabled = null;
  }
}

let dialogs = 0;

/** Open a dialog. Closed, it is removed, and the focus returns, also to a place that was redrawn meanwhile. */
function opened(made) {
  const back = held(document.body);
  made.addEventListener("close", () => {
    made.remove();
    if (document.activeElement === document.body) back();
  });
  document.body.append(made);
  made.showModal();
  return made;
}

/** A modal dialog with a title; returns it opened. It is closed by Escape, its button, or `.close()`, and then removed. */
export function dialog(title, ...children) {
  const id = `dialog-${++dialogs}`;
  const made = element("dialog", { "aria-labelledby": id }, element("h2", { id }, title), ...children);
  made.append(
    element(
      "div",
      { class: "buttons" },
      element("button", { type: "button", class: "quiet", onclick: () => made.close() }, "Close"),
    ),
  );
  return opened(made);
}

/** Ask before something that cannot be undone; a promise of true or false. */
export function confirmed(question, yes) {
  return new Promise((resolve) => {
    const id = `dialog-${++dialogs}`;
    const made = element(
      "dialog",
      { "aria-labelledby": id },
      element("p", { id }, question),
      element(
        "div",
        { class: "buttons" },
        element("button", { type: "button", class: "danger", onclick: () => made.close("yes") }, yes),
        element("button", { type: "button", class: "quiet", autofocus: true, onclick: () => made.close("") }, "No"),
      ),
    );
    opened(made).addEventListener("close", () => resolve(made.returnValue === "yes"));
  });
}
