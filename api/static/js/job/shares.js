// What each series is worth in the objective.
import { element, empty, exchange, tableHead, wide } from "../dom.js";
import { number } from "../format.js";

export function shares(view) {
  const place = document.getElementById("shares");
  return {
    fit() {
      const best = view.fit.curves.find(({ role }) => role === "best");
      if (!best) return void place.replaceChildren(empty("No successful evaluation yet."));
      exchange(
        place,
        wide(
          "Shares of the series",
          element(
            "table",
            {},
            tableHead(["Series", "Weight", "Misfit [base unit²]", "Share of the objective"], (i) => i === 1 || i === 2),
            element(
              "tbody",
              {},
              best.shares.map((one) =>
                element(
                  "tr",
                  {},
                  element("td", {}, one.series),
                  element("td", { class: "n" }, number(one.weight)),
                  element("td", { class: "n" }, number(one.misfit)),
                  element(
                    "td",
                    { class: "bar-cell" },
                    element("meter", { min: 0, max: 1, value: one.share, "aria-label": `share of ${one.series}` }),
                    ` ${(100 * one.share).toFixed(0)} %`,
                  ),
                ),
              ),
            ),
          ),
        ),
      );
    },
  };
}
