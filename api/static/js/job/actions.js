// What can be done with a job in its state.
import { announce, confirmed, element, once } from "../dom.js";
import { post, send } from "../http.js";
import { leave } from "../pace.js";
import { ENDED, OPEN } from "../states.js";
import { attachButton } from "./attachments.js";
import { extend } from "./extend.js";
import { label } from "./label.js";
import { links } from "./links.js";

export function actions(view) {
  const place = document.getElementById("actions");
  const may = document.body.dataset.maySubmit === "true";
  let shown = "";

  const act = (button, work, said) =>
    once(button, async () => {
      try {
        await work();
        await view.refresh();
        announce(said);
      } catch (error) {
        announce(error.message, 12);
        await view.refresh().catch(() => {}); // the stream reports a lost connection
      }
    });

  /** `asked`: question and answer to it, without which nothing is done. */
  function button(label, kind, work, said, asked = null) {
    const made = element(
      "button",
      {
        type: "button",
        class: kind,
        onclick: async () => {
          if (!asked || (await confirmed(...asked))) act(made, work, said);
        },
      },
      label,
    );
    return made;
  }

  function buttons({ id, name, state, retrying, failed_evaluations: failed }) {
    const list = [];
    if ((state === "queued" || state === "running") && !retrying)
      list.push(button("Pause", "quiet", () => post(`/jobs/${id}/pause`), "Paused."));
    if (state === "paused") list.push(button("Resume", "", () => post(`/jobs/${id}/resume`), "Resumed."));
    if (state === "finished" || state === "cancelled" || OPEN.has(state)) {
      list.push(
        element(
          "button",
          { type: "button", class: "quiet", onclick: () => extend(view) },
          ENDED.has(state) ? "Continue …" : "Change stop criteria …",
        ),
      );
    }
    if (failed && (state === "paused" || ENDED.has(state))) {
      list.push(
        button(
          "Rerun failed evaluations",
          "quiet",
          () => post(`/jobs/${id}/retry-failed`),
          "The failed evaluations are rerun.",
        ),
      );
    }
    list.push(
      element("button", { type: "button", class: "quiet", onclick: () => label(view) }, "Name, tags and note …"),
    );
    list.push(...attachButton(view));
    if (place.dataset.links)
      list.push(element("button", { type: "button", class: "quiet", onclick: () => links(view) }, "Share …"));
    list.push(element("a", { class: "button quiet", href: `/new?from=${id}` }, "Clone"));
    if (OPEN.has(state)) {
      list.push(
        button("Cancel", "danger", () => post(`/jobs/${id}/cancel`), "", [
          `Cancel “${name}” now? Results so far are kept.`,
          "Cancel the job",
        ]),
      );
    } else {
      list.push(
        button(
          "Delete",
          "danger",
          async () => {
            leave(true);
            try {
              await send("DELETE", `/jobs/${id}`);
            } catch (error) {
              leave(false);
              throw error;
            }
            location.assign("/");
            await new Promise(() => {}); // the page goes
          },
          "",
          [`Delete “${name}” and all its evaluations permanently?`, "Delete the job"],
        ),
      );
    }
    return list;
  }

  return {
    job(job) {
      const now = JSON.stringify([job.name, job.state, job.retrying, Boolean(job.failed_evaluations)]);
      if (!may || now === shown) return;
      const held = place.contains(document.activeElement);
      shown = now;
      place.replaceChildren(...buttons(job));
      if (held) place.querySelector("button, a")?.focus();
    },
    generation() {
      this.job(view.job);
    },
  };
}
