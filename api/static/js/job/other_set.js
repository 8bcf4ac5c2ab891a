// Another set of parameters, such as a published one, beside the result: a figure, and a link to the report.
import { element, once } from "../dom.js";
import { address, get } from "../http.js";

export function otherSet(view) {
  const place = document.getElementById("other-set");
  const area = element("textarea", {
    rows: "10",
    spellcheck: "false",
    autocomplete: "off",
    wrap: "off",
    "aria-label": "Another set of parameters",
  });
  const message = element("p", { class: "error", role: "alert" });
  const found = element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "Compared" });
  const compare = element(
    "button",
    {
      type: "button",
      onclick: ({ currentTarget }) =>
        once(currentTarget, async () => {
          message.textContent = "";
          found.replaceChildren();
          const jobs = `/jobs/${view.id}`,
            query = { compare: area.value };
          try {
            const { items } = await get(`${jobs}/figures`, query);
            const figure = items.includes("tests") ? "tests" : "fit";
            found.replaceChildren(
              element(
                "p",
                {},
                element(
                  "a",
                  { href: address(`${jobs}/report.html`, query), target: "_blank", rel: "noopener" },
                  "Report with both",
                ),
              ),
              element("img", {
                src: address(`${jobs}/figures/${figure}.svg`, query),
                alt: "Measured, identified, and the other set of parameters",
              }),
            );
          } catch (error) {
            message.textContent = error.message;
          }
        }),
    },
    "Compare",
  );
  place.replaceChildren(
    element(
      "details",
      {},
      element("summary", {}, "Compare with another set of parameters"),
      element(
        "p",
        { class: "help" },
        "A value for each free parameter, one a line, and a name. Parameters that are left out keep the value or expression of the job. The model runs once.",
      ),
      area,
      element("p", { class: "buttons" }, compare),
      message,
      found,
    ),
  );
  return {
    fit() {
      const best = view.fit.curves.find(({ role }) => role === "best");
      place.hidden = !best;
      if (best && !area.value)
        area.value = [
          "name: other set",
          ...view.fit.parameters
            .filter(({ form }) => form === "free")
            .map(({ name }) => `${name}: ${best.parameters[name]}`),
        ].join("\n");
    },
  };
}
