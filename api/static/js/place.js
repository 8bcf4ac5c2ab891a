// What a page shows is part of its address, so that it can be sent, kept and returned to.

/** Values of the address by name. */
export function addressValues() {
  return new URLSearchParams(location.search);
}

/** Write values into the address, without an entry in the browser's history; null removes one. */
export function setAddressValues(values) {
  const words = addressValues();
  for (const [name, value] of Object.entries(values)) {
    if (value === null || value === undefined) words.delete(name);
    else words.set(name, value);
  }
  const text = words.toString();
  history.replaceState(history.state, "", location.pathname + (text ? `?${text}` : "") + location.hash);
}
