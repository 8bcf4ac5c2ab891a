// The readings as they were read, a table for each series.
import { element, failure, tableHead, wide } from "../dom.js";
import { count, number, plain, withUnit } from "../format.js";
import { get } from "../http.js";

const MOST = 500;

export async function readingTables(id, place) {
  try {
    const { series } = await get(`/jobs/${id}/fit`);
    place.replaceChildren(
      ...series.map((one) => {
        const struck = one.gross_x.map((x, i) => [x, one.gross_measured[i], "gross error: not counted"]);
        const rows = [...one.x.map((x, i) => [x, one.measured[i], ""]), ...struck].sort((a, b) => a[0] - b[0]);
        const heads = [withUnit(one.x_quantity, one.x_unit), withUnit(one.y_quantity, one.y_unit)];
        return element(
          "details",
          {},
          element(
            "summary",
            {},
            `${plain(one.series)}: ${count(rows.length)} readings, weight ${number(one.weight)}${struck.length ? `, ${struck.length} of them gross errors` : ""}`,
          ),
          wide(
            `Readings of ${one.series}`,
            element(
              "table",
              {},
              tableHead([...heads, ""], (i) => i < heads.length),
              element(
                "tbody",
                {},
                rows
                  .slice(0, MOST)
                  .map(([x, y, why]) =>
                    element(
                      "tr",
                      {},
                      element("td", { class: "n" }, number(x, 8)),
                      element("td", { class: "n" }, number(y, 8)),
                      element("td", {}, why),
                    ),
                  ),
              ),
            ),
          ),
          rows.length > MOST
            ? element(
                "p",
                { class: "help" },
                `The first ${MOST} of ${count(rows.length)} readings; the problem has all.`,
              )
            : null,
        );
      }),
    );
  } catch (error) {
    place.replaceChildren(failure(error));
  }
}
