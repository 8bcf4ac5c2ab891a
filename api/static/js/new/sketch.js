// What is calculated as a picture: the specimen or the ground and its loading programme, drawn by the service.
import { element } from "../dom.js";

const BESIDE = matchMedia("(min-width: 70rem)"); // as in new.css

/** Draws into the first of two places on a wide page, beside the form, else into the second, in it. */
export function sketchPanel(context, beside, inside) {
  const drawings = element("div", { class: "sketches" });
  const panel = element(
    "section",
    { id: "sketch", "aria-label": "Sketch of the forward model", hidden: true },
    drawings,
  );
  const settle = () => (BESIDE.matches ? beside : inside).append(panel);
  let shown = null,
    kind = null;

  BESIDE.addEventListener("change", settle);
  settle();
  context.draft.on("change", follow);
  context.draft.on("answer", ({ sketches }) => {
    follow(); // YAML may have changed it
    drawings.classList.toggle("old", sketches === null);
    if (sketches === null || JSON.stringify(sketches) === shown) return;
    shown = JSON.stringify(sketches);
    panel.hidden = sketches.length === 0;
    drawings.replaceChildren(...sketches.map(drawn));
  });

  /** What was drawn of another forward model goes. */
  function follow() {
    const now = context.draft.read(["forward_model", "kind"]) ?? null;
    if (now === kind) return;
    kind = now;
    shown = null;
    panel.hidden = true;
    drawings.replaceChildren();
  }
}

function drawn({ part, heading, words, svg }) {
  const made = document.importNode(new DOMParser().parseFromString(svg, "image/svg+xml").documentElement, true);
  return element(
    "figure",
    {},
    element("h3", {}, part ? `${heading} (${part})` : heading),
    made,
    element("figcaption", { "aria-hidden": "true" }, words),
  ); // the picture has the same as its label
}
