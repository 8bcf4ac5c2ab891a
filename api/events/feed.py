"""Live events of jobs: one query for all watched jobs when there is news, or once a tick, however many listeners.

The database is the only source, so a listener of any process sees the events of every process, and what was missed
between two connections is read again. Reads run in a few threads of their own; a waiting listener holds neither a
thread nor a connection.
"""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import time
from collections import deque
from collections.abc import AsyncGenerator, Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import takewhile
from typing import TypeVar

import anyio
import anyio.to_thread
from cachetools import FIFOCache

from geoswarm.records.job import Event
from geoswarm.records.states import ENDED_STATES
from geoswarm.workers.errors import JobNotFoundError, StoreUnavailableError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.store.event_listener import EventListener

__all__ = ["BatchTexts", "EventFeed", "MOST_GENERATIONS", "encode_event", "thinned"]

logger = logging.getLogger("geoswarm.api")

KEPT_EVENTS = 500
BATCH = 500
RETRY_SECONDS = 2.0
READING_THREADS = 4
EXISTENCE_SECONDS = 2.0  # how soon listeners learn that their job was deleted
GATHER_SECONDS = 0.005
PACE_SECONDS = 0.1  # between two queries that find news: one batch holds all news of a busy job
QUIET_SECONDS = 1.0  # between two queries while the database announces events

T = TypeVar("T")


MOST_GENERATIONS = 25
"""Generations of one batch that are sent to those who follow a running job."""
_KEPT = 8


class BatchTexts:
    """Texts of the latest batches of one job."""

    def __init__(self) -> None:
        self._texts: FIFOCache[tuple[int, int, int], str] = FIFOCache(_KEPT)

    def of(self, batch: Sequence[Event]) -> str:
        """Return the text of a batch, written at the first request."""
        key = (batch[0].id, batch[-1].id, len(batch))
        if key not in self._texts:
            self._texts[key] = "".join(map(encode_event, batch))
        return self._texts[key]


@dataclass(eq=False, slots=True)
class _Tail:
    """The newest events of one watched job: all with an id above ``floor`` are in ``events``."""

    floor: int
    last: int
    events: deque[Event] = field(default_factory=deque)
    changed: asyncio.Event = field(default_factory=asyncio.Event)
    listeners: int = 0
    gone: bool = False
    caught_up: bool = False  # what comes now has just happened
    texts: BatchTexts = field(default_factory=BatchTexts)

    def wake(self) -> None:
        changed, self.changed = self.changed, asyncio.Event()
        changed.set()

    def after(self, last: int) -> list[Event]:
        """Events that follow one, looked for from the newest: most listeners lack only a few."""
        return list(takewhile(lambda event: event.id > last, reversed(self.events)))[::-1]

    def add(self, batch: list[Event]) -> None:
        self.events.extend(thinned(batch) if self.caught_up else batch)
        self.last = batch[-1].id
        while len(self.events) > KEPT_EVENTS:
            self.floor = self.events.popleft().id
        self.wake()


