"""The asynchronous client."""

from __future__ import annotations

import asyncio
import time
from collections.abc import AsyncGenerator, AsyncIterator, Callable, Mapping
from contextlib import aclosing
from pathlib import Path
from types import TracebackType
from typing import Any, Literal, TypeVar

import httpx

from geoswarm.client import calls
from geoswarm.client.administration import AsyncAdministration
from geoswarm.client.calls import Call, Problem, SortKey
from geoswarm.client.drafts import AsyncDrafts
from geoswarm.client.errors import GeoswarmError, JobFailedError, WaitTimeoutError
from geoswarm.client.files import partial_file
from geoswarm.client.follow import Follower, SilentStreamError, pause_before
from geoswarm.client.models import (
    Attempt,
    Best,
    CheckResult,
    Evaluation,
    Event,
    ForwardModel,
    ForwardModelInfo,
    Generation,
    Health,
    Job,
    Page,
    Retry,
    WarmStart,
    Worker,
)
from geoswarm.client.results import AsyncResults
from geoswarm.client.statistics import AsyncStatistics

__all__ = ["AsyncClient"]

T = TypeVar("T")


class AsyncClient(AsyncResults, AsyncStatistics, AsyncDrafts, AsyncAdministration):
    """Talks to a geoswarm service. Lives in one event loop; close it, or use it in an ``async with`` statement.

    The methods are those of :class:`geoswarm.client.sync.Client`.

    Parameters
    ----------
    base_url
        Address of the service; GEOSWARM_URL or http://127.0.0.1:8765 when not given.
    api_key
        GEOSWARM_API_KEY when not given.
    timeout
        How long one request may take to answer [s].
    patience
        How long the service may be out of reach while events are followed, for example in a restart [s].
    stream_timeout
        A connection with events is renewed when nothing, not even a sign of life, came for so long [s].
    transport
        Replaces the network, for tests.

    Raises
    ------
    GeoswarmError
        Every method: see :mod:`geoswarm.client.errors`.
    """

    def __init__(
        self,
        base_url: str | None = None,
        api_key: str | None = None,
        *,
        timeout: float = 60.0,
        patience: float = 60.0,
        stream_timeout: float = 45.0,
        transport: httpx.AsyncBaseTransport | None = None,
    ) -> None:
        self.base_url, headers = calls.connection_settings(base_url, api_key)
        self._patience = patience
        self._stream_timeout = stream_timeout
        self._timeout = timeout
        self._http = httpx.AsyncClient(
            base_url=self.base_url,
            headers=headers,
            timeout=httpx.Timeout(timeout, connect=min(timeout, 10.0)),
            transport=transport or httpx.AsyncHTTPTransport(retries=2),
        )

    async def __aenter__(self) -> AsyncClient:
        return self

    async def __aexit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        await self.close()

    async def close(self) -> None:
        """Close all connections."""
        await self._http.aclose()

    async def submit(self, problem: Problem, idempotency_key: str | None = None) -> Job:
        """Submit a problem, a mapping or the path of a problem file; files with measurements are sent along.

        The same ``idempotency_key`` with the same problem gives the same job, however often it is sent.
        """
        return await self._send(await asyncio.to_thread(calls.submit, problem, idempotency_key))

    async def check(self, problem: Problem) -> CheckResult:
        """Validate a problem, let the service make one test run and estimate the cost."""
        return await self._send(await asyncio.to_thread(calls.check, problem))

    async def warm_starts(self, problem: Problem) -> tuple[WarmStart, ...]:
        """Return earlier jobs of the same forward model whose stored evaluations a search could learn from."""
        return await self._send(await asyncio.to_thread(calls.warm_starts, problem))

    async def list(
        self,
        *,
        state: str | None = None,
        search: str | None = None,
        owner: str | None = None,
        sort: SortKey | None = None,
        order: Literal["ascending", "descending"] | None = None,
        trend: int | None = None,
        limit: int = 50,
        cursor: str | None = None,
    ) -> Page[Job]:
        """List jobs, newest first unless ``sort`` says otherwise.

        Parameters
        ----------
        state, search, owner
            Only jobs in this state, with this text in name, model, method or owner, of this owner.
        sort, order
            Newest, best or largest first, names from A to Z, unless ``order`` says otherwise.
        trend
            Most values of each job's convergence; none when not given.
        """
        return await self._send(
            calls.list_jobs(
                state=state, q=search, owner=owner, sort=sort, order=order, trend=trend, limit=limit, cursor=cursor
            )
        )

    async def iterate_jobs(self, *, state: str | None = None) -> AsyncIterator[Job]:
        """Go through all jobs, newest first."""
        cursor = None
        while True:
            page = await self.list(state=state, limit=200, cursor=cursor)
            for item in page.items:
                yield item
            if (cursor := page.next_cursor) is None:
                return

    async def get(self, job_id: str) -> Job:
        """Show a job."""
        return await self._send(calls.get(job_id))

    async def problem(self, job_id: str) -> dict[str, Any]:
        """Show the problem of a job, complete: it can be submitted again."""
        return await self._send(calls.problem(job_id))

    async def cancel(self, job_id: str) -> Job:
        """End a job now; what it has found stays."""
        return await self._send(calls.change(job_id, "cancel"))

    async def pause(self, job_id: str) -> Job:
        """Hold a job."""
        return await self._send(calls.change(job_id, "pause"))

    async def resume(self, job_id: str) -> Job:
        """Go on with a paused job."""
        return await self._send(calls.change(job_id, "resume"))

    async def change_stopping(self, job_id: str, stopping: Mapping[str, Any]) -> Job:
        """Replace all stop criteria of a job; one that has finished or was cancelled goes on where it was."""
        return await self._send(calls.change_stopping(job_id, stopping))

    async def retry_failed(self, job_id: str) -> Retry:
        """Run the failed evaluations of a paused or ended job again, and only them."""
        return await self._send(calls.retry_failed(job_id))

    async def attempts(self, job_id: str, generation: int, particle: int) -> tuple[Attempt, ...]:
        """Show every try at one evaluation: by whom, when, and how it ended."""
        return await self._send(calls.attempts(job_id, generation, particle))

    async def delete(self, job_id: str) -> None:
        """Delete an ended job with everything that belongs to it."""
        await self._send(calls.delete(job_id))

    async def best(self, job_id: str) -> Best:
        """Show the best evaluation with its responses; NotFoundError when there is none yet."""
        return await self._send(calls.best(job_id))

    async def generations(
        self, job_id: str, *, after: int = -1, limit: int = 1000, diversity: bool = False, points: int | None = None
    ) -> tuple[Generation, ...]:
        """Show finished generations with a number above ``after``; with ``diversity`` also their scatter.

        Parameters
        ----------
        points
            At most so many, evenly spaced over all of them.
        """
        return await self._send(calls.generations(job_id, after, limit, diversity, points))

    async def evaluations(
        self,
        job_id: str,
        *,
        generation: int | None = None,
        state: str | None = None,
        max_objective: float | None = None,
        limit: int = 100,
        cursor: str | None = None,
        responses: bool = False,
    ) -> Page[Evaluation]:
        """Show one page of evaluations, ordered by generation and particle."""
        return await self._send(
            calls.evaluations(
                job_id,
                generation=generation,
                state=state,
                max_objective=max_objective,
                limit=limit,
                cursor=cursor,
                responses=responses,
            )
        )

    async def iterate_evaluations(
        self,
        job_id: str,
        *,
        generation: int | None = None,
        state: str | None = None,
        max_objective: float | None = None,
        responses: bool = False,
    ) -> AsyncIterator[Evaluation]:
        """Go through all evaluations that match."""
        cursor = None
        while True:
            page = await self.evaluations(
                job_id,
                generation=generation,
                state=state,
                max_objective=max_objective,
                limit=500,
                cursor=cursor,
                responses=responses,
            )
            for item in page.items:
                yield item
            if (cursor := page.next_cursor) is None:
                return

    async def download_evaluations(
        self,
        job_id: str,
        path: str | Path,
        *,
        generation: int | None = None,
        state: str | None = None,
        max_objective: float | None = None,
        form: Literal["csv", "parquet"] = "csv",
        responses: bool = False,
    ) -> Path:
        """Write all evaluations that match to a CSV or Parquet file; it appears only when it is complete.

        Parameters
        ----------
        responses
            With the calculated series; Parquet only.
        """
        filters = {"generation": generation, "state": state, "max_objective": max_objective}
        call = calls.evaluations_file(job_id, form, responses, **filters)
        with partial_file(Path(path)) as file:
            try:
                async with self._http.stream(call.method, call.path, params=dict(call.query)) as response:
                    if not response.is_success:
                        await response.aread()
                        raise calls.error_of(response)
                    async for chunk in response.aiter_bytes():
                        file.write(chunk)
            except httpx.HTTPError as error:
                raise calls.connection_failed(self.base_url, error) from error
        return Path(path)

    async def events(self, job_id: str, after: int = 0) -> AsyncIterator[Event]:
        """Follow a job: every event after the given one, as it comes, until the job has ended.

        A broken connection is taken up again where it broke; no event is lost or doubled.
        """
        async with aclosing(self._follow(job_id, after, None)) as events:
            async for event in events:
                yield event

    async def wait(
        self, job_id: str, timeout: float | None = None, on_event: Callable[[Event], object] | None = None
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
            It did not end in time.
        JobFailedError
            It has failed.
        """
        deadline = None if timeout is None else time.monotonic() + timeout
        await self.get(job_id)  # an unknown job, or no service, is told at once
        try:
            async with aclosing(self._follow(job_id, 0, deadline)) as events:
                async for event in events:
                    if on_event is not None:
                        on_event(event)
            job = await self.get(job_id)
        except SilentStreamError:
            while not (job := await self.get(job_id)).ended and (pause := pause_before(deadline)) > 0.0:
                await asyncio.sleep(pause)
        if job.state == "failed":
            raise JobFailedError(job)
        if not job.ended:
            raise WaitTimeoutError(job_id, timeout or 0.0)
        return job

    async def forward_models(self) -> tuple[ForwardModelInfo, ...]:
        """List the kinds of forward model that the service has."""
        return await self._send(calls.forward_models())

    async def forward_model(self, kind: str) -> ForwardModel:
        """Show a kind of forward model: schema, parameters, series, units."""
        return await self._send(calls.forward_model(kind))

    async def workers(self) -> tuple[Worker, ...]:
        """List the workers."""
        return await self._send(calls.workers())

    async def health(self) -> Health:
        """Show whether the service can work."""
        return await self._send(calls.health())

    async def _send(self, call: Call[T]) -> T:
        try:
            response = await self._http.request(
                call.method, call.path, params=dict(call.query), headers=dict(call.headers), content=call.content
            )
        except httpx.HTTPError as error:
            raise calls.connection_failed(self.base_url, error) from error
        if not response.is_success and response.status_code not in call.accepted:
            raise calls.error_of(response)
        return call.read(response)

    async def _follow(self, job_id: str, after: int, deadline: float | None) -> AsyncGenerator[Event, None]:
        follower = Follower(after, patience=self._patience, silence=self._stream_timeout, deadline=deadline)
        while not follower.expired:
            call = calls.events(job_id, follower.last_id)
            timeout = httpx.Timeout(self._timeout, read=follower.read_timeout())
            try:
                async with self._http.stream(
                    call.method, call.path, headers=dict(call.headers), timeout=timeout
                ) as response:
                    if response.status_code == httpx.codes.NO_CONTENT:
                        return
                    if not response.is_success:
                        await response.aread()
                        raise calls.error_of(response)
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
