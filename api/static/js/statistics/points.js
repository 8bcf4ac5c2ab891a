// The successful evaluations of a job as arrays: one request, float32, no parsing of numbers.
import { request } from "../http.js";

const MEDIA_TYPE = "application/vnd.geoswarm.points";

/**
 * {count, failed, source, parameters, series} of the job, and as arrays: generation, particle, objective,
 * values[i] of parameter i, misfits[series], responses[series] = {width, values} (with `responses`).
 */
export async function fetchPoints(job, { responses = false, signal } = {}) {
  const answer = await request("GET", `/jobs/${job}/points`, {
    query: responses ? { responses } : {},
    headers: { Accept: MEDIA_TYPE },
    signal,
  });
  return decoded(await answer.arrayBuffer());
}

function decoded(buffer) {
  const size = new DataView(buffer).getUint32(0, true);
  const { columns, ...head } = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 4, size)));
  const found = { ...head, values: [], misfits: {}, responses: {} };
  let place = 4 + size;
  for (const { kind, name, width } of columns) {
    const values = new Float32Array(buffer, place, head.count * width);
    place += values.byteLength;
    if (kind === "own") found[name] = values;
    else if (kind === "parameter") found.values.push(values);
    else if (kind === "misfit") found.misfits[name] = values;
    else found.responses[name] = { width, values };
  }
  return found;
}
