// Displacements of the observed points, measured against calculated, as a table.
import { element, empty, tableHead, wide } from "../dom.js";
import { number } from "../format.js";

export function vectorTable(vectors, { name, factor }) {
  if (!vectors.length) return empty("No displacements of points were measured.");
  const value = (one) => element("td", { class: "n" }, one === null ? "–" : number(one * factor, 4));
  const length = ([x, y]) => (x === null || y === null ? null : Math.hypot(x, y));
  const head = [
    "Point",
    "Period [day]",
    ...["ux", "uy", "length"].flatMap((what) => [`${what} measured [${name}]`, `calculated [${name}]`]),
    "Difference of length",
  ];
  const share = (measured, calculated) =>
    measured && calculated !== null ? `${(100 * (calculated / measured - 1)).toFixed(0)} %`.replace("-", "−") : "–";
  return wide(
    "Displacements of points",
    element(
      "table",
      {},
      tableHead(head, (i) => i > 1),
      element(
        "tbody",
        {},
        vectors.map(({ name: survey, point, start, end, measured, calculated }) =>
          element(
            "tr",
            {},
            element("th", { scope: "row" }, `${point} (${survey})`),
            element("td", {}, `${number(start, 6)} to ${number(end, 6)}`),
            [0, 1].map((axis) => [value(measured[axis]), value(calculated[axis])]),
            value(length(measured)),
            value(length(calculated)),
            element("td", { class: "n" }, share(length(measured), length(calculated))),
          ),
        ),
      ),
    ),
  );
}
