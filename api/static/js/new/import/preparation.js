// What is done to readings that were taken: which take no part, zero reading, factor, order, means.
import { element, exchange } from "../../dom.js";
import { checkbox, field } from "../fields.js";
import { choice } from "./inputs.js";

const ZERO = [
  ["none", "none"],
  ["first", "the first reading"],
  ["x", "the reading at an x"],
  ["y", "a known value"],
];
const REPEATED = [
  [undefined, "are refused"],
  ["average", "become their mean"],
  ["shift", "are spread up to the next x"],
];

/** Readings that take no part: by x, and in a test in stages by the time since the load and by stage. */
export function leftOut(draft, path, one, about) {
  const unit = one.x_unit ?? about?.x_unit,
    staged =
      Array.isArray(draft.read(["forward_model", "stages"])) || draft.read(["forward_model", "parts"]) !== undefined;
  const some = ["x_from", "x_to", "stage_x_from", "leave_out_stages", "gross_errors"].some(
    (name) => one[name] !== undefined,
  );
  const settles = staged && !one.series?.split(".").at(-1).startsWith("stage_");
  return [
    settles
      ? element(
          "p",
          { class: "help" },
          "The soil laws do not contain primary consolidation: leave out the readings before its end in every stage, or calibrate the values at the ends of the stages (series stage_…). Checking the problem estimates that end.",
        )
      : null,
    element(
      "details",
      { open: some },
      element("summary", {}, "Leave readings out"),
      element(
        "div",
        { class: "fields" },
        field(draft, [...path, "x_from"], { label: "From", kind: "number", unit }),
        field(draft, [...path, "x_to"], { label: "To", kind: "number", unit }),
        settles
          ? field(draft, [...path, "stage_x_from"], {
              label: "Of every stage, from so long after its load",
              kind: "number",
              unit,
            })
          : null,
        staged
          ? field(draft, [...path, "leave_out_stages"], {
              label: "Stages to leave out",
              kind: "numbers",
              help: "Their numbers, from 1.",
            })
          : null,
        field(draft, [...path, "gross_errors"], {
          label: "Gross errors",
          kind: "numbers",
          help: "Numbers of the readings, from 1: shown as crosses, but they do not count.",
        }),
      ),
    ),
  ];
}

/** What is done to the readings before they count, in this order. */
export function prepared(draft, path, one, about) {
  const [xUnit, yUnit] = [one.x_unit ?? about?.x_unit, one.y_unit ?? about?.y_unit];
  const value = element("div", { class: "field" });
  const given = draft.read([...path, "y_zero"]);
  const zero = given === undefined ? "none" : typeof given === "string" ? "first" : "x" in given ? "x" : "y";
  const showZero = (kind) =>
    exchange(
      value,
      kind === "x"
        ? field(draft, [...path, "y_zero", "x"], {
            label: "Zero reading at",
            kind: "number",
            unit: xUnit,
            help: "Between two readings it is interpolated.",
          })
        : kind === "y"
          ? field(draft, [...path, "y_zero", "y"], { label: "Value of the zero reading", kind: "number", unit: yUnit })
          : null,
    );
  const setZero = (kind) => {
    draft.write(
      [...path, "y_zero"],
      { none: undefined, first: "first", x: { x: one.points?.x?.[0] ?? 0 }, y: { y: 0 } }[kind],
    );
    showZero(kind);
  };
  showZero(zero);
  const tidy = () => {
    if (!Object.keys(draft.read([...path, "resample"]) ?? { some: 1 }).length)
      draft.write([...path, "resample"], undefined);
  };
  return element(
    "details",
    {
      open: ["x_factor", "y_zero", "y_factor", "resample", "sort", "repeated_x"].some(
        (name) => one[name] !== undefined,
      ),
    },
    element("summary", {}, "Prepare the readings"),
    element(
      "div",
      { class: "fields" },
      checkbox(draft, [...path, "sort"], { label: "Put them in the order of x" }),
      choice(`zero-${path[1]}`, "Zero reading", ZERO, zero, setZero, { help: "It is subtracted from all." }),
      value,
      field(draft, [...path, "x_factor"], {
        label: "Factor of x",
        kind: "number",
        fallback: 1,
        help: "−1 turns the sign.",
      }),
      field(draft, [...path, "y_factor"], {
        label: "Factor of y",
        kind: "number",
        fallback: 1,
        help: "−1 turns the sign.",
      }),
      field(draft, [...path, "repeated_x"], { label: "Readings at equal x", kind: "select", options: REPEATED }),
      field(draft, [...path, "resample", "per_decade"], {
        label: "Means per decade of x",
        kind: "number",
        onchange: tidy,
      }),
      field(draft, [...path, "resample", "every"], {
        label: "Means of this many consecutive readings",
        kind: "number",
        onchange: tidy,
      }),
    ),
    one.notes?.length
      ? element(
          "div",
          { class: "help" },
          "What was done already:",
          element(
            "ul",
            {},
            one.notes.map((note) => element("li", {}, note)),
          ),
        )
      : null,
  );
}
