// What each series is worth in the objective.
import { element, empty, exchange } from "../dom.js";
import { number } from "../format.js";

export function shares(view) {
  const place = document.getElementById("shares");
  return {
    fit() {
      const best = view.fit.curves.find(({ role }) => role === "best");
      if (!best) return void place.replaceChildren(empty("No successful evaluation yet."));
      exchange(
        place,
        element(
          "div",
          { class: "wide", tabindex: "0", role: "region", "aria-label": "Shares of the series" },
          element(
            "table",
            {},
            element(
              "thead",
              {},
              element(
                "tr",
                {},
                ["Series", "Weight", "Misfit [base unit²]", "Share of the objective"].map((head, i) =>
                  element("th", { scope: "col", class: i === 1 || i === 2 ? "n" : null }, head),
                ),
              ),
            ),
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
