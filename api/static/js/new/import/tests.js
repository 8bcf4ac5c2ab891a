// A table of laboratory tests and the files of its rows become parts of a combined forward model, with their readings.
import { element, exchange } from "../../dom.js";
import { count } from "../../format.js";
import { post } from "../../http.js";
import { words as plain } from "../schema.js";
import { button } from "../schema_form.js";
import { messageOf } from "../words.js";
import { summary } from "./ags.js";
import { choice } from "./inputs.js";

const MOST_TEXT = 100_000; // characters of a file in which the names of others are looked for

const partsOf = (problem) => Object.keys(problem?.forward_model?.parts ?? {});
const tests = (number) => `${count(number)} ${number === 1 ? "test" : "tests"}`;

/** The content of a file in base64. */
function encoded(file) {
  return new Promise((resolve, reject) => {
    const reader = new FileReader();
    reader.onload = () => resolve(reader.result.slice(reader.result.indexOf(",") + 1));
    reader.onerror = () => reject(reader.error);
    reader.readAsDataURL(file);
  });
}

/** The file that names others, else one that is called a table of tests, else the first. */
async function likelyTable(files) {
  const texts = await Promise.all(files.map((file) => file.slice(0, MOST_TEXT).text()));
  const naming = files.find((file, i) => files.some((other) => other !== file && texts[i].includes(other.name)));
  return naming ?? files.find(({ name }) => /test|versuch|table|tabelle|overview|übersicht/i.test(name)) ?? files[0];
}

/**
 * The form that takes a table of tests. `files`: the table and those of its rows; `context`: {begun(): whether there is a
 * problem to lose, document(), materials: names of laws}; `act`: {replace(problem, words), cancel()}.
 */
export async function testsTable(files, context, act) {
  const sent = Object.fromEntries(await Promise.all(files.map(async (file) => [file.name, await encoded(file)])));
  const state = { table: (await likelyTable(files)).name, material: "" };
  const wrong = element("div", { class: "problems" }),
    said = element("p", { class: "help", role: "status" });
  const use = button("Take the tests", accept, { class: "", id: "tests-take" });
  let made = null,
    latest = 0;

  /** Tests come to those of a combined problem; any other one is replaced. */
  const added = () => context.document().forward_model?.kind === "combined";

  async function load() {
    const mine = ++latest,
      { name, method, stopping, seed } = context.document();
    made = null;
    show([]);
    const given = added() ? context.document() : { name, method, stopping, seed };
    const table = { table: state.table, ...(state.material ? { material: state.material } : {}) };
    try {
      const { problem } = await post("/problems/tests", { problem: { ...given, tests: table }, files: sent });
      if (mine !== latest) return;
      made = problem;
      show([]);
    } catch (error) {
      if (mine === latest) show(error.issues?.length ? error.issues : [error]);
    }
  }

  function show(refused) {
    exchange(
      wrong,
      refused.map((issue) => element("p", { class: "error", role: "alert" }, messageOf(issue))),
    );
    use.disabled = !made;
    const fresh = made ? partsOf(made).length - (added() ? partsOf(context.document()).length : 0) : 0;
    use.textContent = !made
      ? "Take the tests"
      : added()
        ? `Add ${tests(fresh)}`
        : `${context.begun() ? "Replace the problem by" : "Take"} ${tests(fresh)}`;
    said.textContent = made
      ? `It makes a problem (${summary(made).what}) of ${count(summary(made).readings)} readings.`
      : refused.length
        ? ""
        : "Reading …";
  }

  function accept() {
    act.replace(
      made,
      `${use.textContent.replace(/^\D*/, "")} of ${state.table} ${added() ? "were added" : "have replaced what was here"}.`,
    );
  }

  const form = element(
    "fieldset",
    { class: "group mapping" },
    element("legend", {}, `Tests from a table: ${count(files.length)} ${files.length === 1 ? "file" : "files"}`),
    element(
      "div",
      { class: "fields" },
      choice(
        "tests-table",
        "Table with a row a test",
        files.map(({ name }) => [name, name]),
        state.table,
        (value) => {
          state.table = value;
          load();
        },
        { help: "Its columns: file, kind, cell pressure, void ratio …" },
      ),
      choice(
        "tests-material",
        "Soil law",
        [["", "as the table says"], ...context.materials.map((one) => [one, plain(one)])],
        state.material,
        (value) => {
          state.material = value;
          load();
        },
        { help: "Of tests whose rows name none." },
      ),
    ),
    wrong,
    said,
    element(
      "div",
      { class: "buttons" },
      use,
      button("Cancel", () => {
        latest++;
        act.cancel();
      }),
    ),
  );
  load();
  return form;
}
