// Measured points, and what a test run calculates at them.
import { direction, withUnit } from "../format.js";
import { grossErrors, palette, plot } from "../plot.js";

const MOST_DRAWN = 5000;

/** Evenly chosen values of many: all of them could not be distinguished. */
const thinned = (values) => {
  const step = Math.ceil(values.length / MOST_DRAWN);
  return step > 1 ? values.filter((_, i) => i % step === 0) : values;
};

/**
 * A plot of `make()`: {x, y, gross?, calculated?, label, xLabel: [quantity, unit], yLabel}; `gross` are numbers of gross
 * errors, from 1; `calculated` has an x of its own, as readings may take no part. `label` is the series.
 */
export function pointsPlot(place, make) {
  return plot(place, () => {
    const { x: every, y: all, gross, calculated, label, xLabel, yLabel } = make();
    const struck = new Set(Array.isArray(gross) ? gross.map((one) => one - 1) : []);
    const counted = (values) => (struck.size ? values.filter((_, i) => !struck.has(i)) : values);
    const [x, y] = [counted(every), counted(all)];
    const marked = struck.size
      ? grossErrors(
          every.filter((_, i) => struck.has(i)),
          all.filter((_, i) => struck.has(i)),
        )
      : null;
    const [measuredColour, calculatedColour] = palette();
    const measured = {
      x: thinned(x),
      y: thinned(y),
      name: "measured",
      mode: "markers",
      type: "scatter",
      marker: { color: measuredColour, size: 6 },
    };
    const run = calculated && {
      x: thinned(calculated.x),
      y: thinned(calculated.y),
      name: "calculated",
      mode: "lines+markers",
      type: "scatter",
      line: { color: calculatedColour, width: 2 },
      marker: { color: calculatedColour, size: 3 },
    };
    const [xName, yName] = [withUnit(...xLabel), withUnit(...yLabel)];
    return {
      data: [measured, run, marked].filter(Boolean),
      layout: {
        height: 300,
        showlegend: Boolean(run ?? marked),
        xaxis: { title: { text: xName } },
        yaxis: { title: { text: yName }, ...direction(label, yLabel[0]) },
      },
      label: `${label}: ${yName} over ${xName}, ${x.length} readings${run ? " and the test run" : ""}${struck.size ? `, ${struck.size} marked as gross errors` : ""}`,
      columns: {
        [xName]: x,
        [`${yName} measured`]: y,
        ...(run ? { [`${xName} calculated`]: calculated.x, [`${yName} calculated`]: calculated.y } : {}),
      },
    };
  });
}
