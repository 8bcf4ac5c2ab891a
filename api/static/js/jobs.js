// The list of jobs: kept up to date while somebody looks, filtered without a reload, and where jobs to compare are chosen.
import { announce, confirmed, connection, dialog, element, once, renewAges } from "./dom.js";
import { symbol, tagsIn } from "./format.js";
import { get, post, send } from "./http.js";
import { chooseColumns } from "./jobs/columns.js";
import { showViews } from "./jobs/views.js";
import { renew } from "./renew.js";

const INTERVAL = 3000,
  TYPING = 300,
  FEWEST = 2,
  MOST = 6;
const list = document.getElementById("list");
const filters = document.getElementById("filters");
const choose = document.getElementById("choose");
const chosen = new Set(); // beyond the page that is shown
const unfolded = new Set(); // jobs whose follow-ups are shown
const tagChosen = document.getElementById("tag-chosen"),
  cancelChosen = document.getElementById("cancel-chosen"),
  deleteChosen = document.getElementById("delete-chosen");
let asked = 0;

function dress() {
  renewAges(list);
  for (const place of list.querySelectorAll("[data-symbol]")) place.textContent = symbol(place.dataset.symbol);
  for (const box of boxes()) box.checked = chosen.has(box.value);
  for (const row of list.querySelectorAll("tr[data-parent]")) row.hidden = !unfolded.has(row.dataset.parent);
  for (const button of list.querySelectorAll("[data-below]"))
    button.ariaExpanded = String(unfolded.has(button.dataset.below));
  tell();
}

const boxes = () => [...list.querySelectorAll("input[name=job]")];

function tell() {
  const button = choose.querySelector("button[type=submit]");
  button.disabled = chosen.size < FEWEST || chosen.size > MOST;
  for (const act of [tagChosen, cancelChosen, deleteChosen]) if (act) act.disabled = chosen.size === 0;
  const what =
    chosen.size === 0
      ? "Choose two to six jobs to compare, or any number to tag, cancel or delete."
      : chosen.size < FEWEST
        ? "1 job chosen; choose at least one more to compare."
        : chosen.size > MOST
          ? `${chosen.size} jobs chosen; six is the most to compare.`
          : `${chosen.size} jobs chosen.`;
  const place = document.getElementById("chosen");
  if (place.textContent !== what) place.textContent = what;
}

/** Calibrate the example, and go to it. */
async function tryExample() {
  try {
    const { problem } = await get("/examples/oedometer");
    location.assign(`/jobs/${(await post("/jobs", problem)).id}`);
  } catch (error) {
    announce(error.message);
  }
}

async function show(url = location.href) {
  const turn = ++asked;
  try {
    await renew(list, url);
    if (turn === asked) connection(null);
  } catch {
    connection("Connection lost; trying again …");
  }
  dress();
}

function filter() {
  const words = new URLSearchParams(
    [...new FormData(filters)].filter(([name, value]) => value && !(name === "sort" && value === "created")),
  );
  const url = words.size ? `/?${words}` : "/";
  history.replaceState(null, "", url);
  showViews();
  return show(url);
}

document.getElementById("columns").addEventListener("click", () => chooseColumns(list, filters.elements.columns));

let typing = null;
filters.addEventListener("input", () => {
  clearTimeout(typing);
  typing = setTimeout(filter, TYPING);
});
filters.addEventListener("submit", (event) => {
  event.preventDefault();
  clearTimeout(typing);
  filter();
});
list.addEventListener("change", ({ target }) => {
  if (target.name !== "job") return;
  if (target.checked) chosen.add(target.value);
  else chosen.delete(target.value);
  tell();
});
list.addEventListener("click", ({ target }) => {
  if (target.id === "example") once(target, tryExample);
  const { below } = target.dataset;
  if (!below) return;
  if (!unfolded.delete(below)) unfolded.add(below);
  dress();
});
choose.addEventListener("submit", (event) => {
  event.preventDefault();
  if (chosen.size >= FEWEST && chosen.size <= MOST)
    location.assign(`/compare?${new URLSearchParams([...chosen].map((id) => ["job", id]))}`);
});

/** One after the other; failures are listed with their reason, and stay chosen. */
async function forAll(work, done) {
  const refused = [];
  let number = 0;
  for (const id of [...chosen]) {
    try {
      await work(id);
      chosen.delete(id);
      number += 1;
    } catch (error) {
      refused.push(error.message);
      if (error.status === 404) chosen.delete(id);
    }
  }
  announce(
    `${number} ${number === 1 ? "job" : "jobs"} ${done}${refused.length ? `; ${refused.length} not: ${refused[0]}` : "."}`,
    refused.length ? 12 : 6,
  );
  await show();
}

/** Ask for tags, and add them to those that the chosen jobs have. */
function tag() {
  const form = element(
    "form",
    {},
    element(
      "label",
      {},
      "Tags to add, with commas between them",
      element("input", { name: "tags", required: true, placeholder: "dam, second trial" }),
    ),
    element("div", { class: "buttons" }, element("button", { type: "submit" }, "Add")),
  );
  const made = dialog(`Tag ${many()}`, form);
  form.addEventListener("submit", (event) => {
    event.preventDefault();
    made.close();
    const added = tagsIn(form.elements.tags.value);
    const work = async (id) => {
      const { tags } = await get(`/jobs/${id}`);
      await send("PATCH", `/jobs/${id}`, { tags: [...new Set([...tags, ...added])] });
    };
    once(tagChosen, () => forAll(work, "tagged"));
  });
}

const many = () => (chosen.size === 1 ? "this job" : `these ${chosen.size} jobs`);
tagChosen?.addEventListener("click", tag);
cancelChosen?.addEventListener("click", async () => {
  if (await confirmed(`Cancel ${many()} now? Results so far are kept.`, "Cancel them"))
    once(cancelChosen, () => forAll((id) => post(`/jobs/${id}/cancel`), "cancelled"));
});
deleteChosen?.addEventListener("click", async () => {
  if (await confirmed(`Delete ${many()} and all evaluations permanently?`, "Delete"))
    once(deleteChosen, () => forAll((id) => send("DELETE", `/jobs/${id}`), "deleted"));
});

for (const box of boxes()) if (box.checked) chosen.add(box.value); // kept by the browser over a reload
filters.querySelector("[type=submit]").hidden = true; // filters act at once
showViews();
dress();
setInterval(() => document.hidden || show(), INTERVAL);
document.addEventListener("visibilitychange", () => document.hidden || show());
