// What comes next: predictions with the uncertainty of what was identified, and which test to do next.
import { element, once, tableHead, wide } from "../dom.js";
import { amount, direction, number, partOf, percent, plain, symbol, typeset, withUnit } from "../format.js";
import { get, post } from "../http.js";
import { DASHES, colour, palette, plot } from "../plot.js";

const CRITERIA = {
  widths: "all intervals (geometric mean)",
  volume: "their common region",
  prediction: "the band of the prediction",
};

const MOST_OPEN = 3; // tests whose curves are drawn at once

/** Two forms, and the bands and tables that follow-ups have found; `onBegun` after a follow-up was submitted. */
export class Outlook {
  constructor(holder, { job, maySubmit, onBegun }) {
    Object.assign(this, { job, onBegun, plots: [], drawn: "" });
    this.bands = element("div");
    this.designs = element("div");
    holder.append(
      ...(maySubmit
        ? [
            this.form(
              "predict",
              "Predict",
              "The problem that is predicted, as YAML or JSON: its forward model, where it is wanted (points with x), and parameters that this job did not identify",
              () => this.otherProblem(),
              (text) => ({ problem: text }),
            ),
            this.form(
              "design",
              "Which test next?",
              "Candidate tests or measuring points without values, as YAML or JSON",
              () => this.someCandidates(),
              (text) => ({ candidates: text }),
            ),
          ]
        : []),
      this.bands,
      this.designs,
    );
    if (!maySubmit)
      this.bands.append(
        element("p", { class: "help" }, "Predictions and candidate tests appear here once they have been requested."),
      );
  }

  form(path, title, help, proposed, body) {
    const area = element("textarea", {
      rows: "14",
      spellcheck: "false",
      autocomplete: "off",
      wrap: "off",
      "aria-label": help,
    });
    const message = element("p", { class: "error", role: "alert" });
    const send = element(
      "button",
      {
        type: "button",
        onclick: ({ currentTarget }) =>
          once(currentTarget, async () => {
            message.textContent = "";
            try {
              await post(`/jobs/${this.job}/${path}`, body(area.value));
              this.onBegun();
            } catch (error) {
              message.textContent = error.message;
            }
          }),
      },
      title,
    );
    const file = element("input", {
      type: "file",
      accept: ".yaml,.yml,.json",
      "aria-label": `File: ${title}`,
      onchange: async () => {
        if (file.files[0]) area.value = await file.files[0].text();
      },
    });
    return element(
      "details",
      {
        ontoggle: async ({ currentTarget }) => {
          if (!currentTarget.open || area.value) return;
          try {
            area.value = await proposed();
          } catch (error) {
            message.textContent = error.message;
          }
        },
      },
      element("summary", {}, title),
      element("p", { class: "help" }, `${help}.`),
      file,
      area,
      element("p", { class: "buttons" }, send),
      message,
    );
  }

  /** The job's own problem to begin with: other stages, another height, a later time. */
  async otherProblem() {
    const { forward_model, parameters, constraints, observations } = await get(`/jobs/${this.job}/problem`);
    const fixed = Object.fromEntries(
      Object.entries(parameters).filter(([, one]) => "value" in one || "expression" in one),
    );
    return JSON.stringify(
      { name: "prediction", forward_model, parameters: fixed, constraints, observations: observations.map(places) },
      null,
      1,
    );
  }

  async someCandidates() {
    const { observations } = await get(`/jobs/${this.job}/problem`);
    return JSON.stringify(
      {
        candidates: observations.map((one) => ({
          name: `${one.series} once more`,
          observations: [{ ...places(one), ...(one.error ? { error: one.error } : {}) }],
        })),
      },
      null,
      1,
    );
  }

  show({ predictions, designs }) {
    const now = JSON.stringify([predictions, designs]);
    if (now === this.drawn) return;
    this.drawn = now;
    for (const one of this.plots) one.remove();
    this.plots = [];
    if (predictions.length || designs.length)
      this.bands.replaceChildren(...predictions.flatMap((one) => this.band(one)));
    for (const one of this.plots) one.draw();
    this.designs.replaceChildren(...designs.flatMap((one) => this.order(one)));
  }

  band(prediction) {
    const warning = prediction.alarm ? [element("p", { class: "error" }, typeset(prediction.alarm))] : [];
    const tests = [...new Set(prediction.series.map(({ series }) => partOf(series)))];
    return [
      element("h3", {}, `Prediction: ${prediction.name}`),
      ...warning,
      ...prediction.remarks.map((text) => element("p", { class: "help" }, typeset(text))),
      ...tests.map((test) => this.test(prediction, test, tests.length > MOST_OPEN)),
    ];
  }

  /** One test: how close its series come to what was measured, and their bands; `folded`: these are drawn once asked for. */
  test(prediction, test, folded) {
    const own = prediction.series.filter(({ series }) => partOf(series) === test);
    const measured = own.filter((one) => one.measured);
    const heading = test ? [element("h4", {}, test)] : [];
    const list = measured.length
      ? [
          element(
            "ul",
            {},
            measured.map((one) =>
              element("li", {}, element("strong", {}, nameOf(one)), `: ${closeness(prediction, one)}`),
            ),
          ),
        ]
      : [];
    const curves = element("div", { class: "curves" });
    const draw = () =>
      own.map((one) => {
        const place = element("div");
        curves.append(element("div", {}, element(test ? "h5" : "h4", {}, nameOf(one)), place));
        const made = plot(place, () => bandFigure(prediction, one));
        this.plots.push(made);
        return made;
      });
    if (!folded) draw();
    const shown = folded
      ? element(
          "details",
          {
            ontoggle: ({ currentTarget }) => {
              if (currentTarget.open && !curves.children.length) for (const one of draw()) one.draw();
            },
          },
          element("summary", {}, `Curves of ${test}`),
          curves,
        )
      : curves;
    return element("section", { "aria-label": test || prediction.name }, ...heading, ...list, shown);
  }

