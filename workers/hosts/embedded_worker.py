"""The main program of a worker process of the embedded engine."""

from __future__ import annotations

import logging
import os
import socket
import sys
import threading
from collections.abc import Mapping
from typing import Any

from geoswarm.solver.runner.isolated import isolate_foreign_models
from geoswarm.workers.child_process import open_store, take_over
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.execution.slots import Slots
from geoswarm.workers.execution.worker import Worker
from geoswarm.workers.hosts.embedded import PipeWaker
from geoswarm.workers.identity import Identity, this_machine
from geoswarm.workers.operations.sweep import Sweeper, with_signals
from geoswarm.workers.settings import Settings
from geoswarm.workers.tracing import start_tracing

__all__ = ["main"]

log = logging.getLogger(__name__)


def main(given: Mapping[str, Any]) -> None:
    """Work until the parent asks for the end, or dies."""
    settings = take_over(given)
    start_tracing("worker")
    if settings.isolate:
        isolate_foreign_models(settings.build_memory_mb, settings.passed_environment)
    read_end, write_end = given["waker"]
    waker = PipeWaker(settings.workers, (read_end, write_end))
    identity = Identity(given["worker_id"], socket.gethostname(), os.getpid(), this_machine(), "embedded")
    try:
        store = open_store(given, settings)
        worker = Worker(store, waker, settings, identity, Slots(settings.slots, given["slots"]))
        worker.start()
    except StoreUnavailableError as error:
        log.warning("worker %s cannot start: %s", identity.id, error)
        sys.exit(1)
    with_signals(worker.stopping.set)
    threading.Thread(target=_follow_parent, args=(worker, settings.grace_seconds), daemon=True).start()
    sweeper = Sweeper(worker.runtime, waker)
    sweeper.start()
    _work(worker, waker, settings)
    sweeper.stop()
    worker.close()
    store.close()


def _work(worker: Worker, waker: PipeWaker, settings: Settings) -> None:
    wait = settings.poll_seconds
    while not worker.stopping.is_set():
        try:
            turn = worker.take_turn()
        except StoreUnavailableError as error:
            log.warning("worker %s: %s", worker.identity.id, error)
            worker.stopping.wait(wait)
            continue
        if turn is None:
            waker.wait(wait)
        else:
            worker.serve(*turn)


def _follow_parent(worker: Worker, grace: float) -> None:
    """Wait for the end of standard input, which comes when the parent dies, and then do not outlive it for long."""
    while os.read(sys.stdin.fileno(), 1):
        pass
    worker.stopping.set()
    threading.Event().wait(grace)
    os._exit(1)
