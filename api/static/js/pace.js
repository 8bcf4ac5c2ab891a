// Work that follows a stream of news without running after every single one.

/** When a service out of reach is asked again [ms]. */
export const LATER = 3000;
let leaving = false;

/** Begin nothing more, as the page goes; or go on, as it stays. */
export function leave(goes) {
  leaving = goes;
}

/**
 * A function that runs `work` soon after it is called, at most once in `interval` ms and never twice at a time, and only
 * while `place` (an element) is on the screen of a page that is looked at: what was missed is made up for then. What the
 * service could not be asked is asked again later.
 */
export function paced(work, interval, place = null) {
  let due = false,
    busy = false,
    last = -Infinity,
    timer = null,
    seen = place === null;
  async function look() {
    clearTimeout(timer);
    if (!due || busy || !seen || leaving || document.hidden) return;
    const rest = last + interval - performance.now();
    if (rest > 0) {
      timer = setTimeout(look, rest);
      return;
    }
    due = false;
    busy = true;
    last = performance.now();
    try {
      await work();
    } catch (error) {
      if (error.status !== 0) throw error;
      due = true; // the service is out of reach, which the stream reports
      last = performance.now() + LATER - interval;
    } finally {
      busy = false;
      look();
    }
  }
  if (place) {
    new IntersectionObserver(
      (entries) => {
        seen = entries.at(-1).isIntersecting;
        look();
      },
      { rootMargin: "200px" },
    ).observe(place);
  }
  document.addEventListener("visibilitychange", look);
  return () => {
    due = true;
    look();
  };
}
