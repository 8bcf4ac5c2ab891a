// The same problem as YAML: always there, can be written, copied and downloaded; with the list of what is wrong.
import { announce, element, exchange } from "../dom.js";
import { isTodo } from "./fields.js";
import { messageOf, placeOf, worded } from "./words.js";

export function yamlPanel(context, place, strict) {
  const { draft } = context;
  const area = element("textarea", {
    id: "yaml",
    spellcheck: "false",
    autocomplete: "off",
    wrap: "off",
    rows: "24",
    "aria-describedby": "yaml-help",
  });
  const issues = element("div", {
    id: "issues",
    role: "region",
    "aria-label": "What is missing or wrong",
    "aria-live": "polite",
  });
  const verdict = element("p", { id: "verdict", role: "status" });
  const warnings = element("ul", { class: "notes", "aria-label": "Warnings" });
  const start = element(
    "button",
    { type: "button", id: "start-now", hidden: true, onclick: () => document.getElementById("start").click() },
    "Start now",
  );
  const note = element("p", { class: "error", role: "alert" });
  let typing = false; // the text is the user's until the form changes something

  const fold = element(
    "details",
    { id: "yaml-fold", open: kept() !== "folded", ontoggle: () => keep(fold.open ? "" : "folded") },
    element("summary", { class: "title" }, "YAML"),
    element("label", { for: "yaml", class: "help" }, "The problem as YAML"),
    element(
      "p",
      { class: "help", id: "yaml-help" },
      "The same problem as text; edit either one. ",
      element("code", {}, "geoswarm submit"),
      " takes the same file.",
    ),
    area,
    element(
      "div",
      { class: "buttons" },
      element("button", { type: "button", class: "quiet", onclick: () => download() }, "Download"),
      element("button", { type: "button", class: "quiet", onclick: () => copy() }, "Copy"),
    ),
  );

  area.addEventListener("input", () => {
    typing = true;
    draft.edit(area.value);
  });
  draft.on("change", () => {
    if (document.activeElement !== area) typing = false;
  });
  draft.on("answer", (answer) => {
    note.textContent = "";
    area.disabled = answer.yaml === null;
    if (answer.yaml === null)
      note.textContent = "The problem has too many readings to be edited as text here; use the form.";
    if (answer.yaml !== null && !typing && area.value !== answer.yaml) area.value = answer.yaml;
    showIssues(answer);
  });
  draft.on("failure", (error) => {
    note.textContent = error.message;
  });

  function showIssues(answer) {
    const todo = answer.issues.filter(isTodo),
      wrong = answer.issues.filter((one) => !isTodo(one));
    const told = answer.valid ? answer.warning_parts : [];
    exchange(
      warnings,
      told.map((parts) => element("li", {}, worded(parts))),
    );
    start.hidden = !answer.valid;
    verdict.textContent = answer.valid
      ? told.length
        ? `Complete, with ${told.length === 1 ? "one warning" : `${told.length} warnings`}: ready to start.`
        : "Complete and valid: ready to start."
      : [wrong.length ? `${wrong.length} to fix` : "", todo.length ? `${todo.length} still missing` : ""]
          .filter(Boolean)
          .join(", ");
    verdict.className = told.length ? "warned" : answer.valid ? "good" : wrong.length || strict() ? "error" : "help";
    issues.replaceChildren(answer.issues.length ? element("ul", {}, [...wrong, ...todo].map(item)) : "");
  }

  function item(issue) {
    const words = `${issue.path ? placeOf(issue.path) : "The problem"}${isTodo(issue) ? "" : ":"} ${messageOf(issue)}`;
    const jump = element(
      "button",
      { type: "button", class: "link", onclick: () => go(issue) },
      issue.line ? `line ${issue.line}` : "show",
    );
    return element("li", { class: isTodo(issue) ? "todo" : "wrong" }, words, " ", jump);
  }

  /** To the field of the form when there is one, else to the line. */
  function go(issue) {
    const input = document.querySelector(`[data-path="${CSS.escape(issue.path)}"]`);
    if (input) {
      for (let fold = input.closest("details"); fold; fold = fold.parentElement.closest("details")) fold.open = true;
      input.scrollIntoView({ block: "center" });
      return input.focus({ preventScroll: true });
    }
    fold.open = true;
    if (!issue.line) return area.focus();
    const lines = area.value.split("\n");
    const start = lines.slice(0, issue.line - 1).reduce((sum, line) => sum + line.length + 1, 0);
    area.focus();
    area.setSelectionRange(start, start + lines[issue.line - 1].length);
    area.scrollTop = (area.scrollHeight / lines.length) * Math.max(0, issue.line - 4);
    return undefined;
  }

  function download() {
    const name = String(draft.read(["name"]) ?? "problem").replace(/[^\w.-]+/g, "-") || "problem";
    const [text, ending, type] =
      draft.answer?.yaml === null
        ? [JSON.stringify(draft.document, null, 1), "json", "application/json"]
        : [area.value, "yaml", "application/yaml"];
    const address = URL.createObjectURL(new Blob([text], { type }));
    const link = element("a", { href: address, download: `${name}.${ending}` });
    document.body.append(link);
    link.click();
    link.remove();
    setTimeout(() => URL.revokeObjectURL(address), 1000);
  }

  async function copy() {
    try {
      await navigator.clipboard.writeText(area.value);
      announce("Copied.");
    } catch {
      area.select();
      announce("Press Ctrl+C to copy.");
    }
  }

  place.replaceChildren(element("div", { class: "buttons" }, verdict, start), warnings, issues, note, fold);
}

/** Whether the reader has folded it, in this browser. */
function kept() {
  try {
    return localStorage.getItem("geoswarm-yaml");
  } catch {
    return null; // storage may be forbidden
  }
}

function keep(how) {
  try {
    localStorage.setItem("geoswarm-yaml", how);
  } catch {
    // then it is open again the next time
  }
}
