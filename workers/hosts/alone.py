"""Processes that run no workers: how they ring, and the one that only sweeps."""

from __future__ import annotations

from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.notices.notifier import Notifier
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.operations.sweep import Sweeper, with_signals
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker, Waker

__all__ = ["remote_waker", "run_sweep"]


def remote_waker(settings: Settings) -> Waker:
    """Return the waker of a process that runs no workers: that of the broker, or a mute one without a broker."""
    if settings.broker_url is None:
        return NoWaker()
    from geoswarm.workers.hosts.celery_app import CeleryWaker

    return CeleryWaker(settings)


def run_sweep(settings: Settings) -> None:
    """Sweep, and send notifications of ended jobs, until SIGINT or SIGTERM: the process behind ``geoswarm sweep``.

    Raises
    ------
    SettingsError
    StoreUnavailableError
        When the database cannot be reached at the start.
    """
    notices = NoticeSettings.from_environment()
    store = Store(settings)
    waker = remote_waker(settings)
    notifier = Notifier(store, settings, notices)
    sweeper = Sweeper(Runtime(store, settings), waker)
    with_signals(sweeper.end)
    notifier.start()
    try:
        sweeper.run()
    finally:
        notifier.stop()
        waker.close()
        store.close()
