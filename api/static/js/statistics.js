// What is identified, how well, and what to do next.
import { alarm } from "./alarm.js";
import { announce, connection, element, exchange } from "./dom.js";
import { count, number, objectiveUnit, typeset } from "./format.js";
import { address, get } from "./http.js";
import { addressValues, setAddressValues } from "./place.js";
import { COLOURS } from "./scales.js";
import { paced } from "./pace.js";
import { followUps } from "./remedies.js";
import { Cloud, natural, place as unitPlace } from "./statistics/cloud.js";
import { FitPlot, affordable } from "./statistics/fit.js";
import { Matrix } from "./statistics/matrix.js";
import { Outlook } from "./statistics/outlook.js";
import { Parallel } from "./statistics/parallel.js";
import { Plan } from "./statistics/plan.js";
import { fetchPoints } from "./statistics/points.js";
import { rangeForm } from "./statistics/ranges.js";
import { ThresholdSlider } from "./statistics/threshold.js";
import { Uncertainty } from "./statistics/uncertainty.js";
import { Surface } from "./statistics/surface.js";
import { correlationTable, verdictCards } from "./statistics/verdicts.js";
import { Weights } from "./statistics/weights.js";
import { ENDED } from "./states.js";
import { follow } from "./stream.js";

const RENEW = 4000; // ms
const { job, name, state, fitted, method } = document.querySelector("main").dataset;
const maySubmit = document.body.dataset.maySubmit === "true";
const place = (id) => document.getElementById(id);
/** `asked`: the threshold that the reader has chosen; null: the proposed one. */
const given = Number(addressValues().get("threshold"));
const begun = given > 0 && Number.isFinite(given) ? given : null;
const view = { cloud: null, threshold: begun, asked: begun, chosen: null, responses: null };
const parts = {};

/** Reload everything, keeping the reader's settings. The plot does not wait for the verdicts. */
async function load() {
  if (["predict", "design"].includes(method)) return looksAhead(); // nothing there is compared with readings
  const first = Promise.all([fetchPoints(job), get(`/jobs/${job}`)]);
  const verdicts = fitted === "true" ? judged(view.asked) : null; // begun early where an answer is sure
  verdicts?.catch(() => {}); // reported below, after the points
  const [points, { parameters: values, state: now }] = await first;
  if (!points.count || !values) {
    place("nothing").textContent = "No evaluation has succeeded yet, so there is nothing to judge.";
    return;
  }
  place("nothing").hidden = true;
  place("nothing").className = "empty";
  place("content").hidden = false;
  const { weights, ranges, reweighted } = view.cloud ?? {};
  view.cloud = new Cloud(points);
  if (reweighted) view.cloud.reweight(weights);
  if (ranges) view.cloud.ranges = ranges;
  else limitAsTold(view.cloud);
  view.responses = null;
  view.threshold ??= firstThreshold(view.cloud);
  build(points, values);
  place("surface").hidden = !ENDED.has(now);
  if (ENDED.has(now)) {
    parts.surface ??= new Surface(place("surface"), { job, parameters: points.parameters, unit: parts.unit });
    parts.surface.show();
  }
  showCloud();
  const [statistics] = await Promise.all([verdicts ?? judged(view.asked), band(points)]);
  if (!statistics) return;
  if (view.asked === null && !view.cloud.reweighted && view.threshold !== statistics.threshold.value) {
    view.threshold = statistics.threshold.value;
    showCloud();
  }
  showStatistics(statistics);
}

/** A prediction or a choice of tests: what it has found, and nothing else. */
async function looksAhead() {
  const found = await get(`/jobs/${job}/uncertainty`);
  for (const part of place("content").children) part.hidden = part.id !== "outlook";
  place("content").hidden = false;
  place("nothing").textContent = typeset(found.notes.join(" "));
  place("nothing").hidden = !found.notes.length;
  parts.outlook ??= new Outlook(place("outlook"), { job, maySubmit: false });
  parts.outlook.show(found);
}

/** What the service proposes of a sampling; shown until its answer is there. */
function firstThreshold(cloud) {
  const wanted = Math.max(1, Math.min(20 * cloud.size, Math.floor(cloud.count / 5)));
  return cloud.objective[cloud.order[wanted - 1]];
}

async function band(points) {
  if (!affordable(points)) return;
  const { responses } = await fetchPoints(job, { responses: true });
  if (points !== view.cloud.points) return;
  view.responses = responses;
  parts.fit.update(view.cloud, view.chosen, responses);
}

let asking = null;

/** Only the newest question is answered: what was asked before is broken off, here and in the service. */
async function judged(threshold) {
  asking?.abort();
  const mine = new AbortController();
  asking = mine;
  judging(threshold);
  try {
    return await get(`/jobs/${job}/statistics`, { threshold }, { signal: mine.signal });
  } catch (error) {
    if (error.status === 409 || error.name === "AbortError") return null;
    throw error;
  }
}

