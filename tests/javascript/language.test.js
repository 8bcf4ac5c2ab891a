import assert from "node:assert/strict";
import { test } from "node:test";

import { Translator } from "../../api/static/js/language.js";

const german = (phrases) => new Translator({ decimal: ",", phrases });

test("a text has its own phrase, and keeps the space around it", () => {
  const pages = german({ Search: "Suche" });
  assert.equal(pages.translate("  Search \n"), "  Suche \n");
});

test("what is inserted is translated as well, in the order of the language, with decimals", () => {
  const pages = german({
    "{} is {}.": "{} ist {}.",
    "{} of {} runs": "von {2} Läufen {1}",
    identified: "identifiziert",
  });
  assert.equal(pages.translate("λ* is identified."), "λ* ist identifiziert.");
  assert.equal(pages.translate("1 200 of 2.5 runs"), "von 2,5 Läufen 1 200");
});

test("the pattern with most letters is asked first, whichever stands first", () => {
  const pages = german({
    "{} is {}": "{} ist {}",
    "{} is at its {} bound": "{} liegt an der {} Schranke",
    upper: "oberen",
  });
  assert.equal(pages.translate("c is at its upper bound"), "c liegt an der oberen Schranke");
});

test("sentences are translated one by one where the whole has no phrase; citations do not end them", () => {
  const pages = german({
    "Nothing was found.": "Nichts wurde gefunden.",
    "Give more readings.": "Mehr Messwerte angeben.",
    "Usual: {} to {}, {}.": "Üblich: {} bis {}, {}.",
  });
  assert.equal(
    pages.translate("Nothing was found. Usual: 0.5 to 1, Potts (1999), Mech. Cohes. Give more readings."),
    "Nichts wurde gefunden. Üblich: 0,5 bis 1, Potts (1999), Mech. Cohes. Mehr Messwerte angeben.",
  );
});

test("marks around a phrase stay", () => {
  const pages = german({ failed: "fehlgeschlagen", "{} failed": "{} fehlgeschlagen" });
  assert.equal(pages.translate(", 3 failed"), ", 3 fehlgeschlagen");
  assert.equal(pages.translate("⚠ failed:"), "⚠ fehlgeschlagen:");
});

test("what has no phrase stays, is collected, and has the decimals of the language", () => {
  const pages = german({});
  assert.equal(pages.translate("1.5 wishes on 2026.11.29"), "1,5 wishes on 2026.11.29");
  assert.deepEqual([...pages.missing], ["1.5 wishes on 2026.11.29"]);
});

test("numbers, units and dates need no phrase", () => {
  const pages = german({});
  for (const text of ["0.5 kPa", "12", "m²", "2026-11-29 05:41", "λ*"]) pages.translate(text);
  assert.deepEqual([...pages.missing], []);
  assert.equal(pages.translate("0.5 kPa"), "0,5 kPa");
});
