// A job, live: the events of its stream go to every part of the page.
import { announce, connection } from "../dom.js";
import { get } from "../http.js";
import { LATER, paced } from "../pace.js";
import { follow } from "../stream.js";
import { thinned } from "../scales.js";
import { openNamed } from "./evaluation.js";

const { job: id } = document.querySelector("main").dataset;
const POINTS = 3000,
  MOST = 9000,
  INTERVAL = 200;

/** What an event says of kernels that a worker compiles; null: it has ended. */
function compiling({ compiled = 0, missing, seconds }) {
  if (seconds !== null) return null;
  const counts = compiled ? ` ${compiled} of ${missing} groups are compiled.` : "";
  return `A worker compiles the numerical kernels: once after an installation.${counts}`;
}

function heading({ name, state, retrying }) {
  document.querySelector("h1 > span").textContent = name;
  const place = document.querySelector("h1 .state");
  place.className = `state ${state}`;
  place.textContent = retrying ? `${state} (failed evaluations again)` : state;
  document.querySelector("main").dataset.state = state;
}

/** The parts of a page, each made of `view` and updated by `job`, `course`, `generation` and `fit`. */
export async function live(makers) {
  const view = { id, job: await get(`/jobs/${id}`), course: [], fit: null };
  const follower = view.job.last_event; // what the generations below know already is passed over by their numbers
  view.refresh = async () => {
    view.job = await get(`/jobs/${id}`);
    heading(view.job);
    for (const part of parts) part.job?.(view.job);
  };
  view.changed = () => {
    for (const part of parts) part.fit?.();
  };
  const parts = makers.map((part) => part(view));
  heading(view.job);
  for (const part of parts) part.job?.(view.job);
  ({ items: view.course } = await get(`/jobs/${id}/generations`, { points: POINTS, limit: POINTS }));
  for (const part of parts) part.course?.();
  openNamed(view);

  let newest = null;
  const tell = paced(() => {
    for (const part of parts) part.generation?.(newest);
  }, INTERVAL);
  function take(generation) {
    const { number, evaluations: counted, failed, best_objective, objective, parameters } = generation;
    if (number <= (view.course.at(-1)?.number ?? -1)) return; // known already
    view.course.push({ number, evaluations: counted, best_objective, objective });
    if (view.course.length > MOST) view.course = thinned(view.course, POINTS);
    Object.assign(view.job, {
      evaluations: counted,
      failed_evaluations: failed,
      objective,
      parameters,
      generations: number + 1,
    });
    newest = generation;
    tell();
  }

  let busy = false,
    again = false;
  async function state() {
    if (busy) {
      again = true;
      return;
    }
    busy = true;
    do {
      again = false;
      const before = view.job.state;
      await view.refresh();
      if (view.job.state !== before) announce(`${view.job.name}: ${view.job.state}`);
    } while (again);
    busy = false;
  }
  function changed() {
    state().then(
      () => connection(null),
      (error) => {
        busy = false;
        connection(error.message);
        if (error.status === 0) setTimeout(changed, LATER);
      },
    );
  }
  follow(id, {
    after: follower,
    state: view.job.state,
    onConnection: (there) => connection(there ? null : "Connection lost; trying again …"),
    onEvent: ({ kind, data }) => {
      if (kind === "state") changed();
      else if (kind === "kernels") connection(compiling(data));
      else take(data);
    },
  });
}
