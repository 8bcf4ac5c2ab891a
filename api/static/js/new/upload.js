// The place for files: one of measurements is looked at, then mapped to a series; tests in the AGS 4 format become the problem.
import { announce, element, failure } from "../dom.js";
import { request } from "../http.js";
import { button } from "./schema_form.js";
import { agsChoice, assumed, contentsOf, isAgs } from "./import/ags.js";
import { mapping } from "./import/mapping.js";
import { testsTable } from "./import/tests.js";

const NAMED = 4; // specimens that a sentence names
const GROUPS = ["CONG", "ESCG", "TREG", "TRIG", "MOND"]; // sheets of a workbook in the AGS format

/**
 * The place for files; `context` has series and readings (see `mapping`) and of the problem (see `agsChoice`);
 * `act`: {take(observation, name): true: it has announced it, stages(found, name), replace(problem, words): true: it has announced it, replaced(act): calls it when more was replaced}.
 */
export function uploader(context, act) {
  const place = element("div", {});
  const input = element("input", {
    type: "file",
    id: "file",
    class: "visually-hidden",
    accept: ".csv,.txt,.tsv,.xlsx,.ods,.ags",
    onchange: () => {
      if (input.files[0]) read(input.files[0]);
      input.value = "";
    },
  });
  const table = element("input", {
    type: "file",
    id: "tests-files",
    class: "visually-hidden",
    multiple: true,
    accept: ".csv,.txt,.tsv,.xlsx,.ods,.dat",
    onchange: () => {
      if (table.files.length) many([...table.files]);
      table.value = "";
    },
  });
  const zone = element(
    "div",
    { class: "drop" },
    element("p", {}, "Drop a file of measurements (CSV, XLSX or ODS) or tests of a laboratory (AGS 4) here"),
    input,
    element("label", { for: "file", class: "button quiet" }, "Choose a file"),
    " ",
    table,
    element("label", { for: "tests-files", class: "button quiet" }, "Add tests from a table"),
    element(
      "p",
      { class: "help" },
      "Headings such as ",
      element("code", {}, "settlement [mm]"),
      " or ",
      element("code", {}, "Zeit [min]"),
      " say what a column holds. An AGS file makes the whole problem. Many tests: choose a table with a row for each (file, kind, cell pressure, void ratio) and the files that it names, together. You see and confirm what is taken. Files go to this service only, and are not stored.",
    ),
  );
  zone.addEventListener("dragover", (event) => {
    event.preventDefault();
    zone.classList.add("over");
  });
  zone.addEventListener("dragleave", () => zone.classList.remove("over"));
  zone.addEventListener("drop", (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    const files = [...event.dataTransfer.files];
    if (files.length > 1) many(files);
    else if (files[0]) read(files[0]);
  });
  let latest = 0; // which file was given last: answers about others come too late

  const read = (file, sheet) =>
    shown(file.name, async () => ((await isAgs(file)) ? tests(file) : columns(file, sheet)));
  const many = (files) =>
    shown(`${files.length} files`, () =>
      testsTable(files, context, {
        replace: (problem, words) => {
          leave();
          if (!act.replace(problem, words)) announce(words);
        },
        cancel: leave,
      }),
    );

  async function shown(what, making) {
    const mine = ++latest;
    place.replaceChildren(element("p", { class: "help" }, `Reading ${what} …`));
    try {
      const made = await making();
      if (mine !== latest) return;
      place.replaceChildren(made);
      place.querySelector("input, select, button")?.focus();
    } catch (error) {
      if (mine === latest) place.replaceChildren(failure(error));
    }
  }

  async function columns(file, sheet) {
    const content = new Blob([file]);
    const answer = await (
      await request("POST", "/measurements", {
        query: { name: file.name, sheet },
        body: content,
        headers: { "Content-Type": "application/octet-stream" },
      })
    ).json();
    if (!sheet && answer.sheets.some((name) => GROUPS.includes(name))) return tests(file);
    return mapping(answer, content, context, {
      sheet: (other) => read(file, other),
      take: (observation, name) => {
        place.replaceChildren();
        const told = act.take(observation, name);
        input.focus();
        return told;
      },
      stages: async (found) => {
        await act.stages(found, file.name);
        await read(file, answer.sheet ?? undefined); // by the series that there are now
      },
      cancel: leave,
    });
  }

  async function tests(file) {
    return agsChoice(file, await contentsOf(file), context, {
      replace: (problem, specimens, notes) => {
        const more = specimens.length - NAMED;
        const from = `${specimens.slice(0, NAMED).join(", ")}${more > 0 ? ` and ${more} more` : ""} of ${file.name}`;
        if (!act.replace(problem, `${from} ${specimens.length === 1 ? "has" : "have"} replaced what was here.`))
          announce(`The problem is made of ${from}.`);
        place.replaceChildren(
          element(
            "section",
            { class: "item made-of", "aria-label": "Made of an AGS file" },
            element("p", {}, `Made of ${from}.`),
            assumed(notes),
            element("div", { class: "buttons" }, button("Close", leave)),
          ),
        );
        input.focus();
      },
      readings: (name, csv) => read(new File([csv], name)),
      cancel: leave,
    });
  }

  /** Show nothing below the place any more; the focus continues there. */
  function leave() {
    place.replaceChildren();
    input.focus();
  }

  act.replaced(() => place.querySelector(".made-of")?.remove()); // it is no longer about what is there
  return element("div", {}, zone, place);
}
