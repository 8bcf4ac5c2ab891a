// Sentences that name keys of the problem, in the words of this form: labels of its fields.
import { labelOf } from "./schema_form.js";

const TICKED = ["true", "leave_out"]; // what a box gives that is ticked

/** The words of a key. `label(path)`: of a field that is not one of the draft. */
function named({ path, value }, label) {
  if (path === "accept") return `“The readings of ${value} are meant as they are”`;
  if (/^observations\[\d+\]$/.test(path)) return value;
  const input = document.querySelector(`[data-path="${CSS.escape(path)}"]`);
  const key = path.replace(/\[\d*(, \d+)*\]/g, "").split(".");
  const words = label?.(path) ?? input?.labels?.[0]?.textContent ?? labelOf(key.at(-1));
  return `“${words.trim()}”${value && !TICKED.includes(value) ? ` ${value.replaceAll("_", " ")}` : ""}`;
}

/** A sentence of parts, each text or a key. */
export const worded = (parts, label) => parts.map((part) => (typeof part === "string" ? part : named(part, label))).join("");

/** The message of an issue. */
export const messageOf = (issue, label) => (issue.parts?.length ? worded(issue.parts, label) : issue.message);
