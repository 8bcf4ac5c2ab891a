// Signing in: the key goes to the service once, and is not kept here.
import { once } from "./dom.js";
import { post } from "./http.js";

const form = document.getElementById("sign-in");
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
    location.assign(document.querySelector("main").dataset.next);
  } catch (error) {
    say(error.status === 401 ? "This key is not valid or has expired." : error.message);
  }
}
