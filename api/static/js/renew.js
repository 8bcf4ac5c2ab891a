// Renews <main> from the server; what the first paint shows stays true without a second way to draw it.
import { connection } from "./dom.js";

let busy = false, due = false;

/** Fetch this page again and exchange the content of <main>; requests in a short time become one. */
export async function renew() {
  if (busy) { due = true; return; }
  busy = true;
  try {
    const answer = await fetch(location.href, { headers: { Accept: "text/html" } });
    if (answer.redirected) { location.assign(answer.url); return; }
    if (answer.ok) {
      const page = new DOMParser().parseFromString(await answer.text(), "text/html");
      document.querySelector("main").replaceChildren(...page.querySelector("main").childNodes);
    }
    connection(answer.ok ? null : `The service answered ${answer.status}; trying again …`);
  } catch {
    connection("Connection lost; trying again …");
  }
  setTimeout(() => { busy = false; if (due) { due = false; renew(); } }, 500);
}
