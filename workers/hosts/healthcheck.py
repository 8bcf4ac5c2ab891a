"""``python -m geoswarm.workers.hosts.healthcheck [--worker]``, for supervisors of containers: exit code 0 or 1.

Database and broker must answer; with ``--worker`` also a worker process of this machine must have been heard of within
its lease.
"""

from __future__ import annotations

import logging
import socket
import sys
from collections.abc import Sequence

from geoswarm.workers.errors import WorkersError
from geoswarm.workers.queries.workers import list_workers
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.file import missing_database

__all__ = ["main", "what_is_wrong"]

log = logging.getLogger("geoswarm.healthcheck")


def what_is_wrong(settings: Settings, *, worker: bool) -> str | None:
    """Return what keeps this machine's part of the engine from working; None: nothing."""
    missing = missing_database(settings)
    if missing is not None:
        return f"there is no database {missing}"
    try:
        store = Store(settings)
        try:
            rows = store.read(lambda connection: list_workers(connection, settings.lease_seconds))
        finally:
            store.close()
        if settings.broker_url is not None:
            from geoswarm.workers.hosts.celery_app import CeleryWaker

            waker = CeleryWaker(settings)
            try:
                waker.check()
            finally:
                waker.close()
    except WorkersError as error:
        return str(error)
    if worker and not any(row.host == socket.gethostname() and not row.lost for row in rows):
        return "no worker process on this machine has sent a heartbeat within its lease"
    return None


def main(arguments: Sequence[str]) -> int:
    """Tell on stderr what is wrong and return the exit code."""
    try:
        wrong = what_is_wrong(Settings.from_environment(), worker="--worker" in arguments)
    except WorkersError as error:
        wrong = str(error)
    if wrong is not None:
        log.error(wrong)
    return 0 if wrong is None else 1


if __name__ == "__main__":
    logging.basicConfig(format="%(message)s")
    sys.exit(main(sys.argv[1:]))
