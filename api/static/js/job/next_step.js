// One next step, with what it takes: what the data can tell, how far to trust it, then the report.
import { FOLLOW_UPS, affordable, costWords } from "../costs.js";
import { element, exchange, once } from "../dom.js";
import { percent, symbol, typeset } from "../format.js";
import { get, post } from "../http.js";
import { recalculate, withParameters } from "../remedies.js";
import { OPEN } from "../states.js";

const AGAIN = 2000,
  SPARSE = 0.1;
const PATHS = { sensitivity: "sensitivity", profile: "profile", explore: "explore" };

/** The bound that the data pull beyond: a proposal to widen it, if there is one. */
export const widening = (verdicts) =>
  verdicts.flatMap(({ proposals }) => proposals).find(({ kind }) => kind === "widen");

/** What to do after the statistics of a job: {kind, words, why}; kind null is a link, "again" the job with a change. */
export function proposed({ linearisation, fit, basins, verdicts }, bounds = []) {
  if (!linearisation || !linearisation.at_optimum)
    return {
      kind: "sensitivity",
      words: "Find out what the data can tell",
      why: "Goes to the minimum and calculates intervals there.",
    };
  const wider = widening(verdicts);
  if (wider) {
    const { parameter, changes, sentence } = wider;
    const searched = bounds.find(({ name }) => name === parameter);
    const side = searched && (changes.parameters[parameter].lower < searched.lower ? "lower" : "upper");
    return {
      kind: "again",
      words: `Widen the ${side ? `${side} bound` : "bounds"} of ${symbol(parameter)}`,
      why: typeset(sentence),
      change: (problem) => withParameters(problem, changes.parameters),
    };
  }
  if (fit.kind === "lack_of_fit")
    return {
      kind: null,
      words: "Change the problem and calibrate again",
      why: "Leave out what the model does not contain, or use another law.",
      path: (id) => `/new?from=${id}`,
    };
  if (Object.values(linearisation.parameters).some(({ needs_profile: needed }) => needed))
    return {
      kind: "profile",
      words: "Follow the bend of the intervals",
      why: "The model is nonlinear inside an interval: profiles give its true ends.",
    };
  if (basins.unfinished.length || basins.untried.length)
    return {
      kind: "explore",
      words: "Look for another set of parameters that fits",
      why: basins.unfinished.length
        ? "Some runs point to another basin that the search did not explore."
        : "Parameters may be interchangeable: no run has tried swapped values.",
    };
  if ((basins.hidden ?? 0) > SPARSE)
    return {
      kind: "explore",
      words: "Look for another set of parameters that fits",
      why: `${percent(basins.hidden)} of the searched space could still contain one.`,
    };
  return {
    kind: null,
    words: "Get the report",
    why: "No further step is needed.",
    path: (id) => `/api/v1/jobs/${id}/report.html`,
  };
}

export function nextStep(view, place, onFound) {
  const may = document.body.dataset.maySubmit === "true";
  const message = element("p", { class: "error", role: "alert" });
  const home = place.parentNode,
    after = place.nextElementSibling;
  let timer = null;

  /** Below a long alarm a step would be off the first screen: what is changed by it is part of what to do. */
  function settle(step) {
    const inside = step?.change && document.querySelector("#alarm .step");
    if (inside) inside.append(place);
    else home.insertBefore(place, after);
  }

  async function begin(step, cost) {
    message.textContent = "";
    try {
      if (step.change) return void (await recalculate(view.id, step.words, step.change));
      if (!(await affordable(step.words, cost))) return;
      await watch(await post(`/jobs/${view.id}/${PATHS[step.kind]}`, {}));
    } catch (error) {
      message.textContent = error.message;
    }
  }

  /** The follow-up as it runs, until it has ended: then the answer is a new one. */
  async function watch(job) {
    clearTimeout(timer);
    const open = OPEN.has(job.state);
    exchange(
      place,
      element(
        "p",
        {},
        element("a", { href: `/jobs/${job.id}` }, FOLLOW_UPS[job.method] ?? job.name),
        ` is ${job.state}: ${job.evaluations} runs so far. `,
        open
          ? element(
              "button",
              {
                type: "button",
                class: "danger small",
                onclick: ({ currentTarget }) => once(currentTarget, () => cancel(job)),
              },
              "Cancel it",
            )
          : null,
      ),
      message,
    );
    if (!open) return onFound();
    timer = setTimeout(async () => {
      try {
        await watch(await get(`/jobs/${job.id}`));
      } catch (error) {
        message.textContent = error.message;
      }
    }, AGAIN);
  }

  async function cancel(job) {
    try {
      await watch(await post(`/jobs/${job.id}/cancel`));
    } catch (error) {
      message.textContent = error.message;
    }
  }

  return {
    async show() {
      const there = view.statistics.fit.kind === "lack_of_fit" && document.querySelector("#alarm button");
      const step = there ? null : proposed(view.statistics, view.fit?.parameters);
      settle(step);
      if (there) return void exchange(place);
      const why = element("p", { class: "help" }, step.why);
      if (step.kind === null)
        return void exchange(
          place,
          element(
            "a",
            {
              class: "button",
              href: step.path(view.id),
              target: step.path(view.id).startsWith("/api") ? "_blank" : null,
              rel: "noopener",
            },
            step.words,
          ),
          why,
        );
      if (!may) return void exchange(place, why);
      let cost = null;
      try {
        const [{ items }, { follow_ups: found }] = await Promise.all([
          get(`/jobs/${view.id}/follow-ups`),
          get(`/jobs/${view.id}/uncertainty`),
        ]);
        const running = found.find((one) => one.kind === step.kind && OPEN.has(one.state));
        if (running) return void (await watch(await get(`/jobs/${running.id}`)));
        cost = items.find((one) => one.kind === step.kind);
      } catch (error) {
        message.textContent = error.message;
      }
      if (cost?.refused) return void exchange(place, element("p", { class: "help" }, typeset(cost.refused)));
      const button = element(
        "button",
        { type: "button", title: step.why, onclick: () => once(button, () => begin(step, cost)) },
        `${step.words}${step.change ? " and recalculate" : ""}`,
        cost ? element("small", {}, costWords(cost)) : null,
      );
      exchange(place, button, why, message);
    },
  };
}
