"""Runs alongside a worker: signals that it is alive, renews its leases, and checks whether its work is still wanted."""

from __future__ import annotations

import logging
import threading
import time

from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Claim
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.identity import Identity
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.queries.evaluations import still_wanted
from geoswarm.workers.queries.workers import see_worker
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

__all__ = ["Heartbeat"]

log = logging.getLogger(__name__)


class Heartbeat:
    """Heartbeat and lookout of one worker, in a thread of its own."""

    def __init__(self, store: Store, runtime: Runtime, settings: Settings, identity: Identity) -> None:
        self.store = store
        self.runtime = runtime
        self.settings = settings
        self.identity = identity
        self.stopping = threading.Event()  # the worker is to end
        self._ended = threading.Event()
        self._claim: Claim | None = None
        self._claimed = 0.0
        self._unwanted: tuple[Claim, float] | None = None
        self.late = False
        """The last heartbeat took longer to reach the database than the time until the next one."""
        self._thread = threading.Thread(target=self._beat, name="geoswarm-heartbeat", daemon=True)

    def start(self) -> None:
        """Register the worker and start.

        Raises
        ------
        StoreUnavailableError
        """
        self._see()
        self._thread.start()

    def stop(self) -> None:
        """End the thread."""
        self.stopping.set()
        self._ended.set()
        if self._thread.is_alive():
            self._thread.join()

    @property
    def claim(self) -> Claim | None:
        """What the worker holds."""
        return self._claim

    @claim.setter
    def claim(self, claim: Claim | None) -> None:
        self._claim = claim
        self._claimed = time.monotonic()

    def unwanted(self) -> float | None:
        """Return how long the evaluation under way may still take [s], None: it is wanted."""
        found, claim = self._unwanted, self._claim
        if found is not None and found[0] is claim:
            return found[1]
        return 0.6 * self.settings.grace_seconds if self.stopping.is_set() else None

    def _beat(self) -> None:
        beaten = looked = time.monotonic()
        half = 0.5 * self.settings.watch_seconds
        while not self._ended.wait(half):
            now = time.monotonic()
            due = now - beaten >= self.settings.heartbeat_seconds
            claim = self._claim
            try:
                if due:
                    beaten = now
                    self._see()
                    self.late = time.monotonic() - now > self.settings.heartbeat_seconds
                    process_counters.flush(self.store)
                # The exchange that gave the claim was a look, too.
                look = now - self._claimed >= half and now - looked >= 1.9 * half
                if claim is not None and (due or look):
                    looked = now
                    self._look_after(claim, renew=due)
            except StoreUnavailableError as error:
                log.warning("heartbeat of worker %s: %s", self.identity.id, error)

    def _look_after(self, claim: Claim, *, renew: bool) -> None:
        if renew:
            self.runtime.renew(claim, self.identity.id)
        state = self.store.read(lambda c: still_wanted(c, claim.job_id, claim.generation, claim.particles))
        if state != "running":
            self._unwanted = (claim, self.settings.pause_seconds if state == "paused" else 0.0)

    def _see(self) -> None:
        self.store.write(lambda connection: see_worker(connection, self.identity))
