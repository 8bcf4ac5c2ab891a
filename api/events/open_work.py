"""Wakes agents that wait for work: one look at the database for all of them, however many they are."""

from __future__ import annotations

import asyncio
import contextlib
import logging
import math
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial
from typing import TypeVar

import anyio
import anyio.to_thread
from starlette.types import Receive

from geoswarm.workers.agents.desk import AgentDesk, OpenWork, accepts
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.store.event_listener import EventListener

__all__ = ["OpenWorkWatch"]

log = logging.getLogger("geoswarm.api")

T = TypeVar("T")

THREADS = 8  # that speak to the database for agents
WOKEN = 4  # at once: each one that finds work wakes two more
RETRY_SECONDS = 1.0
QUIET_SECONDS = 5.0  # without work it is looked less often: after so long,
QUIET_FACTOR, ANNOUNCED_FACTOR = 5.0, 20.0  # fewer queries; the second where the database announces changes
SEEN_SHARE = 0.4  # of a lease, after which it is noted again that waiting workers are alive


@dataclass(slots=True, eq=False)
class _Waiter:
    agent: str
    offers: frozenset[str]
    ends: float | None  # monotonic time at which the agent ends [s]
    woken: asyncio.Event = field(default_factory=asyncio.Event)
    over: bool = False

    def dismiss(self) -> None:
        """Have it wait no longer, and ask for nothing."""
        self.over = True
        self.woken.set()


class OpenWorkWatch:
    """The agents of one process of the service that wait for work; lives in its event loop.

    Parameters
    ----------
    service
        Whose store and waker serve the agents.
    poll_seconds
        Interval between queries while a client waits [s]. Without news for a while it grows, until the database
        announces changes.
    """

    def __init__(self, service: JobService, *, poll_seconds: float = 0.1) -> None:
        self._service = service
        self.closed = False
        self._poll = poll_seconds
        self._waiters: dict[_Waiter, None] = {}  # in the order in which they came
        self._poller: asyncio.Task[None] | None = None
        self._limiter: anyio.CapacityLimiter | None = None
        self._rung = asyncio.Event()
        self._wanted = WOKEN
        self._work: OpenWork = ()
        self._looked_at = self._worked_at = -math.inf
        self._listener: EventListener | None = None
        self._told = False

    @cached_property
    def desk(self) -> AgentDesk:
        """Where agents are served; made when the first one comes."""
        return AgentDesk(self._service.store, self._service.waker, self._service.settings)

    @property
    def waiting(self) -> int:
        """Number of requests that wait."""
        return len(self._waiters)

    async def in_thread(self, call: Callable[[], T]) -> T:
        """Make a call that speaks to the database, with others in a few threads."""
        if self._limiter is None:
            self._limiter = anyio.CapacityLimiter(THREADS)
            loop = asyncio.get_running_loop()

            def wake(_job_id: str, number: int) -> None:
                with contextlib.suppress(RuntimeError):  # the loop has ended before the thread
                    loop.call_soon_threadsafe(self._wake, number)

            self.desk.on_work = wake
        return await anyio.to_thread.run_sync(call, limiter=self._limiter)

    def nothing_for(self, offers: frozenset[str], left: float | None) -> bool:
        """Whether the last look, a moment ago, has found nothing for an agent that runs for some time yet [s].

        A waiting client misses nothing: the next query is for all.
        """
        recent = time.monotonic() - self._looked_at <= 2.0 * self._interval()
        return recent and not self.closed and not accepts(offers, self._work, left)

    async def wait(
        self, agent: str, offers: frozenset[str], left: float | None, seconds: float, receive: Receive
    ) -> bool:
        """Wait until there may be work for an agent that runs for some time yet [s], or some seconds [s] have passed.

        Return whether there may be. While it waits the agent counts as seen, unless it disconnects.
        """
        if self.closed or seconds <= 0:
            return False
        waiter = _Waiter(agent, offers, None if left is None else time.monotonic() + left)
        self._waiters[waiter] = None
        if self._poller is None or self._poller.done():
            self._poller = asyncio.create_task(self._follow(), name="work for agents")
        if self._listener is None:
            loop = asyncio.get_running_loop()

            def hear() -> None:
                with contextlib.suppress(RuntimeError):  # the loop has ended before the thread
                    loop.call_soon_threadsafe(self._hear)

            self._listener = EventListener(self._service.store, hear)
            self._listener.start()
        leaving = asyncio.create_task(_disconnected(receive))
        leaving.add_done_callback(lambda _: waiter.dismiss())
        try:
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(waiter.woken.wait(), seconds)
            return waiter.woken.is_set() and not waiter.over
        finally:
            leaving.cancel()
            self._waiters.pop(waiter, None)
            if not self._waiters and self._poller is not None:
                self._poller.cancel()
                self._poller = None

    def dismiss(self, agent: str) -> None:
        """End the waiting of an agent that has signed off; called in the event loop."""
        for waiter in self._waiters:
            if waiter.agent == agent:
                waiter.dismiss()

    def close(self) -> None:
        """End all waiting; called in the event loop."""
        self.closed = True
        if self._listener is not None:
            self._listener.stop()
        for waiter in self._waiters:
            waiter.woken.set()
        if "desk" in vars(self):
            self.desk.close()

    def _wake(self, number: int) -> None:
        self._wanted = max(self._wanted, number)
        self._rung.set()

    def _hear(self) -> None:
        """There may be news: look, if that was not done just now; events of running jobs come in crowds."""
        if not self._told and not self.closed:
            self._told = True
            after = max(self._looked_at + self._poll - time.monotonic(), 0.0)
            asyncio.get_running_loop().call_later(after, self._rung.set)

    async def _follow(self) -> None:
        seen = time.monotonic()
        while True:
            self._rung.clear()
            self._told = False
            wanted, self._wanted = self._wanted, WOKEN
            try:
                work = self._work = await self.in_thread(self.desk.open_work)
                now = self._looked_at = time.monotonic()
                if work:
                    self._worked_at = now
                if now - seen >= SEEN_SHARE * self.desk.settings.lease_seconds:
                    seen = now
                    waiting = {waiter.agent for waiter in self._waiters}
                    await self.in_thread(partial(self.desk.see, waiting))
            except StoreUnavailableError as error:
                log.warning("work for agents cannot be looked for now: %s", error)
                await asyncio.sleep(RETRY_SECONDS)
                continue
            now = time.monotonic()
            for waiter in list(self._waiters) if work else ():
                left = None if waiter.ends is None else waiter.ends - now
                if not waiter.woken.is_set() and accepts(waiter.offers, work, left):
                    waiter.woken.set()
                    wanted -= 1
                    if wanted == 0:
                        break
            with contextlib.suppress(TimeoutError):
                await asyncio.wait_for(self._rung.wait(), self._interval())

    def _interval(self) -> float:
        if time.monotonic() - self._worked_at <= QUIET_SECONDS:
            return self._poll
        return self._poll * (ANNOUNCED_FACTOR if self._listener is not None and self._listener.live else QUIET_FACTOR)


async def _disconnected(receive: Receive) -> None:
    while (await receive())["type"] != "http.disconnect":
        pass
