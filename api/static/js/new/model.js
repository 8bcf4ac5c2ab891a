// What is calculated: the kind of forward model and its section, as its JSON schema has it.
import { announce, element, exchange, failure } from "../dom.js";
import { get } from "../http.js";
import { clone } from "./draft.js";
import { errorPlace } from "./fields.js";
import { button, objectForm, sentence } from "./schema_form.js";
import { words } from "./schema.js";
import { labelOf } from "./words.js";

/** Draws the section into `place`; `kinds` are the forward models of the service. */
export function modelSection(context, place, kinds) {
  const { draft, schemas, root } = context;
  const kind = () => draft.read(["forward_model", "kind"]);
  const model = () => draft.read(["forward_model", "model"]);
  const form = element("div", {});
  const earlier = new Map(); // sections that were left, by kind: restored when the kind is chosen again

  function choose({ kind: chosen, model: registered }) {
    const old = draft.read(["forward_model"]) ?? {};
    const known = sectionSchema(chosen, registered)?.properties ?? {};
    const fits = ([key, value]) =>
      key in known && !["kind", "model", "settings"].includes(key) && schemas.fits(value, known[key]);
    const left = Object.fromEntries(Object.entries(old).filter(fits));
    const lost = Object.keys(old).filter((key) => !(key in left) && !["kind", "model"].includes(key));
    const before = clone(earlier.get(registered ?? chosen) ?? {});
    if (old.kind) earlier.set(old.model ?? old.kind, clone(old));
    const back = draft.mark();
    draft.write(["forward_model"], { kind: chosen, ...(registered ? { model: registered } : {}), ...before, ...left });
    if (lost.length)
      back(
        `${words(registered ?? chosen)} instead of ${words(old.model ?? old.kind)}: ${lost.map(words).join(", ")} did not fit and ${lost.length === 1 ? "was" : "were"} removed.`,
      );
    draw();
  }

  /** A registered model has a schema of its own. */
  function sectionSchema(chosen, registered) {
    const definition = root.$defs[`forward_model_${chosen}${registered ? `_${registered}` : ""}`];
    return definition && schemas.resolve(definition);
  }

  async function useExample() {
    const { changes } = draft;
    try {
      const { example } = await get(`/forward-models/${encodeURIComponent(kind())}`);
      if (!example) return announce("This forward model has no example.");
      if (draft.changes !== changes) return announce("The form has changed meanwhile, so the example was left out.");
      const old = draft.read(["forward_model"]);
      const back = draft.mark();
      draft.write(["forward_model"], clone(example));
      if (Object.keys(old).length > 1) back("The small example has replaced the section of the forward model.");
      draw();
    } catch (error) {
      form.prepend(failure(error));
    }
  }

  function draw() {
    const chosen = kind();
    const schema = chosen && sectionSchema(chosen, chosen === "registered" ? model() : null);
    const hasExample = !["oedometer", "isotropic_compression", "registered"].includes(chosen);
    exchange(
      form,
      schema
        ? [
            schema.description ? element("p", { class: "help" }, sentence(schema.description)) : null,
            hasExample ? element("div", { class: "buttons" }, button("Fill in a small example", useExample)) : null,
            objectForm(context, ["forward_model"], schema, {
              skip: ["kind", "model", "version", "declared"],
              lead: ["settings"],
            }),
          ]
        : element("p", { class: "empty" }, "Choose what is calculated."),
    );
  }

  const isChosen = (one) => one.kind === kind() && (!one.model || one.model === model());
  const inputs = kinds.map((one) =>
    element("input", {
      type: "radio",
      name: "kind",
      value: one.model ?? one.kind,
      checked: isChosen(one),
      onchange: () => choose(one),
    }),
  );
  const choices = kinds.map((one, i) =>
    element(
      "label",
      { class: "choice" },
      inputs[i],
      element(
        "span",
        {},
        element("strong", {}, one.model ?? labelOf(one.kind)),
        element("small", {}, one.model ? `Registered: ${one.description}` : one.description),
      ),
    ),
  );
  place.replaceChildren(
    element("fieldset", { class: "choices" }, element("legend", {}, "Forward model"), choices),
    errorPlace(["forward_model"]),
    form,
  );
  draft.on("replace", () => {
    kinds.forEach((one, i) => {
      inputs[i].checked = isChosen(one);
    });
    draw();
  });
  draw();
}
