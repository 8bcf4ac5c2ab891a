// Load stages of the forward model from a column of loads beside the readings, by the service's reader.
import { element, exchange } from "../../dom.js";
import { count, number } from "../../format.js";
import { request } from "../../http.js";
import { button } from "../schema_form.js";
import { unitsOf } from "../units.js";
import { messageOf } from "../words.js";
import { CELLS, section } from "./choices.js";
import { labelHere, words } from "./inputs.js";
import { meansLoad, reference } from "./matching.js";

const SHOWN = 6; // stages that a sentence names

/** The column that seems to hold loads, by its words or its unit; undefined: none. */
export function columnOfLoads(file) {
  const meant = file.columns.findIndex(meansLoad);
  const found =
    meant >= 0 ? meant : file.columns.findIndex((column) => column.kind === "number" && column.base === "kPa");
  return found >= 0 ? found : undefined;
}

/** Whether each value is repeated in several consecutive rows. */
function inStages({ values }) {
  const given = values.filter((value) => value !== null);
  return given.filter((value, i) => i === 0 || value !== given[i - 1]).length * 2 <= given.length;
}

/**
 * The offer to fill in stages; `renew()` after each change of `state`. `act`: {stages(found): fills them in, joined(blocks):
 * x restarts in every stage of the forward model, so that the readings of each are a block}.
 */
export function loadStages(file, content, state, context, act) {
  const place = element("div", {});
  let unit = "",
    latest = 0;

  async function renew() {
    const mine = ++latest,
      of = file.columns[state.more.load_column];
    const x =
      typeof state.x === "number"
        ? state.x
        : file.columns.findIndex((column) => column.quantities.includes("time") || column.base === "day");
    if (!context.staged() || !of || state.x === CELLS || x < 0 || x === state.more.load_column)
      return exchange(place, null);
    const chosen = state.more.load_column !== columnOfLoads(file); // by the user, to whom a refusal is explained
    if (open(x).length || (!chosen && !inStages(of))) return exchange(place, null); // nothing is asked that would be refused
    if (!of.unit && !unit) return exchange(place, field(of));
    const { x_dates, x_time_column, x_origin, sheet, where, decimal_sign, incomplete_rows, no_reading } = section(
      file,
      state,
    );
    const observation = {
      x_dates,
      x_time_column,
      x_origin,
      sheet,
      where,
      decimal_sign,
      incomplete_rows,
      no_reading,
      x_column: reference(file, x),
      x_unit: file.columns[x].unit ? undefined : state.xUnit || undefined,
    };
    const query = {
      name: file.name,
      observation: JSON.stringify(observation),
      load_column: reference(file, state.more.load_column),
      load_unit: of.unit ? undefined : unit,
    };
    try {
      const found = await (
        await request("POST", "/measurements/stages", {
          query,
          body: content,
          headers: { "Content-Type": "application/octet-stream" },
        })
      ).json();
      if (mine === latest) show(of, found);
    } catch (error) {
      if (mine === latest)
        exchange(
          place,
          of.unit ? null : field(of),
          element(
            "p",
            { class: "help" },
            `“${of.name}” gives no stages: ${(error.issues?.length ? error.issues : [error]).map((issue) => messageOf(issue, labelHere)).join("; ")}`,
          ),
        );
    }
  }

  /** What is to be said about the columns before the service can read them. */
  function open(x) {
    const time = file.columns[x],
      of = file.columns[state.more.load_column];
    return [
      time.kind !== "number" && (time.kind === "clock" || time.doubt) && !state.dates,
      (of.doubt || (time.kind === "number" && time.doubt)) && !state.decimal,
      time.kind === "number" && !time.unit && !state.xUnit,
      of.unclear,
      time.bad || of.bad,
    ].filter(Boolean);
  }

  function field(of) {
    return element(
      "div",
      { class: "fields" },
      words(
        "map-load-unit",
        `Unit of the loads, ${of.name}`,
        unit,
        (value) => {
          unit = value;
          renew();
        },
        {
          list: unitsOf("kPa"),
          asked: !unit,
          help: "For the stages of the forward model, which this column may give.",
        },
      ),
    );
  }

  function show(of, found) {
    const more = found.stages.length - SHOWN;
    const named = found.stages
      .slice(0, SHOWN)
      .map(({ stress, duration }) => `${number(stress)} kPa for ${number(duration)} day`);
    const same =
      JSON.stringify(context.stages()) ===
      JSON.stringify(found.stages.map(({ stress, duration }) => ({ stress, duration })));
    exchange(
      place,
      element(
        "p",
        { class: "help" },
        `“${of.name}” has ${count(found.stages.length)} stages: ${named.join(", ")}${more > 0 ? `, and ${count(more)} more` : ""}${found.initial_stress ? `; before them ${number(found.initial_stress)} kPa` : ""}.`,
      ),
      same
        ? element("p", { class: "help" }, "These are the stages of the forward model.")
        : element(
            "div",
            { class: "buttons" },
            button(`Fill in these ${count(found.stages.length)} stages`, () => act.stages(found)),
          ),
    );
    if (same && found.elapsed)
      act.joined(
        found.stages.map(({ load }, i) => ({
          where: { [reference(file, state.more.load_column)]: load },
          stage: i + 1,
        })),
      );
  }

  return { place, renew };
}
