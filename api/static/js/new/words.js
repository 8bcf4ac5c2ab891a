// Sentences that name keys of the problem, in the words of this form: labels of its fields.
import { labelOf } from "./schema_form.js";

/** The words of a key. */
function named({ path, value }) {
  if (path === "accept") return `“The readings of ${value} are meant as they are”`;
  if (/^observations\[\d+\]$/.test(path)) return value;
  const input = document.querySelector(`[data-path="${CSS.escape(path)}"]`);
  const key = path.replace(/\[\d*(, \d+)*\]/g, "").split(".");
  return `“${input?.labels?.[0]?.textContent.trim() ?? labelOf(key.at(-1))}”${value && value !== "true" ? ` ${value.replaceAll("_", " ")}` : ""}`;
}

/** A sentence of parts, each text or a key. */
export const worded = (parts) => parts.map((part) => (typeof part === "string" ? part : named(part))).join("");

/** The message of an issue. */
export const messageOf = (issue) => (issue.parts?.length ? worded(issue.parts) : issue.message);
