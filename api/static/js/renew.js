// Renews part of this page from the server, row by row, so that what the first paint shows stays true without a second
// way to draw it, and who is at a control of a row stays there.

/**
 * Fetch `url` and take over the contents of `place` (an element with an id) there. Rows with the same `data-job` are kept
 * and only their changed cells replaced; cells with controls stay. Returns the new document; throws when it did not come.
 */
export async function renew(place, url = location.href) {
  const answer = await fetch(url, { headers: { Accept: "text/html" } });
  if (answer.redirected && new URL(answer.url).pathname === "/sign-in") location.assign(answer.url);
  if (!answer.ok) throw new Error(`The service answered ${answer.status}.`);
  const page = new DOMParser().parseFromString(await answer.text(), "text/html");
  const fresh = page.getElementById(place.id);
  const [body, source] = [place, fresh].map((root) => root.querySelector("tbody"));
  if (!body || !source) place.replaceChildren(...fresh.childNodes);
  else {
    exchangeRows(body, source);
    const [heads, fresher] = [place, fresh].map((root) => root.querySelector("thead"));
    if (heads && fresher && heads.innerHTML !== fresher.innerHTML) heads.replaceWith(fresher);
    const [old, now] = [place, fresh].map((root) => root.lastElementChild);
    if (old.innerHTML !== now.innerHTML) old.replaceWith(now);
  }
  return page;
}

function exchangeRows(body, source) {
  const known = new Map([...body.rows].map((row) => [row.dataset.job, row]));
  const rows = [...source.rows].map((row) => {
    const old = known.get(row.dataset.job);
    if (!old) return row;
    [...row.cells].forEach((cell, i) => {
      if (!cell.querySelector("input") && raw(old.cells[i]) !== raw(cell)) old.cells[i].replaceWith(cell);
    });
    return old;
  });
  for (const row of [...body.rows]) if (!rows.includes(row)) row.remove();
  let here = body.firstElementChild; // who stays in place keeps the focus
  for (const row of rows) {
    if (row === here) here = here.nextElementSibling;
    else body.insertBefore(row, here);
  }
}

/** Markup as the server wrote it: what is put into words or opened here would make its cell look changed. */
function raw(cell) {
  return cell.querySelector("time")?.dateTime ?? cell.innerHTML.replaceAll(/ aria-expanded="\w+"/g, "");
}