class EventFeed:
    """Event streams of one process; lives in its event loop.

    Parameters
    ----------
    service
        Where events are read.
    poll_seconds
        Interval at which the watched jobs are looked at [s] where the database sends no notifications of events.
    heartbeat_seconds
        Twice the silence after which :meth:`listen` yields None [s].
    """

    def __init__(self, service: JobService, *, poll_seconds: float = 0.1, heartbeat_seconds: float = 10.0) -> None:
        self._service = service
        self._poll = poll_seconds
        self.heartbeat_seconds = heartbeat_seconds
        self._tails: dict[str, _Tail] = {}
        self._limiter: anyio.CapacityLimiter | None = None
        self._closed = False
        self._poller: asyncio.Task[None] | None = None
        self._listener: EventListener | None = None
        self._rung = asyncio.Event()

    @property
    def watched(self) -> int:
        """Number of jobs that are being polled."""
        return len(self._tails)

    @property
    def listeners(self) -> int:
        """Number of open streams."""
        return sum(tail.listeners for tail in self._tails.values())

    async def read(self, job_id: str, after: int) -> list[Event]:
        """Read the events that follow ``after`` from the database, at most one batch.

        Raises
        ------
        JobNotFoundError, StoreUnavailableError
        """
        return await self._in_thread(lambda: self._service.events(job_id, after=after, limit=BATCH))

    async def has_ended(self, job_id: str) -> bool:
        """Whether the job is finished, failed or cancelled.

        Raises
        ------
        JobNotFoundError, StoreUnavailableError
        """
        return await self._in_thread(lambda: self._service.get(job_id).state in ENDED_STATES)

    async def listen(self, job_id: str, after: int) -> AsyncGenerator[str | None, None]:
        """Yield the events that follow ``after`` as they come, None as a sign of life in silence.

        The events of a batch are one text, which is written once for all listeners of a job. Of many generations at
        once some are left out, never the last one. Ends after the event that ends the job, when the job is deleted,
        and when the feed is closed.
        """
        tail = self._join(job_id, after)
        try:
            while not self._closed:
                changed = tail.changed
                batch = tail.after(after)
                if after < tail.floor:  # further back than what is kept
                    try:
                        batch = await self.read(job_id, after) or batch
                    except JobNotFoundError:
                        return
                    except StoreUnavailableError:
                        batch = []
                if batch:
                    yield tail.texts.of(batch)
                    after = batch[-1].id
                    if batch[-1].ends_job:
                        return
                    await asyncio.sleep(0)  # others first
                    continue
                if tail.gone:
                    return
                try:
                    await asyncio.wait_for(changed.wait(), 0.5 * self.heartbeat_seconds)
                except TimeoutError:
                    yield None
        finally:
            self._leave(job_id, tail)

    def close(self) -> None:
        """End every stream at once; called in the event loop."""
        self._closed = True
        for tail in self._tails.values():
            tail.wake()

    async def _in_thread(self, call: Callable[[], T]) -> T:
        if self._limiter is None:
            self._limiter = anyio.CapacityLimiter(READING_THREADS)
        return await anyio.to_thread.run_sync(call, limiter=self._limiter)

    def _join(self, job_id: str, after: int) -> _Tail:
        tail = self._tails.get(job_id)
        if tail is None or tail.gone:
            tail = self._tails[job_id] = _Tail(floor=after, last=after)
            self._rung.set()
            if self._poller is None or self._poller.done():
                self._rest()
                self._poller = asyncio.create_task(self._follow(), name="events of watched jobs")
                self._listener = EventListener(
                    self._service.store, partial(_set_from_thread, asyncio.get_running_loop(), self._rung)
                )
                self._listener.start()
        tail.listeners += 1
        return tail

    def _leave(self, job_id: str, tail: _Tail) -> None:
        tail.listeners -= 1
        if tail.listeners == 0 and self._tails.get(job_id) is tail:
            del self._tails[job_id]
            if not self._tails:
                self._rest()

    def _rest(self) -> None:
        if self._poller is not None:
            self._poller.cancel()
            self._poller = None
        if self._listener is not None:
            self._listener.stop()
            self._listener = None

    async def _follow(self) -> None:
        check_at = time.monotonic() + EXISTENCE_SECONDS
        while True:
            self._rung.clear()
            looked = time.monotonic()
            watched = {job_id: (tail, tail.last) for job_id, tail in self._tails.items()}
            try:
                count = await self._look(watched)
                if time.monotonic() >= check_at:
                    await self._find_deleted(watched)
                    check_at = time.monotonic() + EXISTENCE_SECONDS
            except StoreUnavailableError as error:
                logger.warning("events cannot be read now: %s", error)
                await asyncio.sleep(RETRY_SECONDS)
                continue
            if count < BATCH:
                patience = QUIET_SECONDS if self._listener is not None and self._listener.live else self._poll
                with contextlib.suppress(TimeoutError):
                    await asyncio.wait_for(self._rung.wait(), patience)
                    pause = looked + PACE_SECONDS - time.monotonic() if count else 0.0
                    await asyncio.sleep(max(pause, GATHER_SECONDS))  # what else comes now shares the query

    async def _look(self, watched: Mapping[str, tuple[_Tail, int]]) -> int:
        """Give every tail its new events; return how many came."""
        after = {job_id: last for job_id, (_, last) in watched.items()}
        news = await self._in_thread(lambda: self._service.news(after, limit=BATCH))
        batches: dict[str, list[Event]] = {}
        for job_id, event in news:
            batches.setdefault(job_id, []).append(event)
        for job_id, batch in batches.items():
            tail, last = watched[job_id]
            if self._tails.get(job_id) is tail and tail.last == last:  # no client left and came back meanwhile
                tail.add(batch)
        if len(news) < BATCH:
            for tail, _ in watched.values():
                tail.caught_up = True
        return len(news)

    async def _find_deleted(self, watched: Mapping[str, tuple[_Tail, int]]) -> None:
        there = await self._in_thread(lambda: self._service.existing(watched))
        for job_id in watched.keys() - there:
            tail, _ = watched[job_id]
            tail.gone = True
            tail.wake()


def _set_from_thread(loop: asyncio.AbstractEventLoop, event: asyncio.Event) -> None:
    with contextlib.suppress(RuntimeError):  # the loop has ended before the thread
        loop.call_soon_threadsafe(event.set)


def encode_event(event: Event) -> str:
    """Write an event as the lines of an event stream; ``data`` is one line of JSON."""
    data = json.dumps(event.data, allow_nan=False, separators=(",", ":"))
    return f"id: {event.id}\nevent: {event.kind}\ndata: {data}\n\n"


def thinned(batch: Sequence[Event]) -> list[Event]:
    """Leave out generations where there are many, evenly; the last one and every other kind of event stay."""
    places = [place for place, event in enumerate(batch) if event.kind == "generation"]
    if len(places) <= MOST_GENERATIONS:
        return list(batch)
    step = len(places) / MOST_GENERATIONS
    told = {places[int((number + 1) * step) - 1] for number in range(MOST_GENERATIONS)} | {places[-1]}
    return [event for place, event in enumerate(batch) if event.kind != "generation" or place in told]
