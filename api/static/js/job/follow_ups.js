// Jobs that follow from this one, the shares of the series, and the figures of the report.
import { FOLLOW_UPS } from "../costs.js";
import { element, empty, exchange, failure } from "../dom.js";
import { number } from "../format.js";
import { get } from "../http.js";
import { paced } from "../pace.js";

export function followUps(view) {
  const place = document.getElementById("follow-ups"), pictures = document.getElementById("figures"), shares = document.getElementById("shares");

  let lacking = false; // the best evaluation, when last looked: the generation that brings it is told, too
  const list = paced(async () => {
    lacking = view.job.objective === null;
    for (const item of document.querySelectorAll("[data-needs-best]")) item.hidden = lacking;
    if (lacking) {
      place.replaceChildren(empty("They start from the best evaluation; there is none yet."));
      return;
    }
    try {
      const [{ follow_ups: found }, { items }] = await Promise.all([get(`/jobs/${view.id}/uncertainty`), get(`/jobs/${view.id}/figures`)]);
      exchange(place,
        found.length
          ? element("ul", {}, found.map((one) => element("li", {}, element("a", { href: `/jobs/${one.id}` }, FOLLOW_UPS[one.kind] ?? one.kind), ` · ${one.evaluations} evaluations `, element("span", { class: `state ${one.state}` }, one.state))))
          : empty("None yet. ", element("a", { href: `/jobs/${view.id}/statistics` }, "The statistics"), " propose what to do next."));
      exchange(pictures, items.length ? figures(items) : "");
    } catch (error) {
      place.replaceChildren(failure(error));
    }
  }, 5000, place);

  const figures = (names) => element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "Figures" }, element("table", {},
    element("thead", {}, element("tr", {}, element("th", { scope: "col" }, "Figure"), element("th", { scope: "col" }, "Download"))),
    element("tbody", {}, names.map((name) => element("tr", {}, element("td", {}, name.replaceAll("_", " ")), element("td", {}, ["svg", "png", "csv"].map((form) => [
      element("a", { href: `/api/v1/jobs/${view.id}/figures/${encodeURIComponent(name)}.${form}`, "aria-label": `${name} as ${form.toUpperCase()}` }, form.toUpperCase()), " ",
    ])))))));

  function share() {
    const best = view.fit?.curves.find(({ role }) => role === "best");
    if (!best) return void shares.replaceChildren(empty("No successful evaluation yet."));
    exchange(shares, element("div", { class: "wide", tabindex: "0", role: "region", "aria-label": "Shares of the series" }, element("table", {},
      element("thead", {}, element("tr", {}, ["Series", "Weight", "Misfit [base unit²]", "Share of the objective"].map((head, i) => element("th", { scope: "col", class: i === 1 || i === 2 ? "n" : null }, head)))),
      element("tbody", {}, best.shares.map((one) => element("tr", {},
        element("td", {}, one.series), element("td", { class: "n" }, number(one.weight)), element("td", { class: "n" }, number(one.misfit)),
        element("td", { class: "bar-cell" }, element("meter", { min: 0, max: 1, value: one.share, "aria-label": `share of ${one.series}` }), ` ${(100 * one.share).toFixed(0)} %`)))))));
  }
  // the fit comes first: these are asked for when it is there
  return { job: () => { if (view.fit) list(); }, generation: () => { if (lacking) list(); }, fit() { share(); list(); } };
}
