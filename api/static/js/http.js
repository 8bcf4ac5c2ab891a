// Requests to /api/v1: JSON in and out, readable errors, the header that proves an own page, and signing in again.
const BASE = "/api/v1";

/** What the service refused, or that it could not be reached (`status` 0). `issues`: [{path, message}]. */
export class RequestError extends Error {
  constructor(message, { status = 0, type = "", issues = [] } = {}) {
    super(message);
    this.name = "RequestError";
    this.status = status;
    this.type = type.replace("urn:geoswarm:error:", "");
    this.issues = issues;
  }
}

/** Address of a route: `address("/jobs", {state: "running", cursor: null})`; null and "" are left out, lists repeat. */
export function address(path, query = {}) {
  const words = new URLSearchParams();
  for (const [name, value] of Object.entries(query)) {
    for (const one of Array.isArray(value) ? value : [value]) {
      if (one !== null && one !== undefined && one !== "") words.append(name, one);
    }
  }
  const text = words.toString();
  return (path.startsWith("/api/") ? path : BASE + path) + (text ? `?${text}` : "");
}

/** The bare Response of a request; throws RequestError unless it is a success. */
export async function request(method, path, { query, body, headers = {}, signal } = {}) {
  const own = { Accept: "application/json", "X-Requested-With": "geoswarm", ...headers };
  if (body !== undefined && typeof body !== "string" && !(body instanceof Blob)) {
    body = JSON.stringify(body);
    own["Content-Type"] ??= "application/json";
  }
  let answer;
  try {
    answer = await fetch(address(path, query), { method, headers: own, body, signal, credentials: "same-origin" });
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new RequestError("The service cannot be reached; is it running?");
  }
  if (answer.ok) return answer;
  if (answer.status === 401 && !location.pathname.startsWith("/sign-in")) signIn();
  throw await explained(answer);
}

/** GET of JSON. */
export async function get(path, query, options = {}) {
  return (await request("GET", path, { query, ...options })).json();
}

/** A changing request; null for an answer without content. */
export async function send(method, path, body, options = {}) {
  const answer = await request(method, path, { body, ...options });
  return answer.status === 204 ? null : answer.json();
}

export const post = (path, body = undefined, options = {}) => send("POST", path, body, options);

/** Go to the page for signing in, and come back here afterwards. */
export function signIn() {
  location.assign(`/sign-in?next=${encodeURIComponent(location.pathname + location.search)}`);
}

async function explained(answer) {
  try {
    const problem = await answer.json();
    const wait = answer.headers.get("Retry-After");
    const text = problem.detail ?? problem.title ?? `The service answered ${answer.status}.`;
    return new RequestError(wait && !text.includes(`${wait} s`) ? `${text} Try again in ${wait} s.` : text, {
      ...problem,
      status: answer.status,
      issues: problem.issues ?? [],
    });
  } catch {
    return new RequestError(`The service answered ${answer.status} ${answer.statusText}.`, { status: answer.status });
  }
}
