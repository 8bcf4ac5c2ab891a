# Generated from geoswarm/client/_async/following.py by scripts/generate_client.py; `make format` renews it.
"""Following a job: its events as they come, and its end."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator, Iterator
from contextlib import closing

import httpx

from geoswarm.client._sync.connection import Connection
from geoswarm.client._sync.jobs import get
from geoswarm.client.calls import error_of, job_path
from geoswarm.client.errors import GeoswarmError, JobFailedError, WaitTimeoutError
from geoswarm.client.follow import Follower, SilentStreamError, pause_before
from geoswarm.records.job import Event, Job

__all__ = ["events", "wait"]


def events(self: Connection, job_id: str, after: int = 0) -> Iterator[Event]:
    """Follow a job: every event after the given one, as it comes, until the job has ended.

    A broken connection is resumed where it broke; no event is lost or duplicated. Of a job with hundreds of
    generations a second the service leaves some generations out, never the last one.

    Examples
    --------
    >>> kinds = {event.kind for event in client.events(job.id)}
    >>> "generation" in kinds
    True
    """
    with closing(_follow(self, job_id, after, None)) as coming:
        yield from coming


def wait(
    self: Connection, job_id: str, timeout: float | None = None, on_event: Callable[[Event], object] | None = None
) -> Job:
    """Wait until a job has ended.

    Parameters
    ----------
    timeout
        Longest time to wait [s]; None waits as long as it takes.
    on_event
        Called with every event of the job.

    Returns
    -------
    The finished or cancelled job.

    Raises
    ------
    WaitTimeoutError
        The job did not end in time.
    JobFailedError
        It has failed.

    Examples
    --------
    >>> ended = client.wait(job.id, timeout=60)
    >>> ended.state
    'finished'
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    get(self, job_id)  # an unknown job, or no service, is reported at once
    try:
        with closing(_follow(self, job_id, 0, deadline)) as coming:
            for event in coming:
                if on_event is not None:
                    on_event(event)
        job = get(self, job_id)
    except SilentStreamError:
        while not (job := get(self, job_id)).ended and (pause := pause_before(deadline)) > 0.0:
            time.sleep(pause)
    if job.state == "failed":
        raise JobFailedError(job)
    if not job.ended:
        raise WaitTimeoutError(job_id, timeout or 0.0)
    return job


def _follow(self: Connection, job_id: str, after: int, deadline: float | None) -> Generator[Event, None, None]:
    follower = Follower(after, patience=self._patience, silence=self._stream_timeout, deadline=deadline)
    while not follower.expired:
        headers = {"Accept": "text/event-stream", "Last-Event-ID": str(follower.last_id)}
        timeout = httpx.Timeout(self._timeout, read=follower.read_timeout())
        try:
            with self._http.stream("GET", f"{job_path(job_id)}/events", headers=headers, timeout=timeout) as response:
                if response.status_code == httpx.codes.NO_CONTENT:
                    return
                if not response.is_success:
                    response.read()
                    raise error_of(response)
                for line in response.iter_lines():
                    event = follower.hear(line)
                    if event is not None:
                        yield event
                    if follower.ended or follower.expired:
                        return
                    if follower.should_reconnect:
                        break
                else:
                    time.sleep(follower.broken(None))
        except (httpx.HTTPError, GeoswarmError) as error:
            time.sleep(follower.broken(error))
