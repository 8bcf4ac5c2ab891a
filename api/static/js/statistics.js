// What is identified, how well, and what to do next.
import { alarm, doubt } from "./alarm.js";
import { announce, connection, element } from "./dom.js";
import { count, number, objectiveUnit } from "./format.js";
import { address, get } from "./http.js";
import { COLOURS } from "./ramp.js";
import { Cloud } from "./statistics/cloud.js";
import { FitPlot, affordable } from "./statistics/fit.js";
import { Matrix } from "./statistics/matrix.js";
import { Plan } from "./statistics/plan.js";
import { fetchPoints } from "./statistics/points.js";
import { rangeForm } from "./statistics/ranges.js";
import { ThresholdSlider } from "./statistics/threshold.js";
import { Uncertainty } from "./statistics/uncertainty.js";
import { correlationTable, typeset, verdictCards } from "./statistics/verdicts.js";
import { Weights } from "./statistics/weights.js";
import { ENDED } from "./states.js";
import { follow } from "./stream.js";

const RENEW_SECONDS = 4;
const { job, name, state, fitted } = document.querySelector("main").dataset;
const maySubmit = document.body.dataset.maySubmit === "true";
const place = (id) => document.getElementById(id);
/** `asked`: the threshold that the reader has chosen; null: the proposed one. */
const view = { cloud: null, threshold: null, asked: null, chosen: null, responses: null };
const parts = {};

