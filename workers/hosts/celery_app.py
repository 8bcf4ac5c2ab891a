"""The Celery side: wake-ups over Redis, and worker processes that answer them. Results and retries are not Celery's.

This module imports no numerical library, so that :func:`run_celery_worker` can still limit their threads.
"""

from __future__ import annotations

import logging
import os
import time

import redis
from celery import Celery
from celery.apps.worker import Worker as CeleryWorker
from kombu.exceptions import OperationalError
from redis.backoff import NoBackoff
from redis.retry import Retry

from geoswarm.workers.errors import BrokerUnavailableError, SettingsError, StoreUnavailableError
from geoswarm.workers.hosts.celery_channel import forgive
from geoswarm.workers.settings import Settings, mask_url

__all__ = ["QUEUE", "SERVE_TASK", "CeleryWaker", "create_celery", "queue_name", "run_celery_worker"]

log = logging.getLogger(__name__)

QUEUE = "geoswarm"
SERVE_TASK = "geoswarm.serve"
SILENT_SECONDS = 5.0  # after a failure, until the next try: submissions must not wait for a dead broker again and again


def create_celery(settings: Settings) -> Celery:
    """Return the Celery application for these settings.

    Raises
    ------
    SettingsError
        When there is no broker address.
    """
    if settings.broker_url is None:
        raise SettingsError("broker_url is not set; a Celery worker needs one, for example redis://localhost:6379/0")
    app = Celery("geoswarm", broker=settings.broker_url, set_as_current=False)
    app.conf.update(
        include=["geoswarm.workers.hosts.tasks"],
        task_default_queue=QUEUE,
        task_ignore_result=True,
        task_serializer="json",
        accept_content=["json"],
        task_acks_late=False,  # a message is a hint: lost with its worker, it is woken again
        task_publish_retry=False,
        worker_prefetch_multiplier=1,
        worker_disable_prefetch=True,  # a ring must not wait behind a long evaluation while another worker is idle
        worker_proc_alive_timeout=60.0,  # a pool process may have to wait for the database
        worker_hijack_root_logger=False,
        worker_enable_remote_control=False,
        worker_send_task_events=False,
        broker_connection_retry_on_startup=True,
        broker_connection_timeout=settings.connect_seconds,
        broker_transport_options={
            "socket_connect_timeout": settings.connect_seconds,
            "socket_timeout": None,
            "socket_keepalive": True,
        },
    )
    app.geoswarm_settings = settings
    return app


def queue_name(kind: str) -> str:
    """Return the queue on which workers of this kind of forward model listen; empty: all workers."""
    return f"{QUEUE}.{kind}" if kind else QUEUE


class CeleryWaker:
    """Rings through Redis. While Redis is down it says so once and leaves the rest to the sweep."""

    def __init__(self, settings: Settings) -> None:
        if settings.broker_url is None:
            raise SettingsError("broker_url is not set")
        self.url = settings.broker_url
        self.app = create_celery(settings)
        # Rings are published with a deadline; the blocking reads of a worker's own connection have none.
        self.app.conf.broker_transport_options = {
            **self.app.conf.broker_transport_options,
            "socket_timeout": settings.connect_seconds,
        }
        timeout = settings.connect_seconds
        self._redis = redis.Redis.from_url(
            self.url, socket_connect_timeout=timeout, socket_timeout=timeout, retry=Retry(NoBackoff(), 0)
        )
        self._silent_until = 0.0
        self._down = False

    def check(self) -> None:
        """Ask the broker for an answer.

        Raises
        ------
        BrokerUnavailableError
        """
        try:
            self._redis.ping()
        except (redis.RedisError, OSError, ValueError) as error:
            raise BrokerUnavailableError(f"broker {mask_url(self.url)}: {' '.join(str(error).split())}") from error

    def wake(self, job_id: str, times: int = 1, kind: str = "") -> None:
        """Send ``times`` messages to the queue of a kind of forward model."""
        if time.monotonic() < self._silent_until:
            return
        try:
            self._redis.ping()  # fails at once, where Celery would try again for many seconds
            for _ in range(times):
                self.app.send_task(SERVE_TASK, (job_id,), queue=queue_name(kind), ignore_result=True, retry=False)
        except (OperationalError, redis.RedisError, OSError) as error:
            self._silent_until = time.monotonic() + SILENT_SECONDS
            if not self._down:
                log.warning("broker %s does not take messages: %s", mask_url(self.url), error)
            self._down = True
        else:
            if self._down:
                log.info("broker %s takes messages again", mask_url(self.url))
            self._down = False

    def health(self) -> str:
        """Return ``ok`` or why the broker does not answer."""
        try:
            self.check()
        except BrokerUnavailableError as error:
            return str(error)
        return "ok"

    def close(self) -> None:
        """Close the connections to the broker."""
        self._redis.close()
        self.app.close()


def run_celery_worker(settings: Settings, concurrency: int) -> None:
    """Work with ``concurrency`` processes until SIGTERM or SIGINT: the process behind ``geoswarm worker``.

    Raises
    ------
    StoreUnavailableError, BrokerUnavailableError
        When the database or the broker does not answer at the start.
    SystemExit
        With Celery's exit code when it gave up.
    """
    from geoswarm.solver.system.environment import numerics
    from geoswarm.workers.store import Store
    from geoswarm.workers.store.file import missing_database

    os.environ.update(numerics())
    from geoswarm.solver.forward.registry import kinds

    waker = CeleryWaker(settings)
    waker.check()
    waker.close()
    missing = missing_database(settings)
    if missing is not None:  # a new one would be the wrong one: the service has another
        raise StoreUnavailableError(
            f"there is no database {missing}; give the worker that of its service: --database sqlite:///FILE, or"
            " GEOSWARM_DATABASE_URL (geoswarm serve makes it)"
        )
    Store(settings).close()
    forgive()
    app = create_celery(settings)
    app.set_current()
    worker: CeleryWorker = app.Worker(
        hostname=f"geoswarm-{os.getpid()}@%h",
        concurrency=concurrency,
        queues=[QUEUE, *map(queue_name, settings.kinds or kinds())],
        pool_cls="prefork",
        optimization="fair",
        without_gossip=True,
        without_mingle=True,
        without_heartbeat=True,
        loglevel=logging.WARNING,
        quiet=True,
    )
    worker.start()
    if worker.exitcode:  # Celery has logged an error that it cannot recover from, and returned
        raise SystemExit(worker.exitcode)
