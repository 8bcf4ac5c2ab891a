// Sentences that name keys of the problem, in the words of this form: labels of its fields.
import { symbol } from "../format.js";
import { words } from "./schema.js";

const TICKED = ["true", "leave_out"]; // what a box gives that is ticked
// What to do about a file that only a problem file can name.
const FILES = {
  readings: "drop the file under Measurements",
  tests: "“Add tests from a table” takes the table and its files",
  ags: "drop it under Measurements, alone",
};

/** A key of the problem file as the label of its input. */
export function labelOf(key) {
  const known = symbol(key);
  if (known !== key || key.length < 3) return known;
  return (key[0].toUpperCase() + words(key.slice(1))).replace(/^Crs\b/, "CRS");
}

/** A path as labels: “Stages” 2, “Stress”. */
export function placeOf(path) {
  return path
    .split(".")
    .map((step) => {
      const [key, ...places] = step.split(/[[\], ]+/);
      return [key && `“${labelOf(key)}”`, ...places.filter(Boolean).map((i) => Number(i) + 1)]
        .filter(Boolean)
        .join(" ");
    })
    .join(", ");
}

/** The words of a key. `label(path)`: of a field that is not one of the draft. */
function named({ path, value }, label) {
  if (path === "files") return FILES[value];
  if (path === "accept") return `“The readings of ${value} are meant as they are”`;
  if (/^observations\[\d+\]$/.test(path)) return value;
  const input = document.querySelector(`[data-path="${CSS.escape(path)}"]`);
  const key = path.replace(/\[\d*(, \d+)*\]/g, "").split(".");
  const words = label?.(path) ?? input?.labels?.[0]?.textContent ?? labelOf(key.at(-1));
  return `“${words.trim()}”${value && !TICKED.includes(value) ? ` ${value.replaceAll("_", " ")}` : ""}`;
}

/** A sentence of parts, each text or a key. */
export const worded = (parts, label) =>
  parts.map((part) => (typeof part === "string" ? part : named(part, label))).join("");

/** The message of an issue. */
export const messageOf = (issue, label) => (issue.parts?.length ? worded(issue.parts, label) : issue.message);
