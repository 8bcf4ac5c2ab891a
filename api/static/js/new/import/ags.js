// A file in the AGS 4 format becomes the problem: its tests are listed, some are chosen, what is assumed and replaced is shown, then it is confirmed.
import { announce, element, exchange } from "../../dom.js";
import { count } from "../../format.js";
import { request } from "../../http.js";
import { numberOf } from "../fields.js";
import { words as plain } from "../schema.js";
import { button } from "../schema_form.js";
import { choice, words } from "./inputs.js";

const PAUSE = 250; // ms without a change before the service is asked
const FEW = 12; // tests that are seen at a glance
const LABELS = { stage_duration: "Duration of an increment", initial_stress: "Initial stress", material: "Soil law" };

/** Whether a file is in the AGS format, by its name or its first line. */
export async function isAgs(file) {
  return /\.ags$/i.test(file.name) || /^\uFEFF?\s*"(GROUP"\s*,|\*\*)/.test(await file.slice(0, 200).text());
}

/** A note as a sentence; names such as c, mu_star and of files stay small. */
const sentence = (text) =>
  `${text.replace(/^[a-z]{2,}\b(?!\.)/, (word) => word[0].toUpperCase() + word.slice(1))}${/[.!?]$/.test(text) ? "" : "."}`;
const messages = (error) => (error.issues?.length ? error.issues.map(({ message }) => message) : [error.message]);
const several = (number, one, more = `${one}s`) => `${count(number)} ${number === 1 ? one : more}`;

function ask(path, file, query, signal) {
  const headers = { "Content-Type": "application/octet-stream" };
  return request("POST", `/measurements/ags${path}`, {
    query: { name: file.name, ...query },
    body: new Blob([file]),
    headers,
    signal,
  }).then((answer) => answer.json());
}

/** What a file holds, from the service. */
export const contentsOf = (file) => ask("", file, {});

/** A problem in words: kind or kinds, readings, parameters that are searched for and given. */
export function summary(problem) {
  const { forward_model: model = {}, parameters = {}, observations = [] } = problem;
  const parts = Object.values(model.parts ?? {}).map((part) => plain(part.kind ?? "?"));
  const kinds = [...new Set(parts)].map((kind) => {
    const n = parts.filter((one) => one === kind).length;
    return n > 1 ? `${n} × ${kind}` : kind;
  });
  const given = Array.isArray(observations) ? observations : [];
  const named = (wanted) =>
    Object.entries(parameters ?? {})
      .filter(([, one]) => "lower" in (one ?? {}) === wanted)
      .map(([name]) => name);
  return {
    what: parts.length ? kinds.join(", ") : model.kind ? plain(model.kind) : "no forward model",
    readings: given.reduce((sum, one) => sum + (one.points?.x?.length ?? 0), 0),
    free: named(true),
    fixed: named(false),
  };
}

/**
 * The form that chooses among the tests of a file. `contents`: what the service found in it; `context`: {begun(): whether there
 * is a problem to lose, document(), materials: names of laws}; `act`: {replace(problem, specimens), readings(name, csv), cancel()}.
 */
