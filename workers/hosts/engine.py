"""Opens the engine: a service for the API, with embedded workers or with wake-ups of Celery workers."""

from __future__ import annotations

from contextlib import ExitStack
from types import TracebackType
from typing import Self

from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.hosts.embedded import PipeWaker, Supervisor
from geoswarm.workers.notices.notifier import Notifier
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import Waker

__all__ = ["Engine", "open_engine"]


class Engine:
    """A running engine; :meth:`close` stops everything that it started.

    Raises
    ------
    StoreUnavailableError, BrokerUnavailableError
        When the database or the broker does not answer.
    SettingsError
        When the environment has a mistake about telling of jobs that have ended.
    """

    def __init__(self, settings: Settings) -> None:
        self.settings = settings
        self.supervisor: Supervisor | None = None
        with ExitStack() as started:
            store = Store(settings)
            started.callback(store.close)
            waker = _open_waker(settings)
            started.callback(waker.close)
            runtime = Runtime(store, settings)
            sweeper = Sweeper(runtime, waker)
            if isinstance(waker, PipeWaker):
                self.supervisor = Supervisor(runtime, waker, sweeper)
                started.callback(self.supervisor.stop)
                self.supervisor.start()
            started.callback(sweeper.stop)
            sweeper.start()
            notifier = Notifier(store, settings)
            started.callback(notifier.stop)
            notifier.start()
            self.service = JobService(store, waker, settings)
            started.callback(self.service.close)
            self._started = started.pop_all()

    def close(self) -> None:
        """Stop workers and sweep, and close all connections."""
        self._started.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _open_waker(settings: Settings) -> Waker:
    if settings.broker_url is None:
        return PipeWaker(settings.workers)
    from geoswarm.workers.hosts.celery_app import CeleryWaker

    waker = CeleryWaker(settings)
    try:
        waker.check()
    except BaseException:
        waker.close()
        raise
    return waker


def open_engine(settings: Settings) -> Engine:
    """Open an engine; use it as a context manager, or close it.

    Raises
    ------
    StoreUnavailableError, BrokerUnavailableError
        When the database or the broker does not answer within ``connect_seconds``.
    """
    return Engine(settings)
