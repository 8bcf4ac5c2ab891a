"""Following a job: its events as they come, and its end."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncGenerator, AsyncIterator, Callable
from contextlib import aclosing

import httpx

from geoswarm.client._async.connection import AsyncConnection
from geoswarm.client._async.jobs import get
from geoswarm.client.calls import error_of, job_path
from geoswarm.client.errors import GeoswarmError, JobFailedError, WaitTimeoutError
from geoswarm.client.follow import Follower, SilentStreamError, pause_before
from geoswarm.records.job import Event, Job

__all__ = ["events", "wait"]


async def events(self: AsyncConnection, job_id: str, after: int = 0) -> AsyncIterator[Event]:
    """Follow a job: every event after the given one, as it comes, until the job has ended.

    A broken connection is resumed where it broke; no event is lost or duplicated. Of a job with hundreds of
    generations a second the service leaves some generations out, never the last one.

    Examples
    --------
    >>> kinds = {event.kind async for event in client.events(job.id)}
    >>> "generation" in kinds
    True
    """
    async with aclosing(_follow(self, job_id, after, None)) as coming:
        async for event in coming:
            yield event


async def wait(
    self: AsyncConnection, job_id: str, timeout: float | None = None, on_event: Callable[[Event], object] | None = None
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
    >>> ended = await client.wait(job.id, timeout=60)
    >>> ended.state
    'finished'
    """
    deadline = None if timeout is None else time.monotonic() + timeout
    await get(self, job_id)  # an unknown job, or no service, is reported at once
    try:
        async with aclosing(_follow(self, job_id, 0, deadline)) as coming:
            async for event in coming:
                if on_event is not None:
                    on_event(event)
        job = await get(self, job_id)
    except SilentStreamError:
        while not (job := await get(self, job_id)).ended and (pause := pause_before(deadline)) > 0.0:
            await asyncio.sleep(pause)
    if job.state == "failed":
        raise JobFailedError(job)
    if not job.ended:
        raise WaitTimeoutError(job_id, timeout or 0.0)
    return job


async def _follow(
    self: AsyncConnection, job_id: str, after: int, deadline: float | None
) -> AsyncGenerator[Event, None]:
    follower = Follower(after, patience=self._patience, silence=self._stream_timeout, deadline=deadline)
    while not follower.expired:
        headers = {"Accept": "text/event-stream", "Last-Event-ID": str(follower.last_id)}
        timeout = httpx.Timeout(self._timeout, read=follower.read_timeout())
        try:
            async with self._http.stream(
                "GET", f"{job_path(job_id)}/events", headers=headers, timeout=timeout
            ) as response:
                if response.status_code == httpx.codes.NO_CONTENT:
                    return
                if not response.is_success:
                    await response.aread()
                    raise error_of(response)
                async for line in response.aiter_lines():
                    event = follower.hear(line)
                    if event is not None:
                        yield event
                    if follower.ended or follower.expired:
                        return
                    if follower.should_reconnect:
                        break
                else:
                    await asyncio.sleep(follower.broken(None))
        except (httpx.HTTPError, GeoswarmError) as error:
            await asyncio.sleep(follower.broken(error))