/** What the service says belongs to another threshold until it has judged this one: dimmed, with a word on it. */
function judging(threshold) {
  if (!view.statistics) return;
  const unit = parts.unit ? ` ${parts.unit}` : "";
  place("judging").textContent =
    `Updating the verdicts${threshold === null ? "" : ` for f ≤ ${number(threshold, 4)}${unit}`} … What is dimmed belongs to f ≤ ${number(view.statistics.threshold.value, 4)}${unit}.`;
  place("judged").setAttribute("aria-busy", "true");
}

function settled() {
  place("judging").textContent = "";
  place("judged").removeAttribute("aria-busy");
}

/** `values`: the job's, of the minimum where it has gone there; a follow-up starts from these. */
function build(points, values) {
  const unit = objectiveUnit(points.series);
  const units = Object.fromEntries(points.parameters.map((parameter) => [parameter.name, parameter.unit]));
  parts.unit = unit;
  parts.units = units;
  parts.slider ??= new ThresholdSlider(place("filter"), { onInput: moved, onRest: rested, onProposed: proposed });
  parts.slider.fit(view.cloud, unit);
  parts.matrix ??= new Matrix(place("matrix"), { onRanges: limited });
  parts.parallel ??= new Parallel(place("parallel"), { onRanges: limited });
  parts.ranges ??= rangeForm(place("ranges"), () => view.cloud, limited);
  parts.fit ??= new FitPlot(place("fit"), points.series);
  parts.weights ??= new Weights(place("weights"), { job, cloud: view.cloud, maySubmit, onWeights: reweighted });
  parts.weights.take(view.cloud);
  if (maySubmit) parts.plan ??= new Plan(place("plan"), { job, name, parameters: points.parameters, best: values });
  else place("plan").hidden = true;
  if (!parts.uncertainty) {
    parts.outlook = new Outlook(place("outlook"), { job, maySubmit, onBegun: () => parts.uncertainty.refresh() });
    parts.uncertainty = new Uncertainty(place("uncertainty"), {
      job,
      maySubmit,
      units,
      objectiveUnit: unit,
      onFound: () => rested(view.asked),
      onCosts: (costs) => parts.plan?.price(costs.get("again")),
      onAnswer: (found) => parts.outlook.show(found),
    });
    parts.uncertainty.refresh();
  }
}

/** Everything that the browser draws from the points. */
function showCloud() {
  parts.slider.set(view.threshold);
  view.chosen = parts.matrix.show(view.cloud, view.threshold, parts.unit);
  parts.parallel.show(view.cloud, view.threshold, view.chosen, parts.unit);
  tell();
}

function choose() {
  view.chosen = parts.matrix.update(view.threshold);
  parts.parallel.update(view.threshold, view.chosen);
  tell();
}

function tell() {
  parts.slider.tell(view.chosen.length, view.cloud.kept(view.threshold));
  parts.ranges.show();
  advise();
  parts.fit.update(view.cloud, view.chosen, view.responses);
  legend();
}

/** Ranges without a good fit empty the plots: said, with both ways out of it. */
function advise() {
  const lost = view.cloud.ranges.size > 0 && view.chosen.length === 0;
  place("advice").hidden = !lost;
  if (!lost) return;
  const all = view.cloud.inside();
  const lowest = all.length ? view.cloud.objective[all[0]] : null;
  exchange(
    place("advice"),
    `No good fit lies inside these ranges${lowest === null ? ", and no other evaluation either" : `: the best evaluation there has f = ${number(lowest, 4)}`}. `,
    lowest === null
      ? null
      : element(
          "button",
          {
            type: "button",
            class: "quiet small",
            onclick: () => {
              const f = lowest * (1 + 1e-6);
              parts.slider.moved(f);
            },
          },
          "Raise the threshold to it",
        ),
    element(
      "button",
      {
        type: "button",
        class: "quiet small",
        onclick: () => {
          view.cloud.ranges.clear();
          limited();
        },
      },
      "Remove the ranges",
    ),
  );
}

function moved(threshold) {
  view.threshold = view.asked = threshold;
  if (!view.cloud.reweighted) {
    setAddressValues({ threshold: String(Number(threshold.toPrecision(7))) });
    asking?.abort();
    judging(threshold);
  }
  choose();
}

/** A moment after the slider stopped: the service recalculates the verdicts, under the weights of the job. */
async function rested(threshold) {
  if (view.cloud.reweighted) return;
  try {
    const statistics = await judged(threshold);
    if (statistics && threshold === view.asked) showStatistics(statistics);
  } catch (error) {
    announce(error.message);
    place("judging").textContent = `${error.message} What is dimmed belongs to another threshold.`;
  }
}

async function proposed() {
  if (view.cloud.reweighted) reweighted(view.cloud.ownWeights);
  setAddressValues({ threshold: null });
  const statistics = await judged((view.asked = null));
  if (!statistics) return;
  view.threshold = statistics.threshold.value;
  showStatistics(statistics);
  showCloud();
  parts.weights.show();
}

function limited() {
  choose();
  rememberRanges();
}

