// The readings of a job with what was calculated there, for all parts of a page; and the units to show them in.
import { element } from "../dom.js";
import { get } from "../http.js";
import { paced } from "../pace.js";
import { choices, choose, converted } from "../units.js";

const INTERVAL = 2500;

/** Loads `view.fit`, in the chosen units, whenever there is a better evaluation; `onError` where it never came. */
export const readings =
  (onError = () => {}) =>
  (view) => {
    let objective,
      raw = null;
    view.inUnits = () => {
      view.fit = converted(raw);
      view.changed();
    };
    const load = paced(async () => {
      if (view.fit !== null && objective === view.job.objective) return;
      const wanted = view.job.objective;
      try {
        raw = await get(`/jobs/${view.id}/fit`);
      } catch (error) {
        if (error.status === 0) throw error;
        if (view.fit === null) onError(error);
        return;
      }
      objective = wanted;
      view.inUnits();
    }, INTERVAL);
    return {
      job: load,
      generation({ objective: best }) {
        if (best !== objective) load();
      },
    };
  };

/** Choices of the units of lengths, times and stresses, as far as a fit has them. */
export function unitChoices(view) {
  return choices(view.fit).map(({ family, name, units, chosen }) =>
    element(
      "label",
      { class: "beside" },
      name,
      element(
        "select",
        {
          onchange: ({ target }) => {
            choose(family, target.value || null);
            view.inUnits();
          },
        },
        element("option", { value: "" }, "as given"),
        units.map((unit) => element("option", { selected: unit === chosen }, unit)),
      ),
    ),
  );
}
