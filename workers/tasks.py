"""What runs inside the pool processes of a Celery worker."""

from __future__ import annotations

import logging
import mmap
import threading
import time
from dataclasses import dataclass
from typing import Any

from celery import current_app, shared_task
from celery.signals import worker_init, worker_process_init, worker_process_shutdown, worker_shutting_down

from workers.celery_app import SERVE_TASK, CeleryDoorbell
from workers.errors import StoreUnavailableError
from workers.identity import Identity
from workers.runner.wire import anonymous_file
from workers.settings import Settings
from workers.slots import Slots
from workers.store import Store
from workers.sweep import Sweeper
from workers.warm import warm_up
from workers.worker import Worker

__all__ = ["serve"]

log = logging.getLogger(__name__)

ENDING_SECONDS = 0.2


@dataclass(slots=True)
class _Process:
    """What belongs to one pool process; made after the fork, as connections must not be shared."""

    store: Store
    doorbell: CeleryDoorbell
    worker: Worker
    sweeper: Sweeper


_process: _Process | None = None

# Made before the fork, so that all pool processes share them: whether the worker is to end, and the slots of the group.
_ending = mmap.mmap(-1, 1)
_slots = anonymous_file()


@worker_init.connect  # type: ignore[untyped-decorator]
def _warm_up(**_: Any) -> None:
    settings: Settings = current_app.geoswarm_settings
    if not settings.isolate:
        warm_up()  # before the fork: every pool process, restarted ones too, begins with the forward models loaded


@worker_shutting_down.connect  # type: ignore[untyped-decorator]
def _announce_end(**_: Any) -> None:
    _ending[0] = 1


@worker_process_init.connect  # type: ignore[untyped-decorator]
def _open(**_: Any) -> None:
    global _process
    settings: Settings = current_app.geoswarm_settings
    store = Store(settings)
    doorbell = CeleryDoorbell(settings)
    worker = Worker(store, doorbell, settings, Identity.new("celery"), Slots(settings.slots, _slots))
    worker.start()
    threading.Thread(target=_follow_end, args=(worker,), name="geoswarm-end", daemon=True).start()
    sweeper = Sweeper(worker.runtime, doorbell)
    sweeper.start()
    _process = _Process(store, doorbell, worker, sweeper)


def _follow_end(worker: Worker) -> None:
    """Ask the worker to end when its Celery worker does; what runs has some seconds to finish, or is given back."""
    while not _ending[0] and not worker.stopping.wait(ENDING_SECONDS):
        pass
    worker.stopping.set()


@worker_process_shutdown.connect  # type: ignore[untyped-decorator]
def _close(**_: Any) -> None:
    global _process
    if _process is not None:
        process, _process = _process, None
        process.sweeper.stop()
        process.worker.close()
        process.doorbell.close()
        process.store.close()


@shared_task(name=SERVE_TASK, ignore_result=True)  # type: ignore[untyped-decorator]
def serve(job_id: str) -> None:
    """Answer a ring: there may be work, not necessarily for the job that rang, as others may be more urgent."""
    if _process is None:
        _open()  # the database did not answer when this process began
    if _process is None:
        return
    worker = _process.worker
    until = time.monotonic() + worker.settings.slice_seconds
    try:
        while not worker.stopping.is_set() and (urgent := worker.most_urgent()) is not None:
            if time.monotonic() > until:
                _process.doorbell.ring(urgent.id, kind=urgent.forward_model)  # one message used, one for what is left
                return
            worker.serve(urgent.id)
    except StoreUnavailableError as error:
        log.warning("worker %s: %s", worker.identity.id, error, extra={"job": job_id})
