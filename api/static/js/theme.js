// Runs before the first paint, so that neither a chosen theme nor a language flashes. Not a module: those wait.
(() => {
  const root = document.documentElement;
  const kept = (key) => {
    try {
      return localStorage.getItem(key);
    } catch {
      return null; // Storage may be forbidden: then it is what the system and the browser prefer.
    }
  };
  const theme = kept("theme");
  if (theme === "light" || theme === "dark") root.dataset.theme = theme;

  const offered = root.dataset.languages.split(" ");
  const wished = [kept("language"), ...navigator.languages.map((one) => one.split("-")[0])];
  root.lang = wished.find((one) => one === "en" || offered.includes(one)) ?? "en";
  if (root.lang === "en") return;
  const address = new URL(`../languages/${root.lang}.json`, document.currentScript.src);
  window.catalogue = fetch(address);
  window.catalogue.catch(() => {}); // language.js reads it, and shows the page in English without it
  root.dataset.waits = "";
  setTimeout(() => delete root.dataset.waits, 3000);
})();
