// Change when a job ends; one that has ended resumes where it was.
import { announce, dialog, element } from "../dom.js";
import { get, send } from "../http.js";
import { ENDED } from "../states.js";

const CRITERIA = [
  ["max_evaluations", "Largest number of evaluations", 1, 1],
  ["max_seconds", "Longest running time [s]", "any", 0],
  ["target_objective", "Target of the objective", "any", 0],
  ["stagnation_generations", "Generations without a lower objective", 1, 1],
];

export async function extend(view) {
  const ended = ENDED.has(view.job.state);
  let stopping;
  try {
    ({ stopping } = await get(`/jobs/${view.id}/problem`));
  } catch (error) {
    return announce(error.message);
  }
  const fields = CRITERIA.map(([name, label, step, min]) => [
    name,
    element(
      "label",
      {},
      label,
      element("input", { type: "number", name, step, min, value: stopping[name] ?? "", placeholder: "no limit" }),
    ),
  ]);
  const error = element("p", { class: "error", role: "alert" });
  const form = element(
    "form",
    { novalidate: true },
    element(
      "p",
      { class: "help" },
      ended
        ? "The search continues exactly where it ended, as if these criteria had been given from the start. Evaluations so far count."
        : "The job ends as soon as one of these is satisfied.",
    ),
    fields.map(([, label]) => label),
    error,
    element("div", { class: "buttons" }, element("button", { type: "submit" }, ended ? "Continue" : "Change")),
  );
  const made = dialog(ended ? "Continue this job" : "Stop criteria of this job", form);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const wanted = Object.fromEntries(
      fields.map(([name, label]) => {
        const { value } = label.querySelector("input");
        return [name, value === "" ? null : Number(value)];
      }),
    );
    try {
      await send("PATCH", `/jobs/${view.id}`, { stopping: wanted });
      made.close();
      announce(ended ? "The job continues." : "Changed.");
      await view.refresh();
    } catch (refused) {
      error.textContent = refused.issues.length ? refused.issues.map(inWords).join("\n") : refused.message;
    }
  });
}

/** A mistake with the label of its field instead of its path. */
function inWords({ path, message }) {
  const found = CRITERIA.find(([name]) => path.split(".").includes(name));
  return found ? `${found[1]}: ${message}` : message;
}
