// What a JSON schema says, in the few shapes that forms know.

/** Reads one schema document; `root` holds the definitions. */
export function reader(root) {
  /** The schema behind references, with what stands beside them. */
  function resolve(schema) {
    if (!schema?.$ref) return schema ?? {};
    const { $ref, ...beside } = schema;
    return { ...resolve(root.$defs[$ref.replace("#/$defs/", "")]), ...beside };
  }

  /** A schema without the possibility of null, and whether there was one. */
  function present(given) {
    const schema = resolve(given);
    const choices = schema.anyOf ?? schema.oneOf;
    if (!choices) return { schema, nullable: schema.type === "null" };
    const left = choices.map(resolve).filter((one) => one.type !== "null");
    const { anyOf, oneOf, ...beside } = schema;
    const single =
      left.length === 1 ? { ...left[0], ...beside, title: left[0].title ?? beside.title } : { ...beside, anyOf: left };
    return { schema: single, nullable: left.length < choices.length };
  }

  const scalar = (schema) => ["number", "integer", "string"].includes(schema.type) && !schema.enum;

  /** The key whose constant distinguishes the objects of a union. */
  function tag(choices) {
    const keys = Object.keys(choices[0]?.properties ?? {});
    return keys.find((key) => choices.every((one) => one.properties?.[key] && "const" in resolve(one.properties[key])));
  }

  /** number, text, mixed, choice, flag, constant, numbers, texts, table, list, object, map, union, alternatives, any */
  function shape(schema) {
    if ("const" in schema) return "constant";
    if (schema.enum) return "choice";
    if (schema.anyOf) {
      if (schema.anyOf.every(scalar)) return "mixed";
      if (schema.anyOf.every((one) => scalar(one) || "const" in one || one.enum)) return "mixed";
      return tag(schema.anyOf) ? "union" : "alternatives";
    }
    switch (schema.type) {
      case "number":
      case "integer":
        return "number";
      case "string":
        return "text";
      case "boolean":
        return "flag";
      case "array":
        return arrayShape(schema);
      case "object":
        return schema.properties ? "object" : inner(schema) ? "map" : "any";
      default:
        return "any";
    }
  }

  function arrayShape(schema) {
    if (!schema.items) return "any";
    const item = present(schema.items).schema;
    const kind = shape(item);
    if (kind === "number") return "numbers";
    if (kind === "text") return "texts";
    if (kind === "object") {
      const flat = Object.values(item.properties).every((one) =>
        ["number", "text", "mixed", "choice"].includes(shape(present(one).schema)),
      );
      return flat && Object.keys(item.properties).length <= 4 ? "table" : "list";
    }
    return kind === "union" ? "list" : "any";
  }

  /** Schema of the values of a map. */
  function inner(schema) {
    if (schema.patternProperties) return Object.values(schema.patternProperties)[0];
    return typeof schema.additionalProperties === "object" ? schema.additionalProperties : null;
  }

  /** A value without what holds anyway. */
  function pruned(value, given) {
    let { schema } = present(given);
    if (schema.anyOf && value && typeof value === "object") {
      const key = tag(schema.anyOf);
      schema = key
        ? (schema.anyOf.find((one) => resolve(one.properties[key]).const === value[key]) ?? {})
        : (schema.anyOf.find((one) => (one.type === "array") === Array.isArray(value) && one.type !== "string") ?? {});
    }
    if (Array.isArray(value)) return schema.items ? value.map((one) => pruned(one, schema.items)) : value;
    if (!value || typeof value !== "object") return value;
    const required = new Set(schema.required ?? []);
    const left = {};
    for (const [key, one] of Object.entries(value)) {
      const known = schema.properties?.[key];
      const constant = known && "const" in resolve(known);
      if (known && !required.has(key) && !constant && "default" in resolve(known) && same(one, resolve(known).default))
        continue;
      const below = known ?? inner(schema);
      left[key] = below ? pruned(one, below) : one;
    }
    return left;
  }
  /** Whether a value has the form that a schema wants: a number where one is wanted, entries with keys that it knows. */
  function fits(value, given) {
    const { schema, nullable } = present(given);
    if (value === null) return nullable;
    if (schema.anyOf) return schema.anyOf.some((one) => fits(value, one));
    if ("const" in schema) return value === schema.const;
    if (schema.enum) return schema.enum.includes(value);
    if (Array.isArray(value))
      return schema.type === "array" && (!schema.items || value.every((one) => fits(one, schema.items)));
    if (typeof value !== "object") return !["array", "object"].includes(schema.type);
    if (schema.type === "array") return false;
    const known = schema.properties;
    return (
      !known ||
      Object.entries(value).every(([key, one]) => (known[key] ? fits(one, known[key]) : Boolean(inner(schema))))
    );
  }
  return { resolve, present, shape, tag, inner, pruned, fits };
}

const same = (one, other) => JSON.stringify(one) === JSON.stringify(other);

/** A key for readers: initial_stress is "initial stress". */
export const words = (key) => key.replaceAll("_", " ");
