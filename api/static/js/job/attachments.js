// Files of a job: attached by a button or by dropping them on the page, shown below its note, deleted.
import { announce, confirmed, element } from "../dom.js";
import { request, send } from "../http.js";
import { renew } from "../renew.js";

const place = document.getElementById("attachments");
const refused = document.getElementById("refused-files");

const show = () => renew(place);

/** Attach files one after the other; what is refused is named, the others are attached. */
async function attach(view, files) {
  const most = Number(place.dataset.mostMb);
  const errors = [];
  refused.textContent = "";
  for (const [i, file] of files.entries()) {
    const which = files.length > 1 ? ` (${i + 1} of ${files.length})` : "";
    announce(`Attaching ${file.name}${which} …`, 60);
    try {
      if (file.size > most * 1e6) throw new Error(`“${file.name}” has more than ${most} MB.`);
      await request("POST", `/jobs/${view.id}/attachments`, {
        query: { name: file.name },
        body: new Blob([file]),
        headers: { "Content-Type": "application/octet-stream" },
      });
    } catch (error) {
      errors.push(error.issues?.[0]?.message ?? error.message);
    }
  }
  refused.textContent = errors.join("\n");
  const attached = files.length - errors.length;
  announce(errors.length ? `${attached} of ${files.length} files attached.` : "Attached.");
  await show();
}

async function remove(view, button) {
  const { file, name } = button.dataset;
  if (!(await confirmed(`Delete “${name}” permanently?`, "Delete the file"))) return;
  try {
    await send("DELETE", `/jobs/${view.id}/attachments/${file}`);
    announce("Deleted.");
    await show();
    (place.querySelector("button") ?? document.getElementById("attach"))?.focus();
  } catch (error) {
    announce(error.message, 12);
  }
}

/** The button that attaches files. */
export function attachButton(view) {
  const input = element("input", { type: "file", multiple: true, hidden: true, accept: place.dataset.endings });
  input.addEventListener("change", async () => {
    const files = [...input.files];
    input.value = "";
    await attach(view, files);
  });
  const choose = { type: "button", class: "quiet", id: "attach", onclick: () => input.click() };
  return [element("button", choose, "Attach files …"), input];
}

/** Deletes files, and attaches those that are dropped anywhere on the page. */
export function attachments(view) {
  if (document.body.dataset.maySubmit !== "true") return {};
  const main = document.querySelector("main");
  const files = (event) => event.dataTransfer?.types.includes("Files");
  place.addEventListener("click", (event) => {
    const button = event.target.closest("button[data-file]");
    if (button) remove(view, button);
  });
  document.addEventListener("dragover", (event) => {
    if (!files(event)) return;
    event.preventDefault();
    main.classList.add("over");
  });
  document.addEventListener("dragleave", (event) => {
    if (!event.relatedTarget) main.classList.remove("over");
  });
  document.addEventListener("drop", async (event) => {
    main.classList.remove("over");
    if (!files(event)) return;
    event.preventDefault();
    await attach(view, [...event.dataTransfer.files]);
  });
  return {};
}
