// API keys: list, make, revoke.
import { announce, confirmed, dialog, element, empty, exchange, failure, once, tableHead, when, wide } from "../dom.js";
import { shownOnce } from "../secret.js";
import { moment } from "../format.js";
import { get, post } from "../http.js";

const DAYS = [
  ["", "never"],
  ["30", "in 30 days"],
  ["90", "in 90 days"],
  ["365", "in a year"],
];
const ROLES = [
  ["submit", "submit: look at and run own jobs"],
  ["read", "read: look at own jobs"],
  ["admin", "admin: everything, for all"],
  ["agent", "agent: run what jobs have calculated"],
];

/** Fill `place` with the keys and a form for another one. */
export async function keysPanel(place) {
  const list = element("div");
  const message = element("p", { class: "error", role: "alert" });
  const { key_needed: needed } = await get("/session").catch(() => ({ key_needed: true }));
  const note = needed
    ? null
    : element(
        "p",
        { class: "help" },
        "This service needs no key now. Once a key exists, it will need one after its next start: create an administrator's key first.",
      );

  async function look() {
    try {
      const { items } = await get("/keys");
      exchange(list, items.length ? table(items, revoke) : empty("There are no keys."));
    } catch (error) {
      list.replaceChildren(failure(error));
    }
  }

  async function revoke({ id, owner }) {
    if (
      !(await confirmed(
        `Revoke the key ${id} of ${owner || "no owner"}? It will be refused from now on; this cannot be undone.`,
        "Revoke",
      ))
    )
      return;
    try {
      await post(`/keys/${id}/revoke`);
      announce(`The key ${id} is revoked.`);
    } catch (error) {
      message.textContent = error.message;
    }
    await look();
  }

  place.replaceChildren(...[note].filter(Boolean), list, form(look, message), message);
  await look();
}

function table(keys, revoke) {
  const head = ["Owner", "Role", "State", "Label", "Made", "Expires", "Last used", "Key", ""];
  const ends = (timestamp) =>
    new Date(timestamp) > Date.now() ? element("time", { datetime: timestamp }, moment(timestamp)) : when(timestamp);
  return wide(
    "Table of API keys",
    element(
      "table",
      {},
      tableHead(head),
      element(
        "tbody",
        {},
        keys.map((key) =>
          element(
            "tr",
            {},
            element("th", { scope: "row" }, key.owner),
            element("td", {}, key.job ? element("a", { href: `/jobs/${key.job}` }, "link to a job") : key.role),
            element("td", {}, element("span", { class: `state ${key.state}` }, key.state)),
            element("td", {}, key.label || "–"),
            element("td", {}, when(key.created_at)),
            element("td", {}, key.expires_at ? ends(key.expires_at) : "never"),
            element("td", {}, key.used_at ? when(key.used_at) : "never"),
            element("td", {}, element("code", {}, key.id)),
            element(
              "td",
              {},
              key.state === "active"
                ? element(
                    "button",
                    {
                      type: "button",
                      class: "danger",
                      "aria-label": `Revoke the key ${key.id} of ${key.owner}`,
                      onclick: () => revoke(key),
                    },
                    "Revoke",
                  )
                : "",
            ),
          ),
        ),
      ),
    ),
  );
}

function form(look, message) {
  const owner = element("input", {
    required: true,
    maxlength: 80,
    pattern: "[A-Za-z0-9][A-Za-z0-9._@+\\-]*",
    autocomplete: "off",
    title: "letters, digits and . _ @ + -",
  });
  const role = element(
    "select",
    {},
    ROLES.map(([value, text]) => element("option", { value }, text)),
  );
  const label = element("input", { maxlength: 200, autocomplete: "off", placeholder: "what it is for" });
  const expiry = element(
    "select",
    {},
    DAYS.map(([value, text]) => element("option", { value }, text)),
  );
  const field = (text, input) => element("label", {}, text, input);
  const make = element("button", {}, "Make a key");
  async function submit() {
    message.textContent = "";
    try {
      const wanted = {
        owner: owner.value,
        role: role.value,
        label: label.value,
        valid_seconds: expiry.value ? 86400 * Number(expiry.value) : null,
      };
      const { key } = await post("/keys", wanted);
      dialog(`Key of ${wanted.owner}`, ...shownOnce(key));
      owner.value = label.value = "";
      await look();
    } catch (error) {
      message.textContent = error.message;
    }
  }
  return element(
    "form",
    {
      class: "make-key",
      onsubmit: (event) => {
        event.preventDefault();
        once(make, submit);
      },
      "aria-label": "Make a key",
    },
    field("Owner", owner),
    field("Role", role),
    field("Label", label),
    field("Expires", expiry),
    make,
  );
}
