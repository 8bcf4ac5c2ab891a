// What is looked at stands in the address, so that it can be sent to somebody, kept, and come back to.

/** Values of the address by name. */
export function told() {
  return new URLSearchParams(location.search);
}

/** Write values into the address, without a step back in the browser's history; null takes one out. */
export function tellAddress(values) {
  const words = told();
  for (const [name, value] of Object.entries(values)) {
    if (value === null || value === undefined) words.delete(name);
    else words.set(name, value);
  }
  const text = words.toString();
  history.replaceState(history.state, "", location.pathname + (text ? `?${text}` : "") + location.hash);
}
