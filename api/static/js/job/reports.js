// Reports take seconds to make: said where they were asked for.
import { announce } from "../dom.js";
import { request } from "../http.js";

export function reports() {
  const boxes = [...document.querySelectorAll("#parts input")];
  document.getElementById("parts").addEventListener("change", ({ target }) => {
    if (boxes.every(({ checked }) => !checked)) target.checked = true; // a report of nothing is none
    const chosen = boxes.filter(({ checked }) => checked);
    const words = new URLSearchParams(chosen.length < boxes.length ? chosen.map(({ value }) => ["part", value]) : []);
    for (const link of document.querySelectorAll("a[data-made]")) link.search = words;
  });
  for (const link of document.querySelectorAll("a[data-made]")) {
    link.addEventListener("click", (event) =>
      link.download ? saved(event, link) : announce("The report opens in a new tab after a few seconds."),
    );
  }
}

/** Fetch the file with a word on it, then hand it to the browser. */
async function saved(event, link) {
  if (link.href.startsWith("blob:")) return;
  event.preventDefault();
  if (link.ariaBusy === "true") return;
  link.ariaBusy = "true";
  const words = link.textContent,
    begun = Date.now();
  const count = setInterval(() => {
    link.textContent = `${words}: in preparation, ${Math.round((Date.now() - begun) / 1000)} s …`;
  }, 1000);
  announce("Making the report …");
  try {
    const { pathname, search } = new URL(link.href);
    const made = URL.createObjectURL(await (await request("GET", pathname + search)).blob());
    const save = Object.assign(document.createElement("a"), { href: made, download: link.download });
    save.click();
    setTimeout(() => URL.revokeObjectURL(made), 60_000);
    announce("The report is ready.");
  } catch (error) {
    announce(error.message, 12);
  } finally {
    clearInterval(count);
    link.textContent = words;
    link.ariaBusy = null;
  }
}
