// What was measured: readings of series, their units and weights, and the share of each weight.
import { announce, element, empty, exchange } from "../dom.js";
import { count, percent } from "../format.js";
import { errorPlace, field, idOf } from "./fields.js";
import { flag } from "./import/inputs.js";
import { leftOut, prepared } from "./import/preparation.js";
import { pointsPlot } from "./points_plot.js";
import { button } from "./schema_form.js";
import { uploader } from "./upload.js";
import { unitsOf } from "./units.js";

const DISTANCES = [
  [undefined, "differences of y"],
  ["orthogonal", "distances from the curve"],
];
const LOSSES = [
  [undefined, "count as every reading"],
  ["soft_l1", "soft_l1: count less, smoothly"],
  ["huber", "huber: count by their distance"],
  ["cauchy", "cauchy: hardly count"],
];
const SCHEMES = [
  [undefined, "as given"],
  ["by_error", "by error: precision of the readings"],
  ["by_count", "by count: every reading counts alike"],
  ["by_range", "by range: relative to the range of each series"],
  ["by_test", "by test: every test counts alike, and every series in it"],
];

const LONGEST = 20_000; // characters of a forward model that the service takes with a file

export function observationsSection(context, place) {
  const { draft } = context;
  const list = element("div", {}),
    scheme = element("div", {}),
    look = element("div", {});
  const all = () => {
    const given = draft.read(["observations"]);
    return Array.isArray(given) ? given : [];
  };
  const series = () => draft.model().series;
  const info = (name) => series().find((one) => one.name === name);
  let shownSeries = null,
    plot = null,
    drawnFor = "";

  const upload = uploader(
    {
      series,
      readings: (name) => all().find((one) => one.series === name)?.points?.x?.length ?? 0,
      openParameters: () => Boolean(draft.answer?.open_parameters),
      begun: context.begun,
      document: () => draft.document,
      staged: () => {
        const item = stagesItem();
        return Boolean(item?.stress && item.duration);
      },
      stages: () => draft.read(["forward_model", "stages"]),
      forwardModel: () => {
        const text = JSON.stringify(draft.read(["forward_model"]) ?? {});
        return text.length < LONGEST ? text : undefined;
      },
      materials: context.root.$defs.forward_model_oedometer?.properties.material?.enum ?? [],
    },
    { take, replace, stages, replaced: (act) => draft.on("undo", act) },
  );

  const sectionOf = () =>
    context.root.$defs[`forward_model_${draft.read(["forward_model", "kind"])}`]?.properties ?? {};
  /** What a series is; of a formula its author says so, or the formula itself does. */
  const described = (about) =>
    about && draft.read(["forward_model", "kind"]) === "formula"
      ? element("span", { translate: "no" }, about.description)
      : about?.description;
  const stagesItem = () => {
    const list_ = sectionOf().stages;
    return list_?.items && context.schemas.resolve(list_.items).properties;
  };

  /** Stages of the forward model from a file. */
  async function stages(found, file) {
    const back = draft.mark(),
      old = draft.read(["forward_model", "stages"]);
    const initial =
      found.initial_stress && "initial_stress" in sectionOf() ? { initial_stress: found.initial_stress } : {};
    const given = found.stages.map(({ stress, duration }) => ({ stress, duration }));
    draft.replace({ ...draft.document, forward_model: { ...draft.document.forward_model, ...initial, stages: given } });
    if (old?.length) back(`${count(old.length)} stages were replaced by the ${count(given.length)} of ${file}.`);
    else announce(`${count(given.length)} stages were taken from ${file}.`);
    await draft.judge().catch(() => null);
  }

  /** A problem instead of the present one; returns whether it announced the change. */
  function replace(problem, words) {
    const back = draft.mark(),
      begun = context.begun();
    draft.replace(problem);
    if (begun) back(words);
    return begun;
  }

  /** New readings instead of old ones keep what does not depend on these: weights and stages, no marks or zero readings. */
  function take(observation, file) {
    const same = all().findIndex((one) => one.series === observation.series);
    const old = same >= 0 ? all()[same] : {};
    const kept = Object.fromEntries(
      ["weight", "leave_out_stages"].filter((key) => old[key] !== undefined).map((key) => [key, old[key]]),
    );
    const back = draft.mark();
    draft.write(["observations", same >= 0 ? same : all().length], { ...kept, ...observation });
    if (old.points)
      back(`${count(old.points.x.length)} readings of ${observation.series} were replaced by those of ${file}.`);
    shownSeries = observation.series;
    draw();
    return Boolean(old.points);
  }

  function card(one, i) {
    const path = ["observations", i];
    const names = series().map(({ name }) => [name, name]);
    const about = info(one.series);
    const points = one.points?.x?.length;
    const unit = (axis) => {
      const made = field(draft, [...path, `${axis}_unit`], {
        label: `Unit of ${about?.[`${axis}_quantity`] ?? axis}`,
        fallback: about?.[`${axis}_unit`] || "dimensionless",
        onchange: redrawPlot,
      });
      const id = `${idOf([...path, `${axis}_unit`])}-list`;
      made.querySelector("input").setAttribute("list", id);
      made.append(
        element(
          "datalist",
          { id },
          unitsOf(about?.[`${axis}_unit`]).map((name) => element("option", { value: name })),
        ),
      );
      return made;
    };
    return element(
      "div",
      { class: "item observation" },
      element(
        "h3",
        {},
        one.series ?? `Series ${i + 1}`,
        element("small", {}, points ? ` ${count(points)} readings` : " no readings"),
      ),
      element(
        "div",
        { class: "fields" },
        field(draft, [...path, "series"], {
          label: "Series",
          kind: "select",
          options: names,
          onchange: draw,
          help: described(about),
        }),
        unit("x"),
        unit("y"),
        field(draft, [...path, "weight"], { label: "Weight", kind: "number", fallback: 1, onchange: showShares }),
        field(draft, [...path, "distance"], {
          label: "Residuals",
          kind: "select",
          options: DISTANCES,
          help: "Along the curve: for peaks that the model may reach at another x. x and y count in parts of their ranges.",
        }),
        field(draft, [...path, "loss"], {
          label: "Outliers",
          kind: "select",
          options: LOSSES,
          help: "A loss gives readings far from the curve less weight.",
        }),
        field(draft, [...path, "loss_scale"], {
          label: "Residual above which they count less",
          kind: "number",
          unit: one.y_unit ?? about?.y_unit,
          help: "With a loss; from the error of a reading if absent.",
        }),
        field(draft, [...path, "error"], {
          label: "Standard deviation of a reading",
          kind: "number",
          unit: one.y_unit ?? about?.y_unit,
          help: "Where it is known.",
        }),
      ),
      leftOut(draft, path, one, about),
      prepared(draft, path, one, about),
      element(
        "div",
        { class: "share" },
        element("span", { dataset: { share: String(i) } }),
        element("meter", {
          min: "0",
          max: "1",
          value: "0",
          id: `share-${i}`,
          "aria-label": `Share of ${one.series ?? "the series"}`,
        }),
      ),
      element(
        "div",
        { class: "buttons" },
        all().length > 1
          ? button(`Show ${one.series}`, () => {
              shownSeries = one.series;
              redrawPlot();
            })
          : null,
        button(`Remove ${one.series ?? "it"}`, () => {
          const back = draft.mark();
          draft.write(path, undefined);
          if (points) back(`The ${count(points)} readings of ${one.series ?? "a series"} were removed.`);
          draw();
        }),
      ),
      element("div", { dataset: { accept: String(i) } }),
      errorPlace(path),
    );
  }

  /** Readings that no soil can have are refused until someone says that they are meant. */
  function showAcceptable() {
    const accepted = draft.read(["accept"]) ?? [],
      asked = draft.answer?.to_be_accepted ?? [];
    for (const place_ of list.querySelectorAll("[data-accept]")) {
      const i = Number(place_.dataset.accept),
        name = all()[i]?.series,
        on = Array.isArray(accepted) && accepted.includes(name);
      exchange(
        place_,
        on || asked.includes(name)
          ? flag(`accept-${i}`, `The readings of ${name} are meant as they are`, on, (value) => {
              const others = accepted.filter((one) => one !== name);
              draft.write(["accept"], value ? [...others, name] : others.length ? others : undefined);
            })
          : null,
      );
    }
  }

  function draw() {
    drawnFor = key();
    exchange(list, all().length ? all().map(card) : empty("No measurements yet."), errorPlace(["observations"]));
    exchange(
      scheme,
      all().length > 1
        ? field(draft, ["weighting"], {
            label: "Weights of the series",
            kind: "select",
            options: SCHEMES,
            help: "A scheme multiplies the weights above.",
            onchange: showShares,
          })
        : null,
    );
    showShares();
    redrawPlot();
  }

  /** Shares as the service found them: what the weights make of each series. */
  function showShares() {
    const told =
      draft.answer?.valid && draft.answer.observations.length === all().length
        ? draft.answer.observations.map((one) => one.share)
        : null;
    for (const label of list.querySelectorAll("[data-share]")) {
      const i = Number(label.dataset.share);
      const share = told?.[i];
      label.textContent =
        share === undefined
          ? "Share of the objective: shown once there are no errors"
          : `Share of the objective, each series missed by the same part of its range: ${percent(share, 1)}`;
      list.querySelector(`#share-${i}`).value = share ?? 0;
    }
  }

  function redrawPlot() {
    const found = () =>
      all().find((one) => one.series === shownSeries && Array.isArray(one.points?.x)) ??
      all().find((one) => Array.isArray(one.points?.x));
    if (!found()) {
      plot?.remove();
      plot = null;
      return;
    }
    plot ??= pointsPlot(look, () => {
      const one = found() ?? { points: { x: [], y: [] } };
      const about = info(one.series);
      return {
        x: one.points.x,
        y: one.points.y ?? [],
        gross: one.gross_errors,
        label: one.series,
        xLabel: [about?.x_quantity ?? "x", one.x_unit ?? about?.x_unit],
        yLabel: [about?.y_quantity ?? "y", one.y_unit ?? about?.y_unit],
      };
    });
    plot.draw();
  }

  const key = () =>
    JSON.stringify([
      series().map((one) => [one.name, one.x_unit, one.y_unit]),
      all().map((one) => [one.series, one.points?.x?.length]),
    ]);
  place.replaceChildren(upload, list, scheme, look);
  draft.on("replace", draw);
  draft.on("answer", () => {
    if (key() === drawnFor) showShares();
    else draw();
    showAcceptable();
  });
  draw();
}