export function agsChoice(file, contents, context, act) {
  const state = { chosen: new Set(), material: "", stage_duration: "", initial_stress: "", filter: "" };
  const list = element("div", { class: "tests", role: "group", "aria-label": "Tests" });
  const wrong = element("div", { class: "problems" }),
    said = element("p", { class: "help", role: "status" }),
    preview = element("div", {});
  const use = button("Choose tests", accept, { class: "", id: "ags-take" });
  const usable = contents.items.filter((one) => one.use === "problem"),
    readings = contents.items.filter((one) => one.use === "readings");
  const tests = [...new Set(usable.map((one) => one.id))];
  let made = null,
    refused = [],
    timer = null,
    running = null;

  const where = (one) => [one.location, one.depth && `${one.depth} m`].filter(Boolean).join(", ");

  function row(id, i) {
    const its = usable.filter((one) => one.id === id);
    const box = element("input", {
      type: "checkbox",
      id: `ags-${i}`,
      value: id,
      checked: state.chosen.has(id),
      "aria-describedby": `ags-${i}-what`,
      onchange: () => {
        if (box.checked) state.chosen.add(id);
        else state.chosen.delete(id);
        load();
      },
    });
    return element(
      "div",
      { class: "choice" },
      box,
      element(
        "div",
        {},
        element("label", { for: `ags-${i}` }, element("strong", {}, id)),
        element(
          "div",
          { id: `ags-${i}-what` },
          its.map((one) =>
            element("div", {}, [one.kind, where(one)].filter(Boolean).join(", "), element("small", {}, one.what)),
          ),
        ),
      ),
    );
  }

  function drawList() {
    const shown = tests.filter((id) =>
      [id, ...usable.filter((one) => one.id === id).map((one) => `${one.kind} ${where(one)}`)]
        .join(" ")
        .toLowerCase()
        .includes(state.filter.toLowerCase()),
    );
    exchange(
      list,
      shown.length
        ? shown.map((id) => row(id, tests.indexOf(id)))
        : element("p", { class: "help" }, "No test has these words."),
    );
  }

  /** The problem as it would be taken, from the service: by the function of `geoswarm import ags`. */
  function load() {
    clearTimeout(timer);
    running?.abort();
    made = null;
    refused = [];
    for (const [name, unit] of [
      ["stage_duration", "hours"],
      ["initial_stress", "kPa"],
    ]) {
      const value = numberOf(state[name]);
      if (state[name] && !(typeof value === "number" && value > 0))
        refused.push(`${LABELS[name]} is “${state[name]}”: a number of ${unit} above 0 is accepted.`);
    }
    show();
    if (state.chosen.size && !refused.length) timer = setTimeout(read, PAUSE);
  }

  async function read() {
    const mine = new AbortController();
    running = mine;
    const hours = state.stage_duration ? numberOf(state.stage_duration) / 24 : null;
    const query = {
      words: "fields",
      specimen: tests.filter((id) => state.chosen.has(id)),
      material: state.material,
      stage_duration: hours,
      initial_stress: state.initial_stress ? numberOf(state.initial_stress) : null,
    };
    try {
      made = await ask("/problem", file, query, mine.signal);
    } catch (error) {
      if (error.name === "AbortError") return;
      refused = messages(error);
    }
    show();
  }

  /** What the choice makes, what it replaces, and what the button would do. */
  function show() {
    exchange(
      wrong,
      refused.map((text) => element("p", { class: "error", role: "alert" }, text)),
    );
    const problem = made?.problem;
    use.disabled = !problem;
    use.textContent = !state.chosen.size
      ? "Choose tests"
      : `${context.begun() ? "Replace the problem by" : "Take"} ${several(state.chosen.size, "test")}`;
    if (!problem) {
      said.textContent =
        !tests.length || refused.length
          ? ""
          : state.chosen.size
            ? "Reading …"
            : "Nothing is chosen. Several tests are taken as tests of one soil and share its parameters.";
      exchange(preview);
      return;
    }
    const now = summary(problem),
      old = summary(context.document());
    said.textContent = `It makes a problem (${now.what}) of ${several(now.readings, "reading")}.`;
    exchange(
      preview,
      element(
        "dl",
        {},
        element("dt", {}, "Searched for"),
        element("dd", {}, now.free.join(", ") || "nothing"),
        element("dt", {}, "Given"),
        element("dd", {}, now.fixed.join(", ") || "nothing"),
        context.begun()
          ? [
              element("dt", {}, "It replaces"),
              element(
                "dd",
                {},
                `${old.what}, ${several(old.readings, "reading")}, ${several(old.free.length + old.fixed.length, "parameter")}, method and stopping. “Undo” brings them back.`,
              ),
            ]
          : null,
      ),
      assumed(made.notes),
    );
  }

  function accept() {
    const { problem, notes, specimens } = made;
    act.replace(problem, specimens, notes);
  }

  async function takeReadings(entry) {
    try {
      const same = readings.filter((one) => one.id === entry.id);
      const answer = await ask("/problem", file, { words: "fields", specimen: [entry.id] });
      const { name, csv } = answer.readings[same.indexOf(entry)];
      for (const note of answer.notes) announce(sentence(note), 10);
      act.readings(name, csv);
    } catch (error) {
      refused = messages(error);
      show();
    }
  }

  function wishes() {
    const place = element("div", { class: "fields" });
    const number = (name, placeholder, help) =>
      words(
        `ags-${name}`,
        LABELS[name],
        state[name],
        (value) => {
          state[name] = value;
          load();
        },
        { placeholder, help },
      );
    place.replaceChildren(
      choice(
        "ags-material",
        LABELS.material,
        [["", "the usual one"], ...context.materials.map((one) => [one, plain(one)])],
        state.material,
        (value) => {
          state.material = value;
          load();
        },
        { help: "Soft soil, or Mohr-Coulomb for drained triaxial tests alone." },
      ),
      number("stage_duration", "24", "In hours; such files have no durations."),
      number(
        "initial_stress",
        "",
        "In kPa, before the first increment of oedometer tests; a tenth of its stress unless given.",
      ),
    );
    return place;
  }

  const without = contents.items.filter((one) => one.use === "nothing");
  const form = element(
    "fieldset",
    { class: "group mapping ags" },
    element("legend", {}, file.name),
    tests.length
      ? element(
          "p",
          { class: "help" },
          `${several(tests.length, "specimen")} with tests that make a problem.${contents.count > contents.items.length ? ` Of ${count(contents.count)} entries the first ${count(contents.items.length)} are listed.` : ""}`,
        )
      : element(
          "p",
          { class: "error", role: "alert" },
          "No test of this file makes a problem. Compression tests (CONG, ESCG) and consolidated triaxial tests (TREG) do.",
        ),
    tests.length > FEW
      ? words(
          "ags-filter",
          "Show tests with",
          state.filter,
          (value) => {
            state.filter = value;
            drawList();
          },
          { placeholder: "BH1" },
        )
      : null,
    tests.length ? list : null,
    readings.length
      ? element(
          "details",
          { class: "more", open: !tests.length },
          element("summary", {}, `Readings of instruments (${count(readings.length)})`),
          element("p", { class: "help" }, "They belong to a series of the forward model that is in the form."),
          element(
            "div",
            { class: "scroll" },
            element(
              "ul",
              {},
              readings.map((one) =>
                element(
                  "li",
                  {},
                  element("strong", {}, one.id),
                  ` ${one.kind}: ${one.what} `,
                  button("Take readings", () => takeReadings(one), {
                    "aria-label": `Take readings of ${one.id}, ${one.kind}`,
                    class: "quiet small",
                  }),
                ),
              ),
            ),
          ),
        )
      : null,
    without.length
      ? element(
          "details",
          { class: "more", open: !tests.length && !readings.length },
          element("summary", {}, `Not usable (${count(without.length)})`),
          element(
            "div",
            { class: "scroll", tabindex: "0", role: "region", "aria-label": "Not usable" },
            element(
              "ul",
              {},
              without.map((one) =>
                element(
                  "li",
                  {},
                  element("strong", {}, one.id),
                  ` ${one.kind === "not usable" ? "" : `${one.kind}: `}${sentence(one.why)}`,
                ),
              ),
            ),
          ),
        )
      : null,
    tests.length
      ? element(
          "details",
          { class: "more" },
          element("summary", {}, "What the file does not say: soil law, durations, initial stress"),
          wishes(),
        )
      : null,
    wrong,
    said,
    preview,
    element(
      "div",
      { class: "buttons" },
      tests.length ? use : null,
      button("Cancel", () => {
        clearTimeout(timer);
        running?.abort();
        act.cancel();
      }),
    ),
  );
  if (tests.length === 1) state.chosen.add(tests[0]);
  drawList();
  load();
  return form;
}

/** What was assumed, as a list. */
export function assumed(notes) {
  return notes.length
    ? element(
        "details",
        { class: "assumed", open: true },
        element("summary", {}, "Assumed, or to be known"),
        element(
          "ul",
          {},
          notes.map((note) => element("li", {}, sentence(note))),
        ),
      )
    : null;
}
