// Events of a job, one stream a browser however many tabs look at it: a browser opens only six connections to a service.
//
// The tab that holds the lock `geoswarm:JOB` reads the stream and passes it on to the others over a BroadcastChannel; when it goes,
// the lock falls to the next one. Each tab knows the last event that it has seen, so a change of the leader loses and
// doubles nothing. Without locks or channels (old browsers, plain HTTP on other hosts) each tab polls.
import { address, get } from "./http.js";
import { ENDED } from "./states.js";

const KINDS = ["state", "generation", "kernels"];
const SHORTEST = 1000,
  LONGEST = 30000,
  POLL = 2000;

/**
 * Follow a job. `onEvent({id, kind, data})` in order, each once; `onConnection(true | false)` when the stream is there or
 * lost. `after`: id of the last event that is known (0: from the first one); `state` of the job, if
 * known. Returns {close, last}.
 */
export function follow(job, { onEvent, onConnection = () => {}, after = 0, state = null }) {
  let last = after,
    closed = false,
    ended = ENDED.has(state),
    leading = null,
    release = null;
  const shared = "locks" in navigator && "BroadcastChannel" in window;
  const channel = shared ? new BroadcastChannel(`geoswarm:${job}`) : null;
  const stop = new AbortController();

  function take(event) {
    if (closed || event.id <= last) return;
    last = event.id;
    onEvent(event);
    if (event.kind === "state") ended = ENDED.has(event.data.state);
  }

  function tell(message) {
    channel?.postMessage(message);
    receive(message);
  }

  function receive(message) {
    if (closed) return;
    if (message.event) take(message.event);
    else if (message.connected !== undefined) onConnection(message.connected);
    else if (message.from !== undefined && leading) leading.answer(message.from);
  }

  /** The leader may be further than this tab: it reads again from here, and others pass over what they know. */
  function catchUp() {
    channel.postMessage({ from: last });
  }

  if (channel) {
    channel.onmessage = ({ data }) => receive(data);
    navigator.locks
      .request(
        `geoswarm:${job}`,
        { signal: stop.signal },
        () =>
          new Promise((resolve) => {
            if (closed) return resolve();
            release = resolve;
            leading = lead(
              job,
              () => last,
              tell,
              () => ended,
            );
          }),
      )
      .catch((error) => {
        if (error.name !== "AbortError") throw error;
      });
    catchUp();
  } else {
    leading = poll(job, onEvent, onConnection);
  }

  const wake = () => {
    if (document.hidden) return;
    if (leading) leading.wake();
    else catchUp();
  };
  document.addEventListener("visibilitychange", wake);
  window.addEventListener("online", wake);
  window.addEventListener("pageshow", wake);

  return {
    get last() {
      return last;
    },
    close() {
      closed = true;
      stop.abort();
      leading?.close();
      release?.();
      channel?.close();
      document.removeEventListener("visibilitychange", wake);
      window.removeEventListener("online", wake);
      window.removeEventListener("pageshow", wake);
    },
  };
}

/** Read the stream itself, with longer and longer pauses while the service is away. */
function lead(job, last, tell, ended) {
  let source = null,
    timer = null,
    pause = SHORTEST,
    closed = false,
    heard = Date.now();

  function open(after = last()) {
    clearTimeout(timer);
    source?.close();
    if (closed) return;
    source = new EventSource(address(`/jobs/${job}/events`, { after }));
    source.onopen = () => {
      pause = SHORTEST;
      heard = Date.now();
      tell({ connected: true });
    };
    for (const kind of KINDS) {
      source.addEventListener(kind, (event) => {
        heard = Date.now();
        tell({ event: { id: Number(event.lastEventId), kind, data: JSON.parse(event.data) } });
      });
    }
    source.onerror = async () => {
      source.close(); // its own way to reconnect gives up at the first answer that is not a stream
      if (closed) return;
      if (ended()) {
        timer = setTimeout(watch, POLL);
        return;
      }
      tell({ connected: false });
      timer = setTimeout(again, pause * (0.75 + Math.random() / 2));
      pause = Math.min(2 * pause, LONGEST);
    };
  }

  /** A stream does not say why it was refused: a plain request does. */
  async function again() {
    try {
      await get(`/jobs/${job}`);
    } catch (error) {
      if (error.status === 401 || error.status === 404) return; // signing in again, or gone
    }
    open();
  }

  /** A job that has ended has no stream; it may go on (failed evaluations run again), so look now and then. */
  async function watch() {
    if (closed) return;
    try {
      const { state, last_event: newest } = await get(`/jobs/${job}`);
      tell({ connected: true });
      if (!ENDED.has(state) || newest > last()) return open(); // it may even have ended again since
    } catch (error) {
      if (error.status === 401 || error.status === 404) return;
      tell({ connected: false });
    }
    timer = setTimeout(watch, 5 * POLL);
  }

  open();
  return {
    /** Another tab is at an event: tell it how things are, and read again what it has missed. */
    answer(from) {
      if (source.readyState === EventSource.OPEN) tell({ connected: true });
      if (from < last()) open(from);
    },
    /** After a sleep the connection may have died unnoticed. */
    wake() {
      if (!ended() && (source.readyState === EventSource.CLOSED || Date.now() - heard > LONGEST)) open();
    },
    close() {
      closed = true;
      clearTimeout(timer);
      source?.close();
    },
  };
}

/** Without a shared stream: ask for the state and the newest generations. Events have the ids of their generations. */
function poll(job, onEvent, onConnection) {
  let timer = null,
    closed = false,
    state = null,
    number = -1;
  async function look() {
    clearTimeout(timer);
    let pause = POLL;
    try {
      const [now, { items }] = await Promise.all([
        get(`/jobs/${job}`),
        get(`/jobs/${job}/generations`, { after: number, limit: 1000 }),
      ]);
      if (closed) return;
      onConnection(true);
      for (const generation of items) {
        number = generation.number;
        onEvent({ id: null, kind: "generation", data: generation });
      }
      if (now.state !== state) {
        state = now.state;
        onEvent({ id: null, kind: "state", data: { state, stop_reasons: now.stop_reasons, error: now.error } });
      }
      if (ENDED.has(state)) pause = 5 * POLL;
    } catch (error) {
      if (closed || error.status === 401 || error.status === 404) return;
      onConnection(false);
      pause = 2 * POLL;
    }
    if (!closed) timer = setTimeout(look, document.hidden ? 5 * pause : pause);
  }
  look();
  return {
    wake: look,
    close() {
      closed = true;
      clearTimeout(timer);
    },
  };
}
