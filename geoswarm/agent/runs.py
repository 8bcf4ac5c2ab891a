"""Makes runs in a process of its own, and kills it with all that it has started when a run exceeds a limit."""

from __future__ import annotations

import contextlib
import json
import logging
import queue
import signal
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geoswarm.agent.trees.tree import Tree, start_tree

__all__ = ["RunOutcome", "RunProcess", "Unwanted"]

log = logging.getLogger(__name__)

POLL_SECONDS = 0.05
MEMORY_SECONDS = 0.1
LOAD_SECONDS = 1800.0  # kernels may have to be compiled
SILENT_SECONDS = 30.0
TRIES = 3  # of a process that ends between two runs
LOG_TAIL = 8192


@dataclass(frozen=True, slots=True)
class RunOutcome:
    """What came of the run of this number; ``began``, ``ended``: monotonic time [s]."""

    index: int
    responses: Mapping[str, Sequence[float]]
    reason: str | None
    message: str | None
    log: str | None
    seconds: float
    began: float
    ended: float


class Unwanted(Exception):  # noqa: N818  no error
    """What ran was killed on request; ``index``: the run that was begun, None: none was."""

    def __init__(self, index: int | None) -> None:
        self.index = index
        super().__init__(index)


class RunProcess:
    """The process in which one slot makes its runs; it serves one thread, and stays for further runs of its job.

    Parameters
    ----------
    arguments
        What starts it, given the file for what forward models print.
    environment
        Of it, and of what it starts.
    """

    def __init__(self, arguments: Callable[[Path], Sequence[str]], environment: Mapping[str, str]) -> None:
        self._arguments, self._environment = arguments, environment
        self._log: Path | None = None
        self._tree: Tree | None = None
        self._answers: queue.SimpleQueue[dict[str, Any] | None] = queue.SimpleQueue()
        self._frame: str | None = None
        self._runs = 0
        self._idle_memory = 0.0
        self._memory_at = 0.0

    def run(
        self, frame: str, shared: Mapping[str, Any], runs: Sequence[Mapping[str, float]], unwanted: Callable[[], bool]
    ) -> Iterator[RunOutcome]:
        """Make runs, given by the values of all parameters, in order, and give what comes of each.

        Parameters
        ----------
        frame, shared
            Name of what they share, and that itself.
        unwanted
            Whether what runs is to be killed.

        Raises
        ------
        Unwanted
            It was killed; those before it were given.
        OSError
            The system has no process to spare.
        """
        limits = shared["limits"]
        done, idle_ends = 0, 0
        while done < len(runs):
            self._ready(frame, shared, unwanted)
            try:
                for outcome in self._batch(runs, done, limits, unwanted):
                    yield outcome
                    done = outcome.index + 1
            except GeneratorExit:
                self._kill()  # the caller has lost interest; whatever is under way must not answer the next request
                raise
            except _SpoiledError:
                continue  # in a fresh process: what was used may be what runs before it have left
            except _EndedError as ended:
                if ended.began is None and (idle_ends := idle_ends + 1) < TRIES:
                    continue  # killed from outside between two runs: none is to blame
                now = time.monotonic()
                began = now if ended.began is None else ended.began
                yield RunOutcome(done, {}, ended.reason, ended.message, ended.log, now - began, began, now)
                done += 1

    def close(self) -> None:
        """End the process and all that it has started."""
        self._kill()
        log_file, self._log = self._log, None
        if log_file is not None:
            with contextlib.suppress(OSError):
                log_file.unlink(missing_ok=True)
                log_file.parent.rmdir()

    def _ready(self, frame: str, shared: Mapping[str, Any], unwanted: Callable[[], bool]) -> None:
        """Have a process that has loaded what the runs share."""
        if self._tree is not None and self._frame == frame:
            return
        self._kill()
        for attempt in range(TRIES):
            self._start()
            self._ask({"op": "load", "shared": shared})
            deadline = time.monotonic() + LOAD_SECONDS
            answer: dict[str, Any] | None = {}
            while answer is not None and "loaded" not in answer:
                if unwanted():
                    self._kill()
                    raise Unwanted(None)
                if time.monotonic() > deadline:
                    break
                with contextlib.suppress(queue.Empty):
                    answer = self._answers.get(timeout=POLL_SECONDS)
            if answer and "loaded" in answer:
                break
            code = self._kill(ending=answer is None)
            log.warning("the process for runs ended while it got ready (%s), try %d", _how_it_ended(code), attempt + 1)
        else:
            raise OSError(f"no process for runs could be made ready, tried {TRIES} times")
        self._frame = frame
        self._idle_memory = self._memory()

    def _start(self) -> None:
        if self._log is None:
            self._log = Path(tempfile.mkdtemp(prefix="geoswarm-agent-")) / "output.txt"
        self._log.unlink(missing_ok=True)
        self._log.touch(0o600)
        tree = self._tree = start_tree(self._arguments(self._log), self._environment)
        answers = self._answers = queue.SimpleQueue()
        self._runs = 0

        def read() -> None:
            with contextlib.suppress(OSError, ValueError), tree.answers:  # what is not an answer of ours ends it
                for line in tree.answers:
                    answers.put(json.loads(line))
            answers.put(None)

        threading.Thread(target=read, name="answers of runs", daemon=True).start()

    def _ask(self, request: Mapping[str, Any]) -> None:
        assert self._tree is not None
        data = memoryview(json.dumps(request, separators=(",", ":")).encode() + b"\n")
        with contextlib.suppress(OSError):  # it has ended: the answers say so
            while data:
                data = data[self._tree.requests.write(data) :]
            self._tree.requests.flush()

    def _batch(
        self,
        runs: Sequence[Mapping[str, float]],
        first: int,
        limits: Mapping[str, Any],
        unwanted: Callable[[], bool],
    ) -> Iterator[RunOutcome]:
        self._ask({"op": "run", "runs": [(index, dict(runs[index])) for index in range(first, len(runs))]})
        state = _State()
        while True:
            try:
                answer = self._answers.get(timeout=POLL_SECONDS)
            except queue.Empty:
                answer = {}
            if answer is None:
                reason = _how_it_ended(self._kill(ending=True))
                raise _EndedError("worker_lost", reason, state.began, self._tail())
            now = time.monotonic()
            state.note(answer, now)
            if "done" in answer:
                self._runs += 1
                began = now if state.began is None else state.began
                state.began = None
                told = {name: answer[name] for name in ("responses", "reason", "message", "log", "seconds")}
                yield RunOutcome(index=answer["done"], began=began, ended=now, **told)
            if "over" in answer:
                if answer["renew"]:
                    self._kill()
                return
            if not answer:
                self._keep(limits, state, now, unwanted)
            elif unwanted() and state.began is None:
                self._kill()
                raise Unwanted(None)

    def _keep(self, limits: Mapping[str, Any], state: _State, now: float, unwanted: Callable[[], bool]) -> None:
        """Look whether what runs is wanted, and within its limits."""
        if unwanted():
            self._kill()
            raise Unwanted(state.index if state.began is not None else None)
        seconds, memory = limits["seconds"], limits["memory_mb"]
        if state.began is not None and seconds is not None and state.running(now) > seconds:
            self._kill()
            doing = f" while {state.doing}" if state.doing else ""
            message = f"ran for longer than {seconds:g} s ({limits['of_time']}) and was killed{doing}"
            raise _EndedError("timeout", message, state.began, self._tail())
        if state.began is None and now - state.heard > SILENT_SECONDS:
            self._kill()
            message = f"the evaluation process was silent for {SILENT_SECONDS:g} s with an answer due, and was killed"
            raise _EndedError("worker_lost", message, None, self._tail())
        if memory is not None and state.began is not None and now - self._memory_at > MEMORY_SECONDS:
            self._memory_at = now
            used = self._memory() - self._idle_memory
            if used > memory:
                spoiled = self._runs > 0
                self._kill()
                if spoiled:
                    raise _SpoiledError
                message = f"used {used:.0f} MiB, more than {memory:g} MiB (limits.memory_mb), and was killed"
                raise _EndedError("killed_memory", message, state.began, self._tail())

    def _memory(self) -> float:
        return 0.0 if self._tree is None else self._tree.memory_mb()

    def _kill(self, *, ending: bool = False) -> int | None:
        tree, self._tree, self._frame = self._tree, None, None
        return None if tree is None else tree.kill(ending=ending)

    def _tail(self) -> str | None:
        if self._log is None:
            return None
        try:
            with self._log.open("rb") as file:
                file.seek(max(self._log.stat().st_size - LOG_TAIL, 0))
                return file.read(LOG_TAIL).decode("utf-8", "replace").replace("\x00", "") or None
        except OSError:
            return None


