// Renews <main> from the server: on the events of a job, or at an interval.
const notice = document.getElementById("connection");
let due = false, busy = false;

async function renew() {
  if (busy) { due = true; return; }
  busy = true;
  try {
    const answer = await fetch(location.href);
    if (answer.ok) {
      const page = new DOMParser().parseFromString(await answer.text(), "text/html");
      document.querySelector("main").replaceChildren(...page.querySelector("main").childNodes);
    }
    notice.hidden = answer.ok;
  } catch { notice.hidden = false; }
  setTimeout(() => { busy = false; if (due) { due = false; renew(); } }, 500);
}

const { renew: interval, events } = document.querySelector("main").dataset;
if (interval) setInterval(() => document.hidden || renew(), Number(interval));
if (events) {
  const source = new EventSource(events);
  source.addEventListener("generation", renew);
  source.addEventListener("state", (event) => {
    renew();
    if (["finished", "failed", "cancelled"].includes(JSON.parse(event.data).state)) source.close();
  });
  source.onerror = () => { notice.hidden = false; };
  source.onopen = () => { notice.hidden = true; };
}
