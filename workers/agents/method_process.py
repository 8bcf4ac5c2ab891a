"""Lets search methods of other packages act for the service in a process apart: a method may end that one, or hang."""

from __future__ import annotations

import logging
import subprocess
import sys
import threading
from collections.abc import Mapping
from typing import Any

from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runner.evaluator import BuildError
from geoswarm.solver.system.processes import child_program, die_with_parent, go_first_without_memory, kill_session
from geoswarm.workers.agents.prepared import Prepared, PreparedJobs
from geoswarm.workers.child_process import child_environment, hand_over, open_store, take_over
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Submission
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store

__all__ = ["MethodProcess", "begin", "main"]

log = logging.getLogger(__name__)

BOOTSTRAP = child_program("geoswarm.workers.agents.method_process")
TRIES = 2
LIMIT_SECONDS = 300.0
NO_STORE, ACTED = 75, 76  # exit codes: a method itself may end the process with 0


def begin(runtime: Runtime, prepared: Prepared, slots: int) -> None:
    """Begin a queued job with its generation 0."""
    try:
        progress: Progress | InfeasibleSpaceError = prepared.course.start(slots)
    except InfeasibleSpaceError as error:
        progress = error
    runtime.start(prepared.id, progress)


class MethodProcess:
    """Starts jobs and closes generations, one at a time; safe to use from several threads."""

    def __init__(self, store: Store, settings: Settings) -> None:
        self._store = store
        self._settings = settings
        self._lock = threading.Lock()
        self._process: subprocess.Popen[bytes] | None = None
        self._closed = False

    def go_on(self, prepared: Prepared, slots: int) -> bool:
        """Let the method of a job act; False: not now, as it or that of another job acts.

        Raises
        ------
        BuildError
            It has ended the process, twice.
        """
        if self._closed or not self._lock.acquire(blocking=False):
            return False
        try:
            given = hand_over(self._store, self._settings, job=prepared.id, slots=slots)
            for _ in range(TRIES):  # once perhaps not by the method
                ended = self._run(given)
                if ended is None or self._closed:
                    return True
            kind = prepared.course.problem.method.kind
            raise BuildError(f"method '{kind}' {ended}; mend the package that it is from")
        finally:
            self._lock.release()

    def close(self) -> None:
        """End the process, and the waiting for it."""
        self._closed = True
        if self._process is not None:
            kill_session(self._process.pid)

    def _run(self, given: bytes) -> str | None:
        try:
            process = self._process = subprocess.Popen(
                [sys.executable, "-c", BOOTSTRAP],
                stdin=subprocess.PIPE,
                env=child_environment(),
                start_new_session=True,
            )
        except OSError as error:
            log.warning("no process for a method could be started: %s", error)
            return None
        try:
            process.communicate(given, LIMIT_SECONDS)
        except subprocess.TimeoutExpired:
            return f"did not return within {LIMIT_SECONDS:g} s, and its process was killed"
        finally:
            kill_session(process.pid)
            code = process.wait()
        if code in (ACTED, NO_STORE):
            return None
        return f"ended its process ({f'signal {-code}' if code < 0 else f'exit status {code}'})"


def main(given: Mapping[str, Any]) -> None:
    """Let the method of one job act."""
    die_with_parent()
    go_first_without_memory()
    settings = take_over(given)
    try:
        store = open_store(given, settings)
        runtime = Runtime(store, settings)
        try:
            prepared = PreparedJobs(store, settings).get(given["job"])
            if prepared is not None:
                answer = runtime.exchange(prepared.id, "", prepared.course, Submission(), live_workers=1, want=False)
                if answer.queued:
                    begin(runtime, prepared, given["slots"])
        except StoreUnavailableError:
            raise
        except Exception as error:
            log.exception("job %s cannot be worked on", given["job"])
            runtime.give_up(given["job"], f"{type(error).__name__}: {error}")
    except StoreUnavailableError as error:
        log.warning("%s", error)
        sys.exit(NO_STORE)
    sys.exit(ACTED)
