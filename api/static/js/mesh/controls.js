// What of the body is shown: quantity, deformation, period, evaluation.
import { element } from "../dom.js";
import { number } from "../format.js";

const QUANTITIES = [
  ["regions", "regions"],
  ["size", "displacement"],
  ["ux", "horizontal displacement"],
  ["uy", "vertical displacement"],
  ["shear", "shear strain"],
];
const BEGINNING = "";

/** Fills `holder`; `onLook()` after a change of the picture, `onPeriod()` of the phases, `onEvaluation(query)` of the evaluation. */
export function controls(holder, mesh, { onLook, onPeriod, onEvaluation }) {
  const choice = (options, chosen, act) => {
    const made = element(
      "select",
      { onchange: act },
      options.map(([value, text]) => element("option", { value }, text)),
    );
    made.value = chosen;
    return made;
  };
  const days = (end) => (end === null || end === 0 ? "" : `, day ${number(end, 6)}`);
  const phases = mesh.phases.map(({ name, end }) => [name, `the end of ${name}${days(end)}`]);
  const quantity = choice(QUANTITIES, "regions", onLook);
  const start = choice([[BEGINNING, "the beginning"], ...phases.slice(0, -1)], mesh.start ?? BEGINNING, onPeriod);
  const end = choice(phases, mesh.end, onPeriod);
  const slider = element("input", {
    type: "range",
    min: 0,
    max: 1000,
    value: "0",
    disabled: true,
    "aria-label": "Deformation scale",
  });
  const exact = element("input", {
    type: "number",
    min: 0,
    step: "any",
    value: "0",
    disabled: true,
    "aria-label": "Deformation scale as a number",
  });
  const most = element("small", { role: "status" });
  let largest = 3,
    limit = Infinity,
    touched = false;
  const place = () => {
    slider.value = String((1000 * Number(exact.value)) / largest);
  };
  slider.addEventListener("input", () => {
    touched = true;
    exact.value = String(Number(((largest * Number(slider.value)) / 1000).toPrecision(3)));
    onLook();
  });
  exact.addEventListener("change", () => {
    touched = true;
    keep();
    onLook();
  });
  /** What would turn a triangle inside out is not drawn. */
  function keep() {
    const over = Number(exact.value) > limit;
    if (over) exact.value = String(Number(limit.toPrecision(2)));
    most.textContent = over ? ` At most ${number(limit, 2)}: beyond, triangles turn inside out.` : "";
    place();
  }
  const tick = (text, checked) => {
    const input = element("input", { type: "checkbox", checked, onchange: onLook });
    return { input, line: element("label", {}, input, text) };
  };
  const [lines, outline, vectors, points] = [
    tick("mesh", true),
    tick("undeformed outline", true),
    tick("vectors", mesh.vectors.length > 0),
    tick("points", true),
  ];
  const particle = element("input", { type: "number", min: 0, value: mesh.particle ?? "" });
  const generation = element("input", { type: "number", min: 0, value: mesh.generation ?? "" });
  const part =
    mesh.parts.length > 1
      ? choice(
          mesh.parts.map((name) => [name, name]),
          mesh.part,
          () => asked(),
        )
      : null;
  const own = () => (part ? { part: part.value } : {});
  const asked = () =>
    onEvaluation({
      ...own(),
      ...(generation.value !== "" && particle.value !== ""
        ? { generation: generation.value, particle: particle.value }
        : {}),
    });
  const field = (text, input) => {
    input.id = `control-${text.replace(/\W/g, "-").toLowerCase()}`;
    return element("div", { class: "field" }, element("label", { for: input.id }, text), input);
  };
  holder.replaceChildren(
    ...[
      part ? field("Part", part) : null,
      field("Show", quantity),
      field("Displacements from", start),
      field("to", end),
      element(
        "fieldset",
        {},
        element("legend", {}, "Deformation scale"),
        element("span", {}, slider, " ", exact, most),
      ),
      element(
        "fieldset",
        {},
        element("legend", {}, "With"),
        element("span", {}, lines.line, outline.line, vectors.line, points.line),
      ),
      field("Generation", generation),
      field("Particle", particle),
      element("button", { type: "button", class: "quiet", onclick: asked }, "Show this evaluation"),
      element("button", { type: "button", class: "quiet", onclick: () => onEvaluation(own()) }, "Best"),
    ].filter(Boolean),
  );
  return {
    look: () => ({
      quantity: quantity.value,
      factor: Number(exact.value) || 0,
      lines: lines.input.checked,
      outline: outline.input.checked,
      vectors: vectors.input.checked,
      points: points.input.checked,
    }),
    period: () => ({ start: start.value === BEGINNING ? null : start.value, end: end.value }),
    /** Displacements are there: the slider runs to three times what shows them well, and not beyond the limit. */
    ready: (factor, beyond) => {
      limit = beyond;
      largest = Math.min(3 * factor, limit);
      slider.disabled = exact.disabled = false;
      if (!touched) exact.value = String(factor);
      keep();
    },
  };
}
