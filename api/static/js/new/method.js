// How to search and when to stop; the defaults are good.
import { element } from "../dom.js";
import { errorPlace, field } from "./fields.js";
import { anyField, objectForm, sentence } from "./schema_form.js";

export function methodSection(context, place) {
  const { draft, schemas, root } = context;

  function draw() {
    const { method, stopping, seed, priority, limits, failures, warm_start: earlier } = root.properties;
    const whole = schemas.present(method).schema;
    const kindOf = (one) => schemas.resolve(one.properties.kind).const;
    const needsOptimum = (one) => (schemas.resolve(one).required ?? []).includes("at"); // a follow-up of another job
    const chosen = draft.read(["method", "kind"]);
    const offered = {
      ...whole,
      description: "",
      anyOf: whole.anyOf.filter((one) => !needsOptimum(one) || kindOf(one) === chosen),
    };
    place.replaceChildren(
      anyField(context, ["method"], offered, {
        label: "Method",
        required: true,
        lead: ["particles", "acceleration", "sampling"],
      }),
      element(
        "fieldset",
        { class: "group" },
        element("legend", {}, "Stopping"),
        element("p", { class: "help" }, "The job ends with the first of these that is satisfied."),
        objectForm(context, ["stopping"], schemas.resolve(stopping)),
        errorPlace(["stopping"]),
      ),
      element(
        "details",
        { class: "more" },
        element("summary", {}, "More: seed, priority, earlier jobs, limits, failures"),
        element(
          "div",
          { class: "fields" },
          field(draft, ["seed"], { label: "Seed", kind: "number", help: sentence(schemas.resolve(seed).description) }),
          anyField(context, ["priority"], priority, { label: "Priority" }),
        ),
        anyField(context, ["warm_start"], earlier, { label: "Earlier jobs to learn from" }),
        anyField(context, ["limits"], limits, { label: "Limits" }),
        anyField(context, ["failures"], failures, { label: "Failures" }),
      ),
    );
  }
  draft.on("replace", draw);
  draw();
}
