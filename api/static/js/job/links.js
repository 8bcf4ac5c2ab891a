// Read-only links: a job for people without a key, until the link expires or is revoked.
import { announce, confirmed, dialog, element, empty, exchange, failure, once, tableHead, wide } from "../dom.js";
import { moment } from "../format.js";
import { get, post } from "../http.js";
import { shownOnce } from "../secret.js";

const DAYS = [
  [7, "in a week"],
  [14, "in two weeks"],
  [90, "in 90 days"],
  [366, "in a year"],
];

/** The dialog that lists the links to a job, revokes them and makes another one. */
export function links({ id }) {
  const list = element("div", { "aria-live": "polite" });
  const message = element("p", { class: "error", role: "alert" });

  async function look() {
    try {
      const { items } = await get(`/jobs/${id}/links`);
      exchange(list, items.length ? table(items, revoke) : empty("There are no links to this job."));
    } catch (error) {
      list.replaceChildren(failure(error));
    }
  }

  async function revoke(link) {
    const question = `Revoke the link ${link.label ? `“${link.label}”` : link.id}? It opens nothing from now on.`;
    if (!(await confirmed(question, "Revoke"))) return;
    try {
      await post(`/jobs/${id}/links/${link.id}/revoke`);
      announce("The link is revoked.");
    } catch (error) {
      message.textContent = error.message;
    }
    await look();
  }

  async function make(form) {
    message.textContent = "";
    try {
      const wanted = { label: form.elements.label.value, valid_days: Number(form.elements.expiry.value) };
      const { path } = await post(`/jobs/${id}/links`, wanted);
      form.reset();
      await look();
      dialog("New link", ...shownOnce(location.origin + path));
    } catch (error) {
      message.textContent = error.message;
    }
  }

  const button = element("button", {}, "Make a link");
  const form = element(
    "form",
    {
      class: "make-key",
      "aria-label": "Make a link",
      onsubmit: (event) => {
        event.preventDefault();
        once(button, () => make(form));
      },
    },
    element(
      "label",
      {},
      "For whom",
      element("input", { name: "label", maxlength: 200, autocomplete: "off", placeholder: "reviewer" }),
    ),
    element(
      "label",
      {},
      "Expires",
      element(
        "select",
        { name: "expiry" },
        DAYS.map(([value, text]) => element("option", { value, selected: value === 14 }, text)),
      ),
    ),
    button,
  );
  dialog(
    "Read-only links",
    element(
      "p",
      { class: "help" },
      "Whoever has a link sees this job without a key, with its note but without attached files, and can change nothing.",
    ),
    list,
    form,
    message,
  );
  look();
}

function table(items, revoke) {
  return wide(
    "Table of links",
    element(
      "table",
      {},
      tableHead(["For whom", "State", "Expires", "Last used", ""]),
      element(
        "tbody",
        {},
        items.map((link) =>
          element(
            "tr",
            {},
            element("th", { scope: "row", translate: "no" }, link.label || "–"),
            element("td", {}, element("span", { class: `state ${link.state}` }, link.state)),
            element("td", {}, moment(link.expires_at)),
            element("td", {}, link.used_at ? moment(link.used_at) : "never"),
            element(
              "td",
              {},
              link.state === "active"
                ? element("button", { type: "button", class: "danger small", onclick: () => revoke(link) }, "Revoke")
                : "",
            ),
          ),
        ),
      ),
    ),
  );
}
