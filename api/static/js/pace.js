// Work that follows a stream of news without running after every single one.

/**
 * A function that runs `work` soon after it is called, at most once in `interval` ms and never twice at a time, and only
 * while `place` (an element) is on the screen of a page that is looked at: what was missed is made up for then.
 */
export function paced(work, interval, place = null) {
  let due = false, busy = false, last = -Infinity, timer = null, seen = place === null;
  async function look() {
    clearTimeout(timer);
    if (!due || busy || !seen || document.hidden) return;
    const rest = last + interval - performance.now();
    if (rest > 0) { timer = setTimeout(look, rest); return; }
    due = false;
    busy = true;
    last = performance.now();
    try {
      await work();
    } finally {
      busy = false;
      look();
    }
  }
  if (place) {
    new IntersectionObserver((entries) => {
      seen = entries.at(-1).isIntersecting;
      look();
    }, { rootMargin: "200px" }).observe(place);
  }
  document.addEventListener("visibilitychange", look);
  return () => { due = true; look(); };
}
