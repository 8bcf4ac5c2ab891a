// The form of a new job: sections of one draft, which the service judges after every change.
import { announce, element, failure } from "./dom.js";
import { age } from "./format.js";
import { get } from "./http.js";
import { translate } from "./language.js";
import { checkSection } from "./new/check.js";
import { createDraft, forget, kept } from "./new/draft.js";
import { errorPlace, field, showIssues } from "./new/fields.js";
import { methodSection } from "./new/method.js";
import { modelSection } from "./new/model.js";
import { observationsSection } from "./new/observations.js";
import { parametersSection } from "./new/parameters.js";
import { rail } from "./new/rail.js";
import { reader, words } from "./new/schema.js";
import { sketchPanel } from "./new/sketch.js";
import { undoBar } from "./new/undo.js";
import { yamlPanel } from "./new/yaml.js";
import { messageOf } from "./new/words.js";

const EMPTY = {
  name: "calibration",
  method: { kind: "particle_swarm" },
  stopping: { max_evaluations: 600, stagnation_generations: 25 },
};

const main = document.querySelector("main");
const content = document.getElementById("content");

async function open() {
  const asked = [get("/problems/schema"), get("/forward-models"), get("/examples"), get("/jobs", { limit: 50 })];
  const [root, models, examples, jobs] = await Promise.all(asked);
  const schemas = reader(root);
  const draft = createDraft();
  draft.document = await beginning(root, schemas);
  const context = { draft, root, schemas, begun: () => something(draft.document) };
  let strict = false;
  content.replaceChildren(
    form(
      context,
      models.items,
      starting(draft, examples.items, jobs.items),
      () => strict,
      async () => {
        strict = true;
        return draft.judge();
      },
    ),
  );
  draft.on("answer", ({ issues }) =>
    showIssues(
      content,
      issues.map((one) => ({ ...one, message: messageOf(one) })),
      strict,
    ),
  );
  await draft.judge();
}

/** What the address names, else what this tab has kept, else an empty problem. */
async function beginning(root, schemas) {
  if (main.dataset.from) return tidy(await get(`/jobs/${main.dataset.from}/problem`), root, schemas);
  if (main.dataset.example) return (await get(`/examples/${encodeURIComponent(main.dataset.example)}`)).problem;
  const old = kept();
  if (old) announce("This is where you left off. “Start over” clears the form.");
  return old ?? structuredClone(EMPTY);
}

/** A stored problem without the defaults that the service has written out. */
function tidy(problem, root, schemas) {
  const kind = problem.forward_model?.kind;
  const section = root.$defs[`forward_model_${kind}`];
  const { forward_model: model, ...rest } = problem;
  const left = {
    ...schemas.pruned(rest, { ...root, required: ["name", "parameters", "observations", "method", "stopping"] }),
    forward_model: section ? schemas.pruned(model, section) : model,
  };
  left.name = `${problem.name} again`.slice(0, 200);
  delete left.seed;
  return left;
}

function form(context, kinds, beginnings, strict, judged) {
  const { draft } = context;
  const places = Object.fromEntries(
    ["model", "measurements", "parameters", "method", "check", "yaml"].map((name) => [
      name,
      element("div", { id: `${name}-body` }),
    ]),
  );
  const section = (id, title, ...inside) =>
    element(
      "section",
      { class: "step", "aria-labelledby": `${id}-title` },
      element("h2", { id: `${id}-title` }, title),
      inside,
    );
  const name = element("div", {});
  const drawName = () => name.replaceChildren(field(draft, ["name"], { label: "Name of the job", wide: true }));
  drawName();
  draft.on("replace", drawName);
  modelSection(context, places.model, kinds);
  observationsSection(context, places.measurements);
  parametersSection(context, places.parameters);
  methodSection(context, places.method);
  yamlPanel(context, places.yaml, strict);
  const beside = element("div", {}),
    inside = element("div", {});
  sketchPanel(context, beside, inside);
  checkSection(context, places.check, judged);
  return element(
    "div",
    { class: "new-job" },
    undoBar(context),
    element(
      "div",
      { class: "steps" },
      beginnings,
      rail(context),
      element(
        "fieldset",
        { class: "held" },
        name,
        section("model", "1. Forward model", inside, places.model),
        section("measurements", "2. Measurements", places.measurements),
        section("parameters", "3. Parameters", places.parameters),
        section("method", "4. Method and stopping", places.method),
        section("go", "5. Check and start", places.check, errorPlace([])),
      ),
    ),
    element(
      "aside",
      { id: "yaml-panel", "aria-label": "Sketch and YAML of the problem" },
      beside,
      element("fieldset", { class: "held" }, places.yaml),
    ),
  );
}

