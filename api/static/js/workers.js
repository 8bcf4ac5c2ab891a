// Who runs what, since when; for administrators also what waits, how runs have ended, and API keys.
import { connection, failure } from "./dom.js";
import { get } from "./http.js";
import { keysPanel } from "./workers/keys.js";
import { operations } from "./workers/operations.js";
import { workersTable } from "./workers/table.js";

const RENEW_SECONDS = 3;
const { admin } = document.querySelector("main").dataset;
const isAdmin = admin === "true";

/** Read again and show; focus stays where it is, as nothing here can be focused but links of jobs. */
async function look() {
  try {
    const [{ items }, measures] = await Promise.all([get("/workers"), isAdmin ? get("/operations") : null]);
    connection(null);
    show("workers", workersTable(items));
    if (measures) show("operations", operations(measures));
  } catch (error) {
    if (error.status === 0) connection("Connection lost; trying again …");
    else document.getElementById("workers").replaceChildren(failure(error));
  }
  setTimeout(look, 1000 * RENEW_SECONDS * (document.hidden ? 5 : 1));
}

function show(id, content) {
  const place = document.getElementById(id);
  const focused = place.contains(document.activeElement) ? document.activeElement.getAttribute("href") : null;
  place.replaceChildren(content);
  if (focused) place.querySelector(`[href="${CSS.escape(focused)}"]`)?.focus();
}

look();
if (isAdmin) keysPanel(document.getElementById("keys"));
