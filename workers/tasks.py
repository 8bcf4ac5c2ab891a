"""What runs inside the pool processes of a Celery worker."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from celery import current_app, shared_task
from celery.signals import worker_init, worker_process_init, worker_process_shutdown

from workers.celery_app import SERVE_TASK, CeleryDoorbell
from workers.identity import Identity
from workers.settings import Settings
from workers.store import Store
from workers.sweep import Sweeper
from workers.warm import warm_up
from workers.worker import Worker

__all__ = ["serve"]


@dataclass(slots=True)
class _Process:
    """What belongs to one pool process; made after the fork, as connections must not be shared."""

    store: Store
    doorbell: CeleryDoorbell
    worker: Worker
    sweeper: Sweeper


_process: _Process | None = None


@worker_init.connect  # type: ignore[untyped-decorator]
def _warm_up(**_: Any) -> None:
    warm_up()  # before the fork: every pool process, restarted ones too, begins with the forward models loaded


@worker_process_init.connect  # type: ignore[untyped-decorator]
def _open(**_: Any) -> None:
    global _process
    settings: Settings = current_app.geoswarm_settings
    store = Store(settings)
    doorbell = CeleryDoorbell(settings)
    worker = Worker(store, doorbell, settings, Identity.new("celery"))
    worker.start()
    sweeper = Sweeper(worker.runtime, doorbell)
    sweeper.start()
    _process = _Process(store, doorbell, worker, sweeper)


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
    """Answer a ring: this job may have work."""
    if _process is None:
        _open()  # the database did not answer when this process began
    if _process is not None:
        _process.worker.serve(job_id)
