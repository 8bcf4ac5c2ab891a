// A form for a part of the draft, made from its JSON schema.
import { element, exchange } from "../dom.js";
import { clone, pathText } from "./draft.js";
import { checkbox, errorPlace, field, idOf } from "./fields.js";
import { table } from "./table.js";
import { words } from "./schema.js";
import { labelOf } from "./words.js";

/**
 * The inputs of an object: needed ones first, the others folded away. `skip` names keys that are left out, `lead` optional
 * ones that are shown at once, as are those that say so (x-shown); `change` is called after what alters the form itself.
 */
export function objectForm(context, path, schema, { skip = [], lead = [], change } = {}) {
  const { schemas } = context;
  const required = new Set(schema.required ?? []);
  const entries = Object.entries(schema.properties).filter(
    ([key, one]) => !skip.includes(key) && !("const" in schemas.resolve(one)),
  );
  const first = entries.filter(([key, one]) => required.has(key) || lead.includes(key) || one["x-shown"]);
  const more = entries.filter((one) => !first.includes(one));
  const made = ([key, one]) =>
    anyField(context, [...path, key], one, { label: labelOf(key), required: required.has(key), change });
  const given = more.some(([key]) => context.draft.read([...path, key]) !== undefined);
  const visible = first.length === 0;
  return element(
    "div",
    { class: "fields" },
    first.map(made),
    visible
      ? more.map(made)
      : more.length
        ? element(
            "details",
            { class: "more", open: given && more.length <= 6 },
            element(
              "summary",
              {},
              `More: ${more
                .slice(0, 4)
                .map(([key]) => words(key))
                .join(", ")}${more.length > 4 ? " …" : ""}`,
            ),
            element("div", { class: "fields" }, more.map(made)),
          )
        : null,
  );
}

/** The input or inputs of anything. */
export function anyField(context, path, given, { label, required = false, bare = false, change, lead } = {}) {
  const { draft, schemas } = context;
  const { schema, nullable } = schemas.present(given);
  const kind = schemas.shape(schema);
  const about = {
    label,
    required,
    bare,
    nullable,
    help: sentence(schema.description),
    unit: schema["x-unit"],
    typical: schema["x-typical"],
    fallback: required ? undefined : schema.default,
    onchange: change && (() => change()),
  };
  switch (kind) {
    case "number":
    case "text":
    case "mixed":
    case "numbers":
    case "texts":
      return field(draft, path, { ...about, kind, wide: kind === "numbers" || kind === "texts" });
    case "choice": {
      const options = schema.enum.map((one) => [one, words(String(one))]);
      return field(draft, path, {
        ...about,
        kind: "select",
        options: nullable && schema.default === null ? [[null, "none"], ...options] : options,
      });
    }
    case "flag":
      return checkbox(draft, path, { ...about, fallback: schema.default ?? false });
    case "table":
      return table(context, path, schema, about);
    case "object":
    case "list":
    case "map":
    case "union":
    case "alternatives":
      return group(context, path, schema, { ...about, kind, nullable, lead, optional: !required });
    default:
      return field(draft, path, {
        ...about,
        kind: "json",
        wide: true,
        help: `${about.help ?? ""} Written as JSON.`.trim(),
      });
  }
}

export function sentence(text) {
  if (!text) return null;
  const plain = text.split("\n\n")[0].replaceAll("``", "").replaceAll("\n", " ");
  return (/^\w\b/.test(plain) ? plain[0] : plain[0].toUpperCase()) + plain.slice(1) + (/[.!?]$/.test(plain) ? "" : ".");
}

const FORMS = { object: objectBody, list: listBody, map: mapBody, union: unionBody, alternatives: alternativesBody };

/** A frame around what has parts; it draws itself again when they come and go. */
function group(context, path, schema, { label, help, kind, optional, change, lead }) {
  const { draft } = context;
  const body = element("div", {});
  const draw = () => {
    const absent = draft.read(path) === undefined || draft.read(path) === null;
    const add = element(
      "button",
      { type: "button", class: "quiet", id: `${idOf(path)}-give`, onclick: () => set(kind === "list" ? [] : {}) },
      `Set ${small(label)}`,
    );
    const drop = element(
      "button",
      { type: "button", class: "quiet", onclick: () => set(undefined) },
      `Leave out ${small(label)}`,
    );
    exchange(
      body,
      kind === "object" && optional && absent
        ? add
        : [FORMS[kind](context, path, schema, draw, lead), kind === "object" && optional ? drop : null],
    );
  };
  const set = (value) => {
    draft.write(path, value);
    draw();
    change?.();
  };
  draw();
  return element(
    "fieldset",
    { class: "group" },
    element("legend", {}, label),
    help ? element("p", { class: "help" }, help) : null,
    body,
    errorPlace(path),
  );
}

const small = (label) => (/^[A-Z][a-z]/.test(label) ? label[0].toLowerCase() + label.slice(1) : label);

function objectBody(context, path, schema) {
  return objectForm(context, path, schema);
}

