// What readings and index properties let expect of a parameter, beside its bounds.
import { element } from "../dom.js";
import { number } from "../format.js";
import { anyField } from "./schema_form.js";

const MOST = 10;

/** The section of index properties, redrawn for another draft. */
export function indexProperties(context) {
  const place = element("div", { id: "index-properties" });
  const schema = context.root.properties?.index_properties;
  if (!schema) return place;
  const draw = () =>
    place.replaceChildren(anyField(context, ["index_properties"], schema, { label: "Index properties" }));
  draw();
  context.draft.on("replace", draw);
  return place;
}

/** Where the values that a parameter may have appear; hidden while there are none. */
export function expectedPlace(name) {
  return element("details", { class: "expected", hidden: true, dataset: { expected: name } });
}

/** Show at all such places what the service has found: the range at once, the values unfolded. */
export function showExpected(root, estimates) {
  for (const place of root.querySelectorAll("[data-expected]")) {
    const found = estimates.filter((one) => one.parameter === place.dataset.expected);
    place.hidden = !found.length;
    if (!found.length) continue;
    const low = Math.min(...found.map((one) => one.lower)),
      high = Math.max(...found.map((one) => one.upper));
    const unit = found[0].unit ? ` ${found[0].unit}` : "";
    const range = number(low) === number(high) ? number(low) : `${number(low)} to ${number(high)}`;
    const by = [...new Set(found.map((one) => (one.measured ? "readings" : "index properties")))].join(" and ");
    const more = found.length > MOST ? [element("li", {}, `and ${found.length - MOST} more`)] : [];
    place.replaceChildren(
      element("summary", {}, `Expected: ${range}${unit}, by ${by}`),
      element(
        "ul",
        {},
        found.slice(0, MOST).map((one) => element("li", {}, `${number(one.value)}${unit}: ${one.source}`)),
        more,
      ),
    );
  }
}
