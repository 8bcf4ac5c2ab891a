// Name, tags and a note of a job: what people write about it.
import { announce, dialog, element } from "../dom.js";
import { send } from "../http.js";
import { renew } from "../renew.js";
import { tagsIn } from "../format.js";

export function label(view) {
  const { name, tags, note } = view.job;
  const error = element("p", { class: "error", role: "alert" });
  const form = element(
    "form",
    { novalidate: true },
    element("label", {}, "Name", element("input", { name: "name", value: name, maxlength: 200, autocomplete: "off" })),
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
      "The list of jobs finds names and tags; a project can be a tag. Everybody who can see the job can read them.",
    ),
    error,
    element("div", { class: "buttons" }, element("button", { type: "submit" }, "Save")),
  );
  const made = dialog("Name, tags and note", form);
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    const wanted = {
      name: form.elements.name.value.trim(),
      tags: tagsIn(form.elements.tags.value),
      note: form.elements.note.value,
    };
    if (!wanted.name) {
      error.textContent = "A job needs a name.";
      form.elements.name.focus();
      return;
    }
    try {
      await send("PATCH", `/jobs/${view.id}`, wanted);
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