function listBody(context, path, schema, draw) {
  const { draft } = context;
  const items = draft.read(path) ?? [];
  return [
    items.map((_, i) =>
      element(
        "details",
        { class: "item", open: items.length <= 3 || !Object.keys(items[i] ?? {}).length },
        element("summary", {}, `${i + 1}. ${title(items[i])}`),
        anyField(
          context,
          [...path, i],
          { ...context.schemas.present(schema.items).schema, description: "" },
          { label: title(items[i]) || `entry ${i + 1}`, required: true },
        ),
        button(`Remove ${i + 1}`, () => {
          draft.write([...path, i], undefined);
          draw();
        }),
      ),
    ),
    button("Add an entry", () => {
      draft.write([...path, items.length], {});
      draw();
    }),
  ];
}

const title = (item) => item?.name ?? item?.kind ?? "";

function mapBody(context, path, schema, draw) {
  const { draft } = context;
  const entries = draft.read(path) ?? {};
  const id = `${idOf(path)}-name`;
  const name = element("input", { type: "text", id, spellcheck: "false", autocomplete: "off" });
  const add = () => {
    const key = name.value.trim();
    if (!key || key in entries) return name.focus();
    draft.write([...path, key], starting(context, schema));
    draw();
  };
  name.addEventListener("keydown", (event) => {
    if (event.key === "Enter") {
      event.preventDefault();
      add();
    }
  });
  return [
    Object.keys(entries).map((key) =>
      element(
        "div",
        { class: "item" },
        anyField(
          context,
          [...path, key],
          { ...context.schemas.present(context.schemas.inner(schema)).schema, description: "" },
          { label: key, required: true },
        ),
        button(`Remove ${key}`, () => {
          draft.write([...path, key], undefined);
          draw();
        }),
      ),
    ),
    element("div", { class: "buttons" }, element("label", { for: id }, "Name"), name, button("Add", add)),
  ];
}

/** What a new entry of a map holds. */
function starting(context, schema) {
  const item = context.schemas.present(context.schemas.inner(schema)).schema;
  if (item.anyOf && !context.schemas.tag(item.anyOf) && item.anyOf.some((one) => one.type === "object")) return {};
  return ["mixed", "text", "number"].includes(context.schemas.shape(item)) ? "" : {};
}

function unionBody(context, path, schema, draw, lead) {
  const { draft, schemas } = context;
  const key = schemas.tag(schema.anyOf);
  const names = schema.anyOf.map((one) => schemas.resolve(one.properties[key]).const);
  const chosen = draft.read([...path, key]);
  const id = `${idOf(path)}-${key}-choice`;
  const pick = element(
    "select",
    { id, dataset: { path: pathText([...path, key]) } },
    names.includes(chosen) ? null : element("option", { value: "", selected: true }, "choose …"),
    names.map((one) => element("option", { value: one, selected: one === chosen }, words(one))),
  );
  pick.addEventListener("change", () => {
    const old = draft.read(path) ?? {};
    const next = schema.anyOf[names.indexOf(pick.value)];
    const keep = Object.fromEntries(Object.entries(old).filter(([name]) => name in next.properties));
    draft.write(path, { ...keep, [key]: pick.value });
    draw();
  });
  const one = schema.anyOf[names.indexOf(chosen)];
  return [
    element("div", { class: "field" }, element("label", { for: id }, labelOf(key)), pick, errorPlace([...path, key])),
    one ? objectForm(context, path, one, { lead }) : null,
  ];
}

function alternativesBody(context, path, schema, draw) {
  const { draft } = context;
  const value = draft.read(path);
  const fits = (one) =>
    one.type === "array"
      ? Array.isArray(value)
      : one.type === "object" || one.anyOf
        ? value && typeof value === "object" && !Array.isArray(value)
        : typeof value !== "object";
  const chosen = Math.max(0, schema.anyOf.findIndex(fits));
  const id = `${idOf(path)}-form`;
  const names = schema.anyOf.map(
    (one) =>
      ({ string: "as an expression", number: "as a number", array: "as a list", object: "in full" })[one.type] ??
      "in full",
  );
  const pick = element(
    "select",
    { id },
    names.map((name, i) => element("option", { value: String(i), selected: i === chosen }, name)),
  );
  pick.addEventListener("change", () => {
    const next = schema.anyOf[Number(pick.value)];
    const starts = {
      array: [],
      object: typeof value === "string" && next.properties?.expression ? { expression: value } : {},
    };
    draft.write(path, clone(starts[next.type]) ?? (next.anyOf ? {} : (value?.expression ?? "")));
    draw();
  });
  const one = schema.anyOf[chosen];
  return [
    element("div", { class: "field" }, element("label", { for: id }, "Given"), pick),
    one.type === "object" && one.properties
      ? objectForm(context, path, one, { lead: ["x_unit", "y_unit"] })
      : anyField(context, path, { ...one, description: schema.description }, { label: "value", required: true }),
  ];
}

export function button(text, act, properties = {}) {
  return element("button", { type: "button", class: "quiet", onclick: act, ...properties }, text);
}
