// The problem in the making: one document that the form and the YAML both show, judged by the service after every change.
import { request, RequestError } from "../http.js";

const ORDER = [
  "name",
  "forward_model",
  "index_properties",
  "parameters",
  "constraints",
  "weighting",
  "noise",
  "method",
  "stopping",
  "seed",
  "priority",
  "limits",
  "failures",
  "warm_start",
  "observations",
];
const PAUSE = 250; // ms without a keystroke before the service is asked
const KEPT = "geoswarm-new-job";

/** Path as the service writes it: ["observations", 0, "weight"] is observations[0].weight. */
export function pathText(path) {
  return path.reduce(
    (text, step) => (typeof step === "number" ? `${text}[${step}]` : text ? `${text}.${step}` : step),
    "",
  );
}

export const clone = (value) => (value === undefined ? undefined : structuredClone(value));

function ordered(document) {
  const known = ORDER.filter((key) => key in document);
  return Object.fromEntries(
    [...known, ...Object.keys(document).filter((key) => !ORDER.includes(key))].map((key) => [key, document[key]]),
  );
}

/**
 * A draft: `read(path)`, `write(path, value)` (undefined removes), `replace(document)`, `edit(yaml)`.
 * Events by `on(name, act)`: "replace" (everything may have changed), "change" (something has), "answer" (the service has
 * judged: `answer`), "failure" (an error: the service could not), "undo" ({words, restore}: something was replaced).
 */
export function createDraft() {
  const listeners = { replace: [], change: [], answer: [], failure: [], undo: [] };
  const fire = (name, value) => {
    for (const act of listeners[name]) act(value);
  };
  let timer = null,
    running = null,
    text = null;
  let model = { kind: null, parameters: [], series: [] };

  const draft = {
    document: {},
    answer: null,
    changes: 0,
    on: (name, act) => {
      listeners[name].push(act);
    },
    read: (path) => path.reduce((value, step) => value?.[step], draft.document),
    write(path, value) {
      let place = draft.document;
      path.slice(0, -1).forEach((step, i) => {
        if (typeof place[step] !== "object" || place[step] === null)
          place[step] = typeof path[i + 1] === "number" ? [] : {};
        place = place[step];
      });
      const last = path.at(-1);
      if (value === undefined && Array.isArray(place)) place.splice(last, 1);
      else if (value === undefined) delete place[last];
      else place[last] = value;
      if (path.length === 2 && Object.keys(place).length === 0) delete draft.document[path[0]]; // an empty section is none
      changed();
    },
    replace(document) {
      draft.document = clone(document);
      fire("replace");
      changed();
    },
    /** Remember the problem as it is; the answer, a function of what was done in words, offers the way back to it. */
    mark() {
      const before = clone(draft.document);
      const restore = () => {
        const again = draft.mark();
        draft.replace(before);
        again("Restored.");
      };
      return (words) => fire("undo", { words, restore });
    },
    /** The user writes the YAML; the form follows when it can be read. */
    edit(yaml) {
      changed(yaml);
    },
    /** Parameters and series of the forward model, as they were when its section was sound last. */
    model: () => (model.kind === draft.document.forward_model?.kind ? model : { parameters: [], series: [] }),
    /** Ask now, for example before a check; the answer. */
    async judge() {
      clearTimeout(timer);
      return ask();
    },
  };

  function changed(yaml = null) {
    text = yaml;
    draft.changes += 1;
    fire("change");
    if (yaml === null) keep(draft.document);
    clearTimeout(timer);
    timer = setTimeout(() => {
      ask().catch(() => {});
    }, PAUSE);
  }

  async function ask() {
    running?.abort();
    const mine = new AbortController();
    running = mine;
    const given = text,
      changes = draft.changes;
    try {
      const body = given ?? JSON.stringify(ordered(draft.document));
      const headers = { "Content-Type": given === null ? "application/json" : "application/yaml" };
      const answer = await (await request("POST", "/problems/read", { body, headers, signal: mine.signal })).json();
      if (changes !== draft.changes) return answer;
      draft.answer = answer;
      if (answer.parameters)
        model = { kind: answer.document.forward_model.kind, parameters: answer.parameters, series: answer.series };
      if (given !== null && answer.document !== null) {
        draft.document = clone(answer.document);
        keep(draft.document);
        fire("replace");
      }
      fire("answer", answer);
      return answer;
    } catch (error) {
      if (error.name === "AbortError") return null;
      fire("failure", error instanceof RequestError ? error : new RequestError(String(error)));
      throw error;
    }
  }
  return draft;
}

/** The draft outlives a reload and signing in again, in this tab. */
function keep(document) {
  try {
    sessionStorage.setItem(KEPT, JSON.stringify(document));
  } catch {
    // Too much data, or storage is forbidden: then it does not.
  }
}

export function kept() {
  try {
    return JSON.parse(sessionStorage.getItem(KEPT));
  } catch {
    return null;
  }
}

export function forget() {
  try {
    sessionStorage.removeItem(KEPT);
  } catch {
    // nothing was kept
  }
}