/** Whether there is anything to lose. */
const something = (document) => JSON.stringify(document) !== JSON.stringify(EMPTY);

/** While an example is on its way nothing can be written: it would be overwritten. */
function hold(on) {
  for (const held of content.querySelectorAll(".held")) held.disabled = on;
}

/** Examples and earlier jobs to begin with, and an empty form. */
function starting(draft, examples, jobs) {
  const pick = element(
    "select",
    { id: "example" },
    element("option", { value: "" }, "choose …"),
    examples.map((one) => element("option", { value: one.name }, `${one.title} (${words(one.forward_model)})`)),
  );
  const about = element(
    "p",
    { class: "help", id: "example-help" },
    "Examples come with their data and can be started as they are.",
  );
  const place = element("div", {});
  pick.addEventListener("change", async () => {
    const chosen = pick.value;
    hold(Boolean(chosen)); // what is typed meanwhile would be lost
    if (!chosen) return;
    try {
      const example = await get(`/examples/${encodeURIComponent(chosen)}`);
      if (pick.value !== chosen) return; // another choice since
      about.textContent = example.description;
      place.replaceChildren();
      const back = draft.mark();
      const begun = something(draft.document);
      draft.replace(example.problem);
      if (begun) back(`The example “${example.title}” has replaced what was here.`);
    } catch (error) {
      if (pick.value === chosen) place.replaceChildren(failure(error));
    } finally {
      if (pick.value === chosen) hold(false);
    }
  });
  const startAnew = () => {
    forget();
    pick.value = "";
    hold(false);
    const back = draft.mark();
    const begun = something(draft.document);
    draft.replace(structuredClone(EMPTY));
    if (begun) back("The form was cleared.");
  };
  const anew = element("button", { type: "button", class: "quiet", onclick: startAnew }, "Start over");
  const earlier = element(
    "select",
    { id: "earlier" },
    element("option", { value: "" }, "choose …"),
    jobs.map((one) =>
      element(
        "option",
        { value: one.id, selected: one.id === main.dataset.from, translate: "no" },
        `${one.name} (${translate(one.state)}, ${translate(age(one.created_at))})`,
      ),
    ),
  );
  earlier.addEventListener("change", () => {
    if (earlier.value) location.assign(`/new?from=${earlier.value}`);
  });
  const file = element(
    "button",
    { type: "button", class: "quiet", onclick: () => document.getElementById("file").click() },
    "Choose an AGS 4 file",
  );
  return element(
    "div",
    { class: "beginning" },
    element(
      "div",
      { class: "fields" },
      element("div", { class: "field" }, element("label", { for: "example" }, "Start from an example"), pick),
      jobs.length
        ? element("div", { class: "field" }, element("label", { for: "earlier" }, "or with an earlier job"), earlier)
        : null,
      element(
        "div",
        { class: "field", role: "group", "aria-label": "or with tests of a laboratory" },
        element("span", { class: "label" }, "or with tests of a laboratory"),
        file,
      ),
    ),
    element("div", { class: "with-unit" }, about, anew),
    place,
  );
}

open().catch((error) => content.replaceChildren(failure(error)));