class _State:
    """What the process is at."""

    def __init__(self) -> None:
        self.index = 0
        self.began: float | None = None
        self.doing = ""
        self.heard = time.monotonic()
        self._waited = 0.0
        self._waits_since: float | None = None

    def note(self, answer: Mapping[str, Any], now: float) -> None:
        """Take in what it reports."""
        if answer:
            self.heard = now
        if "begins" in answer:
            self.index, self.began = answer["begins"], now
            self._waited, self._waits_since, self.doing = 0.0, None, ""
        elif "waits" in answer:
            self._waits_since = now
        elif "waited" in answer:
            self._waited += answer["waited"]
            self._waits_since = None
        elif "does" in answer:
            self.doing = answer["does"]

    def running(self, now: float) -> float:
        """How long the run has taken without what it waited [s]."""
        waits = 0.0 if self._waits_since is None else now - self._waits_since
        return 0.0 if self.began is None else now - self.began - self._waited - waits


class _SpoiledError(Exception):
    """The process was killed for memory that an earlier run may have left: the run is begun again in a fresh one."""


class _EndedError(Exception):
    """The process has ended, by itself or not; ``began``: when the run under way did, None: none was."""

    def __init__(self, reason: str, message: str, began: float | None, output: str | None) -> None:
        self.reason, self.message, self.began, self.log = reason, message, began, output
        super().__init__(message)


def _how_it_ended(code: int | None) -> str:
    if code is None:
        return "the evaluation process was lost"
    if code < 0 and sys.platform != "win32":
        try:
            name = signal.Signals(-code).name
        except ValueError:
            name = f"signal {-code}"
        return f"the evaluation process was ended by {name}"
    return f"the evaluation process ended by itself with exit code {code}"
