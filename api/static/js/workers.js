// Workers, since when; for administrators also what waits, how runs have ended, and API keys.
import { connection, exchange, failure } from "./dom.js";
import { get } from "./http.js";
import { keysPanel } from "./workers/keys.js";
import { operations } from "./workers/operations.js";
import { workersTable } from "./workers/table.js";

const RENEW_SECONDS = 3;
const { admin, version } = document.querySelector("main").dataset;
const isAdmin = admin === "true";
const place = (id) => document.getElementById(id);

/** Read again and show. */
async function look() {
  try {
    const [{ items }, measures] = await Promise.all([get("/workers"), isAdmin ? get("/operations") : null]);
    connection(null);
    exchange(place("workers"), workersTable(items, version));
    if (measures) exchange(place("operations"), operations(measures));
  } catch (error) {
    if (error.status === 0) connection("Connection lost; trying again …");
    else place("workers").replaceChildren(failure(error));
  }
  setTimeout(look, 1000 * RENEW_SECONDS * (document.hidden ? 5 : 1));
}

look();
if (isAdmin) keysPanel(place("keys"));
