// Fewer items where a plot could not show them all.

/** At most about `most` of the items, evenly chosen, with the first, the last, and (by `keep`) all that matter. */
export function thinned(items, most, keep = () => false) {
  if (items.length <= most) return items;
  const step = (items.length - 1) / (most - 1);
  const chosen = new Set(Array.from({ length: most }, (_, i) => Math.round(i * step)));
  return items.filter((item, i) => chosen.has(i) || keep(item, i));
}
