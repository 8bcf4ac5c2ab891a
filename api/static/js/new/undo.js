// The way back from what replaces a part of the problem: said in words, with a button, until the next such step.
import { element } from "../dom.js";

export function undoBar(context) {
  const { draft } = context;
  const place = element("div", { class: "undo", role: "status", hidden: true });
  const hide = () => {
    place.hidden = true;
    place.replaceChildren();
  };
  draft.on("undo", ({ words, restore }) => {
    const back = () => {
      hide();
      restore();
    };
    place.replaceChildren(
      element("span", {}, words),
      element("button", { type: "button", id: "undo", onclick: back }, "Undo"),
      element("button", { type: "button", class: "quiet", "aria-label": "Close this message", onclick: hide }, "×"),
    );
    place.hidden = false;
  });
  return place;
}
