import assert from "node:assert/strict";
import { readFileSync } from "node:fs";
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

test("a list of any length goes by the pattern of its items", () => {
  const pages = german({ "{} kPa for {} day": "{} kPa für {} d", "in {} stages": "in {} Laststufen" });
  assert.equal(
    pages.translate("in 3 stages: 9.5 kPa for 2 day, 25 kPa for 1 day, 50 kPa for 1 day."),
    "in 3 Laststufen: 9,5 kPa für 2 d, 25 kPa für 1 d, 50 kPa für 1 d.",
  );
});

test("what is not broken in English is not broken in the other language", () => {
  const pages = german({ "{} % of the range": "{} % des Bereichs" });
  assert.equal(pages.translate("95\u00a0% of the range"), "95\u00a0% des Bereichs");
});

test("a clause begins as its phrase does, a sentence with a capital", () => {
  const pages = german({ "the model fits": "das Modell passt" });
  assert.equal(pages.translate("the model fits; the model fits."), "das Modell passt; das Modell passt.");
  assert.equal(pages.translate("The model fits."), "Das Modell passt.");
});

test("a phrase of several clauses is found with the dot of its sentence, and before a short pattern", () => {
  const pages = german({
    "{} is not the minimum yet; polish the best one first": "{} ist noch nicht das Minimum; zuerst verbessern",
    "{} of {}": "{} von {}",
    "{} runs of the searched range": "{} Läufe im Bereich",
  });
  assert.equal(
    pages.translate("It is not the minimum yet; polish the best one first."),
    "It ist noch nicht das Minimum; zuerst verbessern.",
  );
  assert.equal(pages.translate("2 runs of the searched range; 1.5"), "2 Läufe im Bereich; 1,5");
});

test("marks around a phrase stay", () => {
  const pages = german({ failed: "fehlgeschlagen", "{} failed": "{} fehlgeschlagen" });
  assert.equal(pages.translate(", 3 failed"), ", 3 fehlgeschlagen");
  assert.equal(pages.translate("⚠ failed:"), "⚠ fehlgeschlagen:");
  assert.equal(german({ "Time [s]": "Zeit [s]" }).translate("Time [s]:"), "Zeit [s]:");
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

test("a verdict with its caveats is German throughout", () => {
  const catalogue = new URL("../../api/static/languages/de.json", import.meta.url);
  const pages = new Translator(JSON.parse(readFileSync(catalogue)));
  assert.equal(
    pages.translate(
      "λ* is identified within one basin only: its 95\u00a0% interval at the optimum, widened by a factor of 1.5 for correlated noise, as stated, is 0.08 to 0.09, 0.5\u00a0% of the searched range, up to the upper bound or beyond; it holds within its basin; the runs are sparse, and another basin like it could still hide in 28\u00a0% of the searched space.",
    ),
    "λ* ist nur innerhalb eines Beckens identifiziert: sein 95-%-Intervall am Optimum, um den Faktor 1,5 erweitert wegen korrelierten Rauschens, wie angegeben, ist 0,08 bis 0,09, 0,5\u00a0% des durchsuchten Bereichs, bis zur oberen Schranke oder darüber hinaus; es gilt in seinem Becken; die Läufe sind dünn verteilt, und ein weiteres solches Becken könnte sich noch in 28\u00a0% des durchsuchten Raums verbergen.",
  );
  assert.deepEqual([...pages.missing], []);
});