/** The ranges in the address, as natural values: ?range.c=5..20. */
function rememberRanges() {
  const { cloud } = view;
  setAddressValues(
    Object.fromEntries(
      cloud.parameters.map((parameter, i) => {
        const range = cloud.ranges.get(i);
        return [
          `range.${parameter.name}`,
          range ? range.map((unit) => Number(natural(parameter, unit).toPrecision(5))).join("..") : null,
        ];
      }),
    ),
  );
}

function limitAsTold(cloud) {
  cloud.parameters.forEach((parameter, i) => {
    const ends = addressValues().get(`range.${parameter.name}`)?.split("..").map(Number);
    if (ends?.length === 2 && ends.every(Number.isFinite))
      cloud.limit(
        i,
        ends.map((value) => Math.max(0, Math.min(1, unitPlace(parameter, value) || 0))).sort((a, b) => a - b),
      );
  });
}

/** Other weights: as many evaluations stay good fits as before. */
function reweighted(weights) {
  const { cloud } = view;
  const kept = Math.max(1, cloud.kept(view.threshold));
  if (!cloud.reweighted) view.before = view.threshold;
  cloud.reweight(weights);
  view.threshold = cloud.reweighted ? cloud.objective[cloud.order[kept - 1]] : (view.before ?? view.threshold);
  parts.slider.fit(cloud, parts.unit);
  place("verdicts-note").hidden = !cloud.reweighted;
  if (cloud.reweighted)
    parts.slider.why.textContent = "Other weights keep the number of good fits unless you move the slider.";
  else if (view.statistics) showStatistics(view.statistics);
  showCloud();
}

function showStatistics(statistics) {
  view.statistics = statistics;
  settled();
  const { threshold, verdicts, correlations, fit } = statistics;
  const warnings = [...(fit.kind === "untested" ? [fit.sentence] : []), ...statistics.warnings]; // all else is in the alarm
  place("alarm").replaceChildren(...alarm(fit, job));
  parts.slider.why.textContent = `f ≤ ${number(threshold.value, 4)}${parts.unit ? ` ${parts.unit}` : ""}: ${typeset(threshold.explanation)}`;
  const start = parts.plan ? (kind) => parts.uncertainty.start(kind) : null;
  const steps = [...(fit.kind === "untested" ? fit.what_to_do : []), ...statistics.basins.what_to_do];
  place("warnings").replaceChildren(
    ...warnings.map((text) => element("li", {}, typeset(text))),
    ...followUps(steps).map((step) => element("li", {}, step)),
  );
  place("verdicts").replaceChildren(...verdictCards(verdicts, parts.units, parts.plan, start));
  const details = place("correlations");
  details.replaceChildren(details.querySelector("summary"), correlationTable(correlations));
  const query = { threshold: threshold.origin === "given" ? threshold.value : null };
  const file = (text, path, download) =>
    element(
      "a",
      {
        class: "button quiet",
        href: address(`/jobs/${job}${path}`, path.startsWith("/report") || path.startsWith("/figures") ? query : {}),
        download,
      },
      text,
    );
  place("downloads").replaceChildren(
    file("Report (PDF)", "/report.pdf", `report-${job}.pdf`),
    file("Report (page)", "/report.html", null),
    file("Matrix plot (SVG)", "/figures/matrix.svg", `matrix-${job}.svg`),
    file("Evaluations (CSV)", "/evaluations?format=csv", null),
    file("Statistics (JSON)", "/statistics", `statistics-${job}.json`),
  );
}

function legend() {
  const bar = element("canvas", {
    width: COLOURS.length,
    height: 1,
    role: "img",
    "aria-label": "Colours of the good fits, from the best to the threshold",
  });
  const context = bar.getContext("2d");
  COLOURS.forEach((paint, i) => {
    context.fillStyle = paint;
    context.fillRect(i, 0, 1, 1);
  });
  const unit = parts.unit ? ` ${parts.unit}` : "";
  place("legend").replaceChildren(
    element(
      "p",
      { class: "key" },
      element("span", {}, `f = ${number(view.cloud.quantile(0), 3)} `, bar, ` ${number(view.threshold, 3)}${unit}`),
      element("span", {}, element("i", {}, "— "), "lower envelope"),
      element("span", {}, element("i", {}, "+ "), "best"),
      element("span", {}, "- - threshold"),
      element("span", {}, "r: over natural values"),
      element("span", {}, `grey: the other ${count(view.cloud.count - view.chosen.length)}`),
    ),
  );
}

async function begin() {
  try {
    await load();
  } catch (error) {
    place("nothing").hidden = false;
    place("nothing").textContent = error.message;
    place("nothing").className = "error";
    if (error.status === 0) throw error; // asked again later
  }
}

/** A search may be quicker than its verdicts: what is new waits for the answer to what is asked already. */
const renew = paced(begin, RENEW);
renew();
if (!ENDED.has(state)) {
  follow(job, {
    state,
    onEvent: ({ kind, data }) => {
      if (kind === "state") {
        const shown = document.querySelector("h1 .state");
        shown.textContent = data.state;
        shown.className = `state ${data.state}`;
      }
      renew();
    },
    onConnection: (there) => connection(there ? null : "Connection lost; trying again …"),
  });
}
