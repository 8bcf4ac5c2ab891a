// Signing in: the key goes to the service once, and is not kept here.
import { once } from "./dom.js";
import { get, post } from "./http.js";

const form = document.getElementById("sign-in");
const next = document.querySelector("main").dataset.next;
if (form && location.hash) followLink(location.hash.slice(1));
form?.addEventListener("submit", (event) => {
  event.preventDefault();
  once(form.querySelector("button"), signIn);
});

async function signIn() {
  const field = form.elements.key,
    place = document.getElementById("key-error");
  const say = (text) => {
    place.textContent = text;
    field.setAttribute("aria-invalid", String(Boolean(text)));
    if (text) field.focus();
  };
  const key = field.value.trim();
  if (!key) return say("Enter the API key.");
  say("");
  try {
    await post("/session", { key });
    location.assign(next);
  } catch (error) {
    say(error.status === 401 ? "This key is not valid or has expired." : error.message);
  }
}

/** A read-only link has its key behind the #. A session that shows the job already is kept: it may be able to do more. */
async function followLink(key) {
  history.replaceState(null, "", location.pathname + location.search);
  try {
    await get(next);
  } catch {
    try {
      await post("/session", { key });
    } catch (error) {
      document.getElementById("key-error").textContent =
        error.status === 401 ? "This link has expired or was revoked." : error.message;
      return;
    }
  }
  location.replace(next);
}
