// On every page: the language, the theme's button and signing out.
import { send } from "./http.js";
import { announce, renewAges } from "./dom.js";
import "./language.js";

const THEMES = ["system", "light", "dark"];
const button = document.getElementById("theme");

function show(theme) {
  button.lastElementChild.textContent = `Theme: ${theme}`;
  button.title = `Theme: ${theme}`;
}

function choose(theme) {
  if (theme === "system") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = theme;
  try {
    localStorage.setItem("theme", theme);
  } catch {
    // Storage may be forbidden: the choice then lasts for this page.
  }
  show(theme);
  document.dispatchEvent(new Event("themechange"));
}

show(document.documentElement.dataset.theme ?? "system");
button.addEventListener("click", () => {
  const now = document.documentElement.dataset.theme ?? "system";
  choose(THEMES[(THEMES.indexOf(now) + 1) % THEMES.length]);
});
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () =>
  document.dispatchEvent(new Event("themechange")),
);

const language = document.getElementById("language");
language.value = document.documentElement.lang;
language.addEventListener("change", () => {
  try {
    localStorage.setItem("language", language.value);
    location.reload();
  } catch {
    announce("This browser keeps no choice of a language: change the language of the browser.");
  }
});

document.getElementById("sign-out")?.addEventListener("click", async () => {
  try {
    await send("DELETE", "/session");
    location.assign("/sign-in");
  } catch (error) {
    announce(error.message);
  }
});

renewAges();
setInterval(() => document.hidden || renewAges(), 10_000); // they grow while the page is looked at
