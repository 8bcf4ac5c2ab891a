// The figures of the report, each as a file.
import { element, exchange, failure, tableHead, wide } from "../dom.js";
import { get } from "../http.js";
import { paced } from "../pace.js";

export function figures(id, place) {
  const row = (name) =>
    element(
      "tr",
      {},
      element("td", {}, name.replaceAll("_", " ")),
      element(
        "td",
        {},
        ["svg", "png", "csv"].map((form) => [
          element(
            "a",
            {
              href: `/api/v1/jobs/${id}/figures/${encodeURIComponent(name)}.${form}`,
              "aria-label": `${name} as ${form.toUpperCase()}`,
            },
            form.toUpperCase(),
          ),
          " ",
        ]),
      ),
    );
  paced(
    async () => {
      try {
        const { items } = await get(`/jobs/${id}/figures`);
        exchange(
          place,
          items.length
            ? wide(
                "Figures",
                element("table", {}, tableHead(["Figure", "Download"]), element("tbody", {}, items.map(row))),
              )
            : "",
        );
      } catch (error) {
        place.replaceChildren(failure(error));
      }
    },
    5000,
    place,
  )();
}
