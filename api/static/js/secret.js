// A secret that is shown once, with a button that copies it.
import { announce, element } from "./dom.js";

/** What a dialog shows of a new key or link. */
export function shownOnce(secret) {
  return [
    element("p", { class: "new-key" }, element("code", {}, secret)),
    element("p", {}, "It is shown only once: copy it before you close this."),
    element("div", { class: "buttons" }, element("button", { type: "button", onclick: () => copied(secret) }, "Copy")),
  ];
}

async function copied(secret) {
  try {
    await navigator.clipboard.writeText(secret);
    announce("Copied.");
  } catch {
    announce("The browser does not allow copying: select the text and copy it yourself.");
  }
}
