// What is calculated: the kind of forward model and its section, as its JSON schema has it.
import { announce, element, exchange, failure } from "../dom.js";
import { get } from "../http.js";
import { clone } from "./draft.js";
import { errorPlace } from "./fields.js";
import { button, objectForm, sentence } from "./schema_form.js";
import { words } from "./schema.js";

/** Draws the section into `place`; `kinds` are the forward models of the service. */
export function modelSection(context, place, kinds) {
  const { draft, schemas, root } = context;
  const kind = () => draft.read(["forward_model", "kind"]);
  const form = element("div", {});

  function choose(chosen) {
    const old = draft.read(["forward_model"]) ?? {};
    const known = sectionSchema(chosen)?.properties ?? {};
    const left = Object.fromEntries(Object.entries(old).filter(([key]) => key in known && key !== "kind"));
    draft.write(["forward_model"], { kind: chosen, ...left });
    draw();
  }

  function sectionSchema(chosen) {
    const definition = root.$defs[`forward_model_${chosen}`];
    return definition && schemas.resolve(definition);
  }

  async function useExample() {
    const { changes } = draft;
    try {
      const { example } = await get(`/forward-models/${encodeURIComponent(kind())}`);
      if (!example) return announce("This forward model has no example.");
      if (draft.changes !== changes) return announce("The form has changed meanwhile, so the example was left out.");
      draft.write(["forward_model"], clone(example));
      draw();
    } catch (error) {
      form.prepend(failure(error));
    }
  }

  function draw() {
    const chosen = kind();
    const schema = chosen && sectionSchema(chosen);
    exchange(form, schema
      ? [
        schema.description ? element("p", { class: "help" }, sentence(schema.description)) : null,
        chosen === "oedometer" || chosen === "isotropic_compression" ? null : element("div", { class: "buttons" }, button("Fill in a small example", useExample)),
        objectForm(context, ["forward_model"], schema, { skip: ["kind"] }),
      ]
      : element("p", { class: "empty" }, "Choose what is calculated."));
  }

  const choices = kinds.map(({ kind: one, description }) => {
    const input = element("input", { type: "radio", name: "kind", value: one, checked: one === kind(), onchange: () => choose(one) });
    return element("label", { class: "choice" }, input, element("span", {}, element("strong", {}, words(one)), element("small", {}, description)));
  });
  place.replaceChildren(
    element("fieldset", { class: "choices" }, element("legend", {}, "Forward model"), choices),
    errorPlace(["forward_model"]), form);
  draft.on("replace", () => {
    for (const input of place.querySelectorAll("input[name=kind]")) input.checked = input.value === kind();
    draw();
  });
  draw();
}