  order(design) {
    const names = Object.keys(design.candidates[0].parameters),
      several = design.basins > 1,
      costs = design.candidates[0].cost !== null;
    const head = [
      "Candidate",
      "Readings",
      ...names.map(symbol),
      "All",
      "Region",
      ...(design.predicted === null ? [] : [design.predicted]),
      ...(several ? ["Tells basins apart"] : []),
      ...(costs ? ["Cost", "Per cost"] : []),
    ];
    const part = (value) => (value === null ? "–" : percent(value));
    const cells = (one) => [
      String(one.readings),
      ...names.map((name) => part(one.parameters[name])),
      part(one.widths),
      part(one.volume),
      ...(design.predicted === null ? [] : [part(one.prediction)]),
      ...(several ? [part(one.distinguishes)] : []),
      ...(costs ? [number(one.cost), number(one.per_cost, 3)] : []),
    ];
    const rows = design.candidates.map((one) =>
      element(
        "tr",
        {},
        element("th", { scope: "row" }, one.name),
        cells(one).map((text) => element("td", { class: "n" }, text)),
      ),
    );
    return [
      element("h3", {}, "Which test next"),
      ...(design.alarm ? [element("p", { class: "error" }, typeset(design.alarm))] : []),
      element(
        "p",
        {},
        `Take first: ${design.candidates[0].name}. Expected reduction of the width of each 95 % interval; the order is by ${CRITERIA[design.criterion]}.`,
      ),
      wide(
        "Candidate tests",
        element(
          "table",
          {},
          tableHead(head, (i) => i > 0),
          element("tbody", {}, rows),
        ),
      ),
      ...design.remarks.map((text) => element("p", { class: "help" }, typeset(text))),
    ];
  }
}

const nameOf = ({ series }) => plain(series.slice(partOf(series).length).replace(".", ""));

/** How far the measured points are from the curve of the best fit, and how many of them lie in the band. */
function closeness({ level }, { closeness: found, inside, x, reading_lower: reading }) {
  const band = `${inside} of ${x.length} measured points lie in the ${percent(level)} band${reading ? " of readings" : ""}`;
  if (!found) return `${band}.`;
  const peak = found.peak === null ? "" : `, peak within ${percent(found.peak)}`;
  return `root mean square ${amount(found.deviation, found.unit)}, at most ${amount(found.largest, found.unit)}${peak}; ${band}.`;
}

const places = ({ series, points, x_unit, y_unit }) => ({
  series,
  ...(x_unit ? { x_unit } : {}),
  ...(y_unit ? { y_unit } : {}),
  points: { x: thinned(points.x) },
});
const thinned = (x) => x.filter((_, i) => i % Math.ceil(x.length / 60) === 0 || i === x.length - 1);

function bandFigure({ level, basins }, one) {
  const [blue, ...others] = palette();
  const text = `${percent(level)} band`;
  const edge = (y, more) => ({ x: one.x, y, mode: "lines", hoverinfo: "skip", line: { width: 0 }, ...more });
  const dotted = (y, show) =>
    edge(y, {
      name: `${percent(level)} of readings`,
      showlegend: show,
      line: { color: colour("--muted"), width: 1, dash: "dot" },
    });
  const data = [
    edge(one.lower, { showlegend: false }),
    edge(one.upper, { name: text, fill: "tonexty", fillcolor: translucent(blue) }),
  ];
  if (one.reading_lower) data.push(dotted(one.reading_lower, true), dotted(one.reading_upper, false));
  if (basins.length > 1)
    one.basins.forEach(({ optimum }, i) => {
      if (optimum)
        data.push({
          x: one.x,
          y: optimum,
          mode: "lines",
          name: `basin ${i + 1}, ${percent(basins[i].share)}`,
          line: { color: others[i % others.length], dash: DASHES[1 + (i % 3)], width: 1.5 },
        });
    });
  data.push({
    x: one.x,
    y: one.median,
    mode: one.x.length > 12 ? "lines" : "lines+markers",
    name: "median",
    line: { color: blue },
  });
  if (one.measured)
    data.push({
      x: one.x,
      y: one.measured,
      mode: "markers",
      name: "measured",
      marker: { color: colour("--ink"), symbol: "circle-open" },
    });
  const title = (words) => ({ title: { text: words } });
  const columns = {
    [withUnit(one.x_quantity, one.x_unit)]: one.x,
    median: one.median,
    lower: one.lower,
    upper: one.upper,
  };
  return {
    data,
    layout: {
      height: 340,
      xaxis: title(withUnit(one.x_quantity, one.x_unit)),
      yaxis: { ...title(withUnit(one.y_quantity, one.y_unit)), ...direction(one.series, one.y_quantity) },
    },
    label: `Prediction of ${one.series}: median and ${text}`,
    columns,
  };
}

/** A colour of the palette, #rrggbb or rgb(), that lets others through. */
function translucent(text) {
  const hex = /^#([0-9a-f]{2})([0-9a-f]{2})([0-9a-f]{2})$/i.exec(text.trim());
  return hex
    ? `rgba(${hex
        .slice(1)
        .map((two) => parseInt(two, 16))
        .join(",")},0.25)`
    : text.replace(/^rgb\(/, "rgba(").replace(/\)$/, ",0.25)");
}