/** Read everything anew, keeping what the reader has set. The plot does not wait for the verdicts. */
async function load() {
  const verdicts = fitted === "true" ? judged(view.asked) : null; // begun early where an answer is sure
  verdicts?.catch(() => {}); // told below, after the points
  const points = await fetchPoints(job);
  if (!points.count) {
    place("nothing").textContent = "No evaluation has succeeded yet, so there is nothing to judge.";
    return;
  }
  place("nothing").hidden = true;
  place("content").hidden = false;
  const { weights, ranges, reweighted } = view.cloud ?? {};
  view.cloud = new Cloud(points);
  if (ranges) view.cloud.ranges = ranges;
  if (reweighted) view.cloud.reweight(weights);
  view.responses = null;
  view.threshold ??= firstThreshold(view.cloud);
  build(points);
  showCloud();
  const [statistics] = await Promise.all([verdicts ?? judged(view.asked), band(points)]);
  if (!statistics) return;
  if (view.asked === null && !view.cloud.reweighted && view.threshold !== statistics.threshold.value) {
    view.threshold = statistics.threshold.value;
    showCloud();
  }
  showStatistics(statistics);
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

async function judged(threshold) {
  try {
    return await get(`/jobs/${job}/statistics`, { threshold });
  } catch (error) {
    if (error.status === 409) return null;
    throw error;
  }
}

function build(points) {
  const unit = objectiveUnit(points.series);
  const units = Object.fromEntries(points.parameters.map((parameter) => [parameter.name, parameter.unit]));
  parts.unit = unit;
  parts.units = units;
  parts.slider ??= new ThresholdSlider(place("filter"), { onInput: moved, onRest: rested, onProposed: proposed });
  parts.slider.fit(view.cloud, unit);
  parts.matrix ??= new Matrix(place("matrix"), { onRanges: limited });
  parts.ranges ??= rangeForm(place("ranges"), () => view.cloud, limited);
  parts.fit ??= new FitPlot(place("fit"), points.series);
  parts.weights ??= new Weights(place("weights"), { job, cloud: view.cloud, maySubmit, onWeights: reweighted });
  parts.weights.take(view.cloud);
  const best = Object.fromEntries(points.parameters.map(({ name: key }, i) => [key, points.values[i][view.cloud.best]]));
  if (maySubmit) parts.plan ??= new Plan(place("plan"), { job, name, parameters: points.parameters, best });
  else place("plan").hidden = true;
  if (!parts.uncertainty) {
    parts.uncertainty = new Uncertainty(place("uncertainty"), { job, maySubmit, units, objectiveUnit: unit, onFound: () => rested(view.asked) });
    parts.uncertainty.refresh();
  }
}

/** Everything that the browser draws from the points. */
function showCloud() {
  parts.slider.set(view.threshold);
  view.chosen = parts.matrix.show(view.cloud, view.threshold, parts.unit);
  tell();
}

function choose() {
  view.chosen = parts.matrix.update(view.threshold);
  tell();
}

function tell() {
  parts.slider.tell(view.chosen.length, view.cloud.kept(view.threshold));
  parts.ranges.show();
  parts.fit.update(view.cloud, view.chosen, view.responses);
  legend();
}

function moved(threshold) {
  view.threshold = view.asked = threshold;
  choose();
}

/** A moment after the slider stopped: the service judges anew, under the weights of the job. */
async function rested(threshold) {
  if (view.cloud.reweighted) return;
  try {
    const statistics = await judged(threshold);
    if (statistics && threshold === view.asked) showStatistics(statistics);
  } catch (error) {
    announce(error.message);
  }
}

async function proposed() {
  if (view.cloud.reweighted) reweighted(view.cloud.ownWeights);
  const statistics = await judged(view.asked = null);
  view.threshold = statistics.threshold.value;
  showStatistics(statistics);
  showCloud();
  parts.weights.show();
}

function limited() {
  choose();
}

/** Other weights: as many evaluations stay good fits as before. */
function reweighted(weights) {
  const { cloud } = view;
  const kept = Math.max(1, cloud.kept(view.threshold));
  if (!cloud.reweighted) view.before = view.threshold;
  cloud.reweight(weights);
  view.threshold = cloud.reweighted ? cloud.objective[cloud.order[kept - 1]] : view.before ?? view.threshold;
  parts.slider.fit(cloud, parts.unit);
  place("verdicts-note").hidden = !cloud.reweighted;
  if (cloud.reweighted) parts.slider.why.textContent = "Under other weights: as many good fits as before, unless you move the slider.";
  else if (view.statistics) showStatistics(view.statistics);
  showCloud();
}

function showStatistics(statistics) {
  view.statistics = statistics;
  const { threshold, verdicts, correlations, fit } = statistics;
  const warnings = statistics.warnings.filter((text) => !doubt(fit) || !text.startsWith(fit.sentence));
  place("alarm").replaceChildren(...alarm(fit));
  const names = verdicts.map(({ parameter }) => parameter);
  parts.slider.why.textContent = `f ≤ ${number(threshold.value, 4)}${parts.unit ? ` ${parts.unit}` : ""}: ${threshold.explanation}`;
  place("warnings").replaceChildren(...warnings.map((text) => element("li", {}, typeset(text, names))));
  place("verdicts").replaceChildren(...verdictCards(verdicts, parts.units, parts.plan));
  const details = place("correlations");
  details.replaceChildren(details.querySelector("summary"), correlationTable(correlations));
  const query = { threshold: threshold.origin === "given" ? threshold.value : null };
  const file = (text, path, download) => element("a", { class: "button quiet", href: address(`/jobs/${job}${path}`, path.startsWith("/report") || path.startsWith("/figures") ? query : {}), download }, text);
  place("downloads").replaceChildren(
    file("Report (PDF)", "/report.pdf", `report-${job}.pdf`), file("Report (page)", "/report.html", null), file("Matrix plot (SVG)", "/figures/matrix.svg", `matrix-${job}.svg`),
    file("Evaluations (CSV)", "/evaluations?format=csv", null), file("Statistics (JSON)", "/statistics", `statistics-${job}.json`));
}

function legend() {
  const bar = element("canvas", { width: COLOURS.length, height: 1, role: "img", "aria-label": "Colours of the good fits, from the best to the threshold" });
  const context = bar.getContext("2d");
  COLOURS.forEach((paint, i) => { context.fillStyle = paint; context.fillRect(i, 0, 1, 1); });
  const unit = parts.unit ? ` ${parts.unit}` : "";
  place("legend").replaceChildren(element("p", { class: "key" },
    element("span", {}, `f = ${number(view.cloud.quantile(0), 3)} `, bar, ` ${number(view.threshold, 3)}${unit}`),
    element("span", {}, element("i", {}, "— "), "lower envelope"), element("span", {}, element("i", {}, "+ "), "best"), element("span", {}, "- - threshold"), element("span", {}, "r: over natural values"),
    element("span", {}, `grey: the other ${count(view.cloud.count - view.chosen.length)}`)));
}

async function begin() {
  try {
    await load();
  } catch (error) {
    place("nothing").hidden = false;
    place("nothing").textContent = error.message;
    place("nothing").className = "error";
  }
}

let renewed = Date.now(), waiting = null;
function renew() {
  waiting ??= setTimeout(async () => {
    waiting = null;
    renewed = Date.now();
    await begin();
  }, Math.max(0, renewed + 1000 * RENEW_SECONDS - Date.now()));
}

await begin();
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
