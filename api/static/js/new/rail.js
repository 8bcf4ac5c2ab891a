// Where one is in the form: its sections, with a tick where nothing is missing or wrong.
import { element } from "../dom.js";

const SECTIONS = [
  ["model", "Forward model", ["forward_model"]],
  ["measurements", "Measurements", ["observations", "weighting"]],
  ["parameters", "Parameters", ["parameters", "constraints", "index_properties"]],
  ["method", "Method", ["method", "stopping", "seed"]],
  ["go", "Check and start", null],
];

/** What a section is after an answer of the service: "good", "open", or null before the first answer. */
export function judged(keys, { issues, valid }) {
  if (keys === null) return valid ? "good" : "open";
  return issues.some(({ path }) => keys.includes(path.split(/[.[]/)[0])) ? "open" : "good";
}

export function rail({ draft }) {
  const links = SECTIONS.map(([id, words, keys], i) => {
    const mark = element("span", { class: "mark", "aria-hidden": "true" }, "·"),
      said = element("span", { class: "visually-hidden" });
    const link = element("a", { href: `#${id}-title` }, mark, ` ${i + 1}. ${words}`, said);
    return { keys, link, mark, said };
  });
  draft.on("answer", (answer) => {
    for (const { keys, link, mark, said } of links) {
      const state = judged(keys, answer);
      link.className = state;
      mark.textContent = state === "good" ? "✓" : "○";
      said.textContent = state === "good" ? ", complete" : ", not complete yet";
    }
  });
  return element(
    "nav",
    { class: "rail", "aria-label": "Sections of the form" },
    links.map(({ link }) => link),
  );
}
