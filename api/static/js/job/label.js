// Tags and a note of a job: what people write about it.
import { announce, dialog, element } from "../dom.js";
import { send } from "../http.js";
import { renew } from "../renew.js";
import { tagsIn } from "../format.js";

export function label(view) {
  const { tags, note } = view.job;
  const error = element("p", { class: "error", role: "alert" });
  const form = element(
    "form",
    { novalidate: true },
    element(
      "label",
      {},
      "Tags, with commas between them",
      element("input", { name: "tags", value: tags.join(", "), placeholder: "dam, second trial" }),
    ),
    element("label", {}, "Note (Markdown)", element("textarea", { name: "note", rows: 8, value: note ?? "" })),
    element(
      "p",
      { class: "help" },
      "The list of jobs finds tags; a project can be one. Everybody who can see the job can read both.",
    ),
    error,
    element("div", { class: "buttons" }, element("button", { type: "submit" }, "Save")),
  );
  const made = dialog("Tags and note", form);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const wanted = tagsIn(form.elements.tags.value);
    try {
      await send("PATCH", `/jobs/${view.id}`, { tags: wanted, note: form.elements.note.value });
      made.close();
      announce("Saved.");
      await Promise.all([view.refresh(), renew(document.getElementById("label"))]);
    } catch (refused) {
      error.textContent = refused.issues.length
        ? refused.issues.map(({ message }) => message).join("\n")
        : refused.message;
    }
  });
}
