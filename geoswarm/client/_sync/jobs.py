# Generated from geoswarm/client/_async/jobs.py by scripts/generate_client.py; `make format` renews it.
"""Jobs: from the problem that is submitted to the end, and how to steer and find them."""

from __future__ import annotations

import json
import uuid
from collections.abc import Collection, Iterator, Mapping
from typing import Any, Literal

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import (
    API,
    JSON_BODY,
    Call,
    Problem,
    SortKey,
    job_path,
    nothing,
    plain,
    present,
    problem_text,
    reader,
)
from geoswarm.records.job import Job, Retry
from geoswarm.records.record import Page

__all__ = [
    "cancel",
    "change_stopping",
    "delete",
    "get",
    "iterate_jobs",
    "label",
    "list_jobs",
    "pause",
    "problem",
    "resume",
    "retry_failed",
    "submit",
]


def submit(self: Connection, problem: Problem, idempotency_key: str | None = None) -> Job:
    """Submit a problem, a mapping or the path of a problem file; files with measurements are sent along.

    The same ``idempotency_key`` with the same problem gives the same job, however often it is sent.

    Examples
    --------
    >>> submitted = client.submit(problem, idempotency_key="monday")
    >>> submitted.state
    'queued'
    """
    content = problem_text(problem)
    headers = {**JSON_BODY, "Idempotency-Key": idempotency_key or str(uuid.uuid4())}
    return self._send(Call("POST", f"{API}/jobs", reader(Job), headers=headers, content=content))


def list_jobs(
    self: Connection,
    *,
    state: str | None = None,
    search: str | None = None,
    owner: str | None = None,
    tag: str | None = None,
    parent: str | None = None,
    sort: SortKey | None = None,
    order: Literal["ascending", "descending"] | None = None,
    trend: int | None = None,
    limit: int = 50,
    cursor: str | None = None,
) -> Page[Job]:
    """List jobs, newest first unless ``sort`` says otherwise.

    Parameters
    ----------
    state, search, owner, tag
        Only jobs in this state, with this text in name, model, method, owner or tags, of this owner, with this tag.
    parent
        Only follow-ups of this job; ``"none"``: only jobs that are no follow-ups.
    sort, order
        Newest, best or largest first, names from A to Z, unless ``order`` says otherwise.
    trend
        Most values of each job's convergence; none when not given.

    Examples
    --------
    >>> page = client.list(state="finished", limit=1)
    >>> page.items[0].state
    'finished'
    """
    query = present(state=state, q=search, owner=owner, tag=tag, parent=parent, sort=sort, order=order)
    query |= present(trend=trend, limit=limit, cursor=cursor)
    return self._send(Call("GET", f"{API}/jobs", reader(Page[Job]), query))


def iterate_jobs(self: Connection, *, state: str | None = None) -> Iterator[Job]:
    """Go through all jobs, newest first.

    Examples
    --------
    >>> names = [one.name for one in client.iterate_jobs(state="finished")]
    >>> names[-1]
    'line'
    """
    cursor = None
    while True:
        page = list_jobs(self, state=state, limit=200, cursor=cursor)
        yield from page.items
        if (cursor := page.next_cursor) is None:
            return


def get(self: Connection, job_id: str) -> Job:
    """Show a job.

    Examples
    --------
    >>> shown = client.get(job.id)
    >>> shown.state, shown.evaluations
    ('finished', 60)
    """
    return self._send(Call("GET", job_path(job_id), reader(Job)))


def problem(self: Connection, job_id: str) -> dict[str, Any]:
    """Show the problem of a job, complete: it can be submitted again.

    Examples
    --------
    >>> document = client.problem(job.id)
    >>> document["name"]
    'line'
    """
    return self._send(Call("GET", f"{job_path(job_id)}/problem", reader(dict[str, Any])))


def cancel(self: Connection, job_id: str) -> Job:
    """End a job now; its results are kept.

    Examples
    --------
    >>> other = client.submit(problem | {"stopping": {"max_seconds": 600}})
    >>> cancelled = client.cancel(other.id)
    >>> cancelled.state
    'cancelled'
    """
    return self._send(Call("POST", f"{job_path(job_id)}/cancel", reader(Job)))


def pause(self: Connection, job_id: str) -> Job:
    """Hold a job.

    Examples
    --------
    >>> other = client.submit(problem | {"stopping": {"max_seconds": 600}})
    >>> paused = client.pause(other.id)
    >>> paused.state
    'paused'
    >>> ended = client.cancel(other.id)
    """
    return self._send(Call("POST", f"{job_path(job_id)}/pause", reader(Job)))


def resume(self: Connection, job_id: str) -> Job:
    """Continue a paused job.

    Examples
    --------
    >>> other = client.submit(problem | {"stopping": {"max_seconds": 600}})
    >>> paused = client.pause(other.id)
    >>> resumed = client.resume(other.id)
    >>> resumed.state in ("queued", "running")
    True
    >>> ended = client.cancel(other.id)
    """
    return self._send(Call("POST", f"{job_path(job_id)}/resume", reader(Job)))


def change_stopping(self: Connection, job_id: str, stopping: Mapping[str, Any]) -> Job:
    """Replace all stop criteria of a job; a finished or cancelled one continues where it was.

    Examples
    --------
    >>> ended = client.wait((client.submit(problem)).id, timeout=60)
    >>> changed = client.change_stopping(ended.id, {"max_evaluations": 90})
    >>> changed.state in ("queued", "running")
    True
    """
    content = json.dumps({"stopping": dict(stopping)}, default=plain)
    return self._send(Call("PATCH", job_path(job_id), reader(Job), headers=JSON_BODY, content=content))


def label(
    self: Connection,
    job_id: str,
    *,
    name: str | None = None,
    tags: Collection[str] | None = None,
    note: str | None = None,
) -> Job:
    """Replace the name of a job, its tags, its note (Markdown), or all of them. A project may be a tag, too.

    The new name is shown wherever the job is; what is not given stays.

    Examples
    --------
    >>> labelled = client.label(job.id, tags=["dam", "second trial"], note="Specimen B was disturbed.")
    >>> labelled.tags
    ['dam', 'second trial']
    >>> [one.id for one in (client.list(tag="dam")).items] == [job.id]
    True
    """
    content = json.dumps(present(name=name, tags=None if tags is None else list(tags), note=note))
    return self._send(Call("PATCH", job_path(job_id), reader(Job), headers=JSON_BODY, content=content))


def retry_failed(self: Connection, job_id: str) -> Retry:
    """Rerun the failed evaluations of a paused or ended job, and only these.

    Examples
    --------
    >>> section = {"kind": "formula", "series": {"y": {"expression": "ln(a) + b * x"}}}  # fails for a < 0
    >>> other = client.wait((client.submit(problem | {"forward_model": section})).id, timeout=60)
    >>> retried = client.retry_failed(other.id)
    >>> retried.evaluations == other.failed_evaluations
    True
    """
    return self._send(Call("POST", f"{job_path(job_id)}/retry-failed", reader(Retry)))


def delete(self: Connection, job_id: str) -> None:
    """Delete an ended job with everything that belongs to it.

    Examples
    --------
    >>> other = client.wait((client.submit(problem)).id)
    >>> client.delete(other.id)
    """
    self._send(Call("DELETE", job_path(job_id), nothing))
