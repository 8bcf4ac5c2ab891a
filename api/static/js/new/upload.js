// The place for files of measurements: one that is dropped or chosen is looked at, then mapped to a series.
import { element, failure } from "../dom.js";
import { request } from "../http.js";
import { mapping } from "./import/mapping.js";

/** The place for files; `context` tells of series and readings (see `mapping`), `take(observation, name)` gets what was mapped; true: it has told. */
export function uploader(context, take) {
  const place = element("div", {});
  const input = element("input", { type: "file", id: "file", class: "visually-hidden", accept: ".csv,.txt,.tsv,.xlsx,.ods", onchange: () => { if (input.files[0]) read(input.files[0]); input.value = ""; } });
  const zone = element("div", { class: "drop" },
    element("p", {}, "Drop a file of measurements here (CSV, XLSX or ODS)"),
    input, element("label", { for: "file", class: "button quiet" }, "Choose a file"),
    element("p", { class: "help" }, "Headings such as ", element("code", {}, "settlement [mm]"), " or ", element("code", {}, "Zeit [min]"), " say what a column holds. You see and confirm what is taken. The file goes to this service only, and is not stored."));
  zone.addEventListener("dragover", (event) => { event.preventDefault(); zone.classList.add("over"); });
  zone.addEventListener("dragleave", () => zone.classList.remove("over"));
  zone.addEventListener("drop", (event) => {
    event.preventDefault();
    zone.classList.remove("over");
    if (event.dataTransfer.files[0]) read(event.dataTransfer.files[0]);
  });

  async function read(file, sheet) {
    place.replaceChildren(element("p", { class: "help" }, `Reading ${file.name} …`));
    try {
      const content = new Blob([file]);
      const answer = await (await request("POST", "/measurements", { query: { name: file.name, sheet }, body: content, headers: { "Content-Type": "application/octet-stream" } })).json();
      place.replaceChildren(mapping(answer, content, context, {
        sheet: (other) => read(file, other),
        take: (observation, name) => {
          place.replaceChildren();
          const told = take(observation, name);
          document.getElementById("file").focus();
          return told;
        },
        cancel: () => place.replaceChildren(),
      }));
      place.querySelector("select")?.focus();
    } catch (error) {
      place.replaceChildren(failure(error));
    }
  }
  return element("div", {}, zone, place);
}
