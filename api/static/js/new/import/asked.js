// What a file leaves in doubt: how its numbers, dates and times are written, which specimen, and whether blocks are joined.
import { count } from "../../format.js";
import { byLoad } from "./matching.js";
import { doubts, joinable, specimenColumn } from "./choices.js";
import { choice, flag, written } from "./inputs.js";
import { CLOCKS, DATES, SIGNS } from "./more.js";

/** The fields of these questions; `change(true)` draws the form again. */
export function askedFields(file, state, info, context, change) {
  const asks = (id, label, options, key, help) =>
    choice(
      id,
      label,
      options,
      state[key],
      (value) => {
        state[key] = value;
        change(true);
      },
      { help, asked: true },
    );
  const { numbers, dates, clock } = doubts(file, state);
  const specimens = file.columns[specimenColumn(file, state)];
  const rows =
    specimens && Object.entries(specimens.entries).map(([entry, n]) => [entry, `${entry} (${count(n)} rows)`]);
  const blocks = info && !byLoad(info, "x") ? joinable(file, state) : [];
  const how = (thing) => `How are ${thing} written?`;
  return [
    numbers &&
      asks(
        "map-sign",
        how("numbers"),
        SIGNS,
        "decimal",
        written("span", `“${numbers.doubt}” in ${numbers.name} can be one thousand or one.`),
      ),
    dates && asks("map-dates", how("dates"), DATES, "dates", `“${dates.doubt}” can be read in two ways.`),
    clock &&
      asks(
        "map-dates",
        how("times"),
        CLOCKS,
        "dates",
        `“${clock.first.find(Boolean)}” can be a time since the start or a time of day.`,
      ),
    specimens && asks("map-specimen", `Which ${specimens.name}?`, [...rows, ["", "all rows"]], "specimen"),
    blocks.length > 1 &&
      flag(
        "map-together",
        blocks[0].sheet
          ? `Join the ${count(blocks.length)} sheets with these headings, one after the other: ${file.alike.join(", ")}`
          : `Join the ${count(blocks.length)} blocks with these headings, one after the other`,
        state.together,
        (on) => {
          state.together = on;
          state.staged = context.staged();
          change(false);
        },
      ),
  ];
}
