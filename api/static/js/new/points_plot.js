// Measured points, and what a test run calculates at them.
import { withUnit } from "../format.js";
import { palette, plot } from "../plot.js";

const MOST_DRAWN = 5000;

/** Every so many of many values: all of them could not be told apart. */
const thinned = (values) => {
  const step = Math.ceil(values.length / MOST_DRAWN);
  return step > 1 ? values.filter((_, i) => i % step === 0) : values;
};

/**
 * A plot of `make()`: {x, y, calculated?, label, xLabel: [quantity, unit], yLabel}. Settlements count downwards in the
 * data, so nothing is turned round here.
 */
export function pointsPlot(place, make) {
  return plot(place, () => {
    const { x, y, calculated, label, xLabel, yLabel } = make();
    const [measuredColour, calculatedColour] = palette();
    const measured = { x: thinned(x), y: thinned(y), name: "measured", mode: "markers", type: "scatter", marker: { color: measuredColour, size: 6 } };
    const run = calculated && { x: thinned(x), y: thinned(calculated), name: "calculated", mode: "lines+markers", type: "scatter", line: { color: calculatedColour, width: 2 }, marker: { color: calculatedColour, size: 3 } };
    const [xName, yName] = [withUnit(...xLabel), withUnit(...yLabel)];
    return {
      data: run ? [measured, run] : [measured],
      layout: { height: 300, showlegend: Boolean(run), xaxis: { title: { text: xName } }, yaxis: { title: { text: yName } } },
      label: `${label}: ${yName} over ${xName}, ${x.length} readings${run ? " and the test run" : ""}`,
      columns: { [xName]: x, [`${yName} measured`]: y, ...(run ? { [`${yName} calculated`]: calculated } : {}) },
    };
  });
}
