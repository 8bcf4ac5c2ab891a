// Which of several jobs fits best: only where all were fitted to the same readings, and under the weights of the first.
import { post } from "../http.js";

const readings = (fit) =>
  JSON.stringify(fit.series.map(({ series, x_unit, y_unit, x, measured }) => [series, x_unit, y_unit, x, measured]));
const weights = (fit) => Object.fromEntries(fit.series.map(({ series, weight }) => [series, weight]));

/**
 * How jobs rank: {objectives, why, reweighted}. `objectives` are those under the weights of the first job, null where the
 * jobs cannot be ranked, which `why` explains; `reweighted`: for each, whether its own weights were different.
 */
export async function ranking(loaded) {
  const [{ fit: first }] = loaded,
    wanted = weights(first);
  if (!loaded.every(({ fit }) => readings(fit) === readings(first))) {
    return { objectives: null, reweighted: [], why: "Not ranked: these jobs were fitted to different readings." };
  }
  const reweighted = loaded.map(({ fit }) => fit.series.some(({ series, weight }) => weight !== wanted[series]));
  try {
    const objectives = await Promise.all(
      loaded.map(async ({ job }, i) =>
        reweighted[i] && job.objective !== null
          ? (await post(`/jobs/${job.id}/reweight`, { weights: wanted })).best.objective
          : job.objective,
      ),
    );
    const why = reweighted.some(Boolean)
      ? `The weights differ: all are compared under those of ${loaded[0].job.name}, from stored responses.`
      : "";
    return { objectives, reweighted, why };
  } catch (error) {
    return {
      objectives: null,
      reweighted,
      why: `Not ranked: the weights of these jobs differ, and they could not be compared under the same ones (${error.message}).`,
    };
  }
}
