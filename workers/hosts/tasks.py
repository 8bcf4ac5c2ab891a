"""What runs inside the pool processes of a Celery worker."""

from __future__ import annotations

import logging
import mmap
import os
import threading
import time
from dataclasses import dataclass, field
from typing import Any

from celery import current_app, shared_task
from celery.signals import worker_init, worker_process_init, worker_process_shutdown, worker_shutting_down

from geoswarm.solver.kernels.cache import settle
from geoswarm.solver.runner.isolated import isolate_foreign_models
from geoswarm.solver.runner.output import anonymous_file
from geoswarm.solver.system.processes import kill_descendants
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.execution.slots import Slots
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.hosts.celery_app import SERVE_TASK, CeleryWaker
from geoswarm.workers.identity import Identity
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

__all__ = ["serve"]

log = logging.getLogger(__name__)

ENDING_SECONDS = 0.2
CLOSING_SECONDS = 5.0  # that pool processes may need to hand in and sign off, beyond the grace for what they run


@dataclass(slots=True)
class _Process:
    """What belongs to one pool process; made after the fork, as connections must not be shared."""

    store: Store
    waker: CeleryWaker
    worker: Worker
    sweeper: Sweeper
    working: threading.Lock = field(default_factory=threading.Lock)
    closed: bool = False

    def work(self) -> None:
        """Serve the most urgent jobs for a time slice; the caller holds ``working``."""
        worker = self.worker
        until = time.monotonic() + worker.settings.slice_seconds
        try:
            while not worker.stopping.is_set() and time.monotonic() <= until:
                if (turn := worker.take_turn()) is None:
                    return
                worker.serve(*turn)
            if not worker.stopping.is_set() and (urgent := worker.most_urgent()) is not None:
                self.waker.wake(urgent.id, kind=urgent.forward_model)  # one wake-up was used, one for what is left
        except StoreUnavailableError as error:
            log.warning("worker %s: %s", worker.identity.id, error)

    def close(self) -> None:
        """Let the worker finish what it is at, end it, and close what it holds; nothing when that was done before."""
        self.worker.stopping.set()
        with self.working:
            if not self.closed:
                self.closed = True
                self.sweeper.stop()
                self.worker.close()
                self.waker.close()
                self.store.close()


_process: _Process | None = None

# Made before the fork, so that all pool processes share them: whether the worker is to end, and the slots of the group.
_ending = mmap.mmap(-1, 1)
_slots = anonymous_file()


@worker_init.connect  # type: ignore[untyped-decorator]  # Celery has no types
def _settle(**_: Any) -> None:
    settle()  # once for all pool processes


@worker_shutting_down.connect  # type: ignore[untyped-decorator]  # Celery has no types
def _announce_end(**_: Any) -> None:
    _ending[0] = 1
    threading.Thread(target=_insist_on_end, name="geoswarm-end", daemon=True).start()


def _insist_on_end() -> None:
    """End the Celery worker although it waits for ever, for tasks of killed processes of which it has lost count."""
    settings: Settings = current_app.geoswarm_settings
    time.sleep(settings.grace_seconds + CLOSING_SECONDS)
    log.warning("Celery still waits for tasks; the worker ends without it, and its evaluations go to other workers")
    kill_descendants(os.getpid())
    os._exit(0)


@worker_process_init.connect  # type: ignore[untyped-decorator]  # Celery has no types
def _open(**_: Any) -> None:
    global _process
    settings: Settings = current_app.geoswarm_settings
    if settings.isolate:
        isolate_foreign_models(settings.build_memory_mb, settings.passed_environment)
    store = Store(settings)
    waker = CeleryWaker(settings)
    worker = Worker(store, waker, settings, Identity.new("celery"), Slots(settings.slots, _slots))
    worker.start()
    sweeper = Sweeper(worker.runtime, waker)
    sweeper.start()
    process = _Process(store, waker, worker, sweeper)
    for follow in (_follow_end, _look_around):
        threading.Thread(target=follow, args=(process,), name=f"geoswarm{follow.__name__}", daemon=True).start()
    _process = process


def _follow_end(process: _Process) -> None:
    """Close when the Celery worker is to end, without waiting for its leave, and end with one that was killed.

    What runs has some seconds to finish, then it is given back.
    """
    parent = os.getppid()
    while not _ending[0] and os.getppid() == parent:
        if process.worker.stopping.wait(ENDING_SECONDS):
            return
    process.close()
    while os.getppid() == parent:
        time.sleep(ENDING_SECONDS)
    os._exit(1)


def _look_around(process: _Process) -> None:
    """Look for work without a wake-up: Redis may be down, or Celery may no longer listen after it was."""
    worker = process.worker
    while not worker.stopping.wait(worker.settings.sweep_seconds):
        if process.working.acquire(blocking=False):
            try:
                process.work()
            finally:
                process.working.release()


@worker_process_shutdown.connect  # type: ignore[untyped-decorator]  # Celery has no types
def _close(**_: Any) -> None:
    global _process
    if _process is not None:
        process, _process = _process, None
        process.close()


@shared_task(name=SERVE_TASK, ignore_result=True)  # type: ignore[untyped-decorator]  # Celery has no types
def serve(job_id: str) -> None:  # noqa: ARG001  a reader of the queue shall see the job of a message
    """Answer a wake-up: there may be work, not necessarily for its job, as others may be more urgent."""
    if _process is None:
        _open()  # the database did not answer when this process began
    if _process is None:
        return
    with _process.working:
        _process.work()
