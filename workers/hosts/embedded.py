"""The embedded engine: worker processes on this machine, supervised, with a pipe as waker. No broker."""

from __future__ import annotations

import contextlib
import fcntl
import logging
import os
import struct
import subprocess
import sys
import termios
import threading
import time
from dataclasses import dataclass

from geoswarm.solver.kernels.cache import settle
from geoswarm.solver.runner.output import anonymous_file
from geoswarm.solver.runner.wire import readable
from geoswarm.solver.system.processes import child_program
from geoswarm.workers.child_process import child_environment, hand_over
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.identity import Identity
from geoswarm.workers.operations.sweep import Sweeper
from geoswarm.workers.queries.evaluations import overdue
from geoswarm.workers.queries.workers import forget_worker
from geoswarm.workers.settings import Settings

__all__ = ["PipeWaker", "Supervisor"]

log = logging.getLogger(__name__)

# What it needs comes over its standard input, which then stays open: its end shows that the parent has died.
BOOTSTRAP = child_program("geoswarm.workers.hosts.embedded_worker")
WATCH_SECONDS = 0.05
SHORT_LIFE_SECONDS = 10.0
LONGEST_BACK_OFF_SECONDS = 5.0


class PipeWaker:
    """A pipe in which every byte wakes one worker. A killed process takes at most one wake-up with it.

    Parameters
    ----------
    capacity
        Wake-ups that may wait; with one for every worker, more would only wake them for nothing.
    """

    def __init__(self, capacity: int, ends: tuple[int, int] | None = None) -> None:
        self.capacity = max(capacity, 1)
        self.read_end, self.write_end = os.pipe() if ends is None else ends
        os.set_blocking(self.read_end, False)
        os.set_blocking(self.write_end, False)

    def wake(self, job_id: str, times: int = 1, kind: str = "") -> None:  # noqa: ARG002  the protocol of all wakers
        """Wake up to ``times`` workers; they look themselves what there is to do, whatever the job."""
        with contextlib.suppress(BlockingIOError, BrokenPipeError):
            room = self.capacity - self._waiting()
            if room > 0:
                os.write(self.write_end, b"." * min(times, room))

    def wait(self, seconds: float) -> bool:
        """Wait for a wake-up; False when there was none in time [s]."""
        if not readable(self.read_end, seconds):
            return False
        try:
            return bool(os.read(self.read_end, 1))
        except BlockingIOError:  # another worker was faster
            return False

    def health(self) -> str:
        """Return ``embedded``."""
        return "embedded"

    def close(self) -> None:
        """Close the pipe."""
        os.close(self.read_end)
        os.close(self.write_end)

    def _waiting(self) -> int:
        answer = fcntl.ioctl(self.read_end, termios.FIONREAD, b"\0" * 4)
        return int(struct.unpack("i", answer)[0])


@dataclass(slots=True)
class _Child:
    process: subprocess.Popen[bytes]
    identity: Identity
    started: float


class Supervisor:
    """Keeps ``settings.workers`` worker processes alive, and frees at once what a dead one held."""

    def __init__(self, runtime: Runtime, waker: PipeWaker, sweeper: Sweeper) -> None:
        self.runtime = runtime
        self.waker = waker
        self.sweeper = sweeper
        self.settings: Settings = runtime.settings
        self._stopping = threading.Event()
        self._slots = anonymous_file()
        self._children: list[_Child] = []
        self._thread = threading.Thread(target=self._watch, name="geoswarm-supervisor", daemon=True)

    @property
    def pids(self) -> list[int]:
        """Process numbers of the workers."""
        return [child.process.pid for child in self._children]

    def start(self) -> None:
        """Start the workers and watch them."""
        settle()  # once for all of them
        self._children = [self._spawn() for _ in range(self.settings.workers)]
        self._thread.start()

    def stop(self) -> None:
        """End all workers: those in an evaluation have ``grace_seconds`` to finish it, then they are killed."""
        self._stopping.set()
        if self._thread.is_alive():
            self._thread.join()
        for child in self._children:
            child.process.terminate()
        self.waker.wake("", len(self._children))  # those that wait need not wait to the end
        deadline = time.monotonic() + self.settings.grace_seconds
        for child in self._children:
            try:
                child.process.wait(max(0.0, deadline - time.monotonic()))
            except subprocess.TimeoutExpired:
                child.process.kill()
                child.process.wait()
            self._bury(child, clean=child.process.returncode == 0)
        self._children = []
        os.close(self._slots)

    def _spawn(self) -> _Child:
        ends = (self.waker.read_end, self.waker.write_end)
        slots = self._slots
        process = subprocess.Popen(
            [sys.executable, "-c", BOOTSTRAP],
            stdin=subprocess.PIPE,
            pass_fds=(*ends, slots),
            env=child_environment(),
            process_group=0,  # Ctrl-C in a terminal reaches this process alone, which then ends its workers in order
        )
        identity = Identity.new("embedded", process.pid)
        given = hand_over(self.runtime.store, self.settings, worker_id=identity.id, waker=ends, slots=slots)
        with contextlib.suppress(BrokenPipeError):  # died at once: the watch sees it
            if process.stdin is not None:
                process.stdin.write(given)
                process.stdin.flush()
        return _Child(process, identity, time.monotonic())

    def _watch(self) -> None:
        back_off = 0.0
        while not self._stopping.wait(WATCH_SECONDS):
            for place, child in enumerate(self._children):
                if child.process.poll() is None:
                    continue
                log.warning("worker %s ended with code %d", child.identity.id, child.process.returncode)
                self._bury(child, clean=False)
                lived = time.monotonic() - child.started
                back_off = min(max(2 * back_off, 0.1), LONGEST_BACK_OFF_SECONDS) if lived < SHORT_LIFE_SECONDS else 0.0
                if self._stopping.wait(back_off):
                    return
                self._children[place] = self._spawn()

    def _bury(self, child: _Child, *, clean: bool) -> None:
        """Close what belongs to a dead worker and free what it held."""
        if child.process.stdin is not None:
            with contextlib.suppress(BrokenPipeError):
                child.process.stdin.close()
        if clean:
            return
        lost = [child.identity.id]
        store = self.runtime.store
        try:
            for row in store.read(lambda connection: overdue(connection, lost)):
                self.sweeper.release(row.job_id, row.generation, lost)
            store.write(lambda connection: forget_worker(connection, lost[0]))
        except StoreUnavailableError as error:
            log.warning("the evaluations of worker %s return when its lease expires: %s", lost[0], error)
