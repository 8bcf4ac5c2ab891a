"""Processes that run no workers: how they ring, and the one that only sweeps."""

from __future__ import annotations

from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.doorbell import Doorbell, MuteDoorbell
from geoswarm.workers.notices.notifier import Notifier
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.operations.sweep import Sweeper, with_signals
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

__all__ = ["remote_doorbell", "run_sweep"]


def remote_doorbell(settings: Settings) -> Doorbell:
    """Return the doorbell of a process that runs no workers: that of the broker, or a mute one without a broker."""
    if settings.broker_url is None:
        return MuteDoorbell()
    from geoswarm.workers.hosts.celery_app import CeleryDoorbell

    return CeleryDoorbell(settings)


def run_sweep(settings: Settings) -> None:
    """Sweep, and tell of jobs that have ended, until SIGINT or SIGTERM: the process behind ``geoswarm sweep``.

    Raises
    ------
    SettingsError
    StoreUnavailableError
        When the database cannot be reached at the start.
    """
    notices = NoticeSettings.from_environment()
    store = Store(settings)
    doorbell = remote_doorbell(settings)
    notifier = Notifier(store, settings, notices)
    sweeper = Sweeper(Runtime(store, settings), doorbell)
    with_signals(sweeper.end)
    notifier.start()
    try:
        sweeper.run()
    finally:
        notifier.stop()
        doorbell.close()
        store.close()
