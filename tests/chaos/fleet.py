"""A whole installation as processes of this test: workers, API and sweep, restarted whenever they end.

Every process carries a mark in its environment, which its children inherit. So all of them are found, those included
whose parents are gone, and no process of anybody else is ever touched.
"""

from __future__ import annotations

import contextlib
import os
import secrets
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from types import TracebackType
from typing import Self

from tests.servers import find_program

__all__ = ["Fleet", "send"]

MARK = "GEOSWARM_TEST_FLEET"
RESTART_SECONDS = 0.5  # before the next start of what ended by itself, as a supervisor waits
END_SECONDS = 60.0


@dataclass(slots=True)
class _Member:
    arguments: Sequence[str]
    environment: Mapping[str, str]
    process: subprocess.Popen[bytes] | None = None
    killed: bool = False
    start_at: float = 0.0


class Fleet:
    """Runs ``geoswarm`` commands and keeps them running.

    Parameters
    ----------
    commands
        Arguments of ``geoswarm`` by a name for the process; names of workers begin with ``worker``.
    folder
        Where each writes its log.
    environment, own
        Variables of all, and by name those of single ones.
    """

    def __init__(
        self,
        commands: Mapping[str, Sequence[str]],
        folder: Path,
        environment: Mapping[str, str],
        own: Mapping[str, Mapping[str, str]] | None = None,
    ) -> None:
        of = own or {}
        self.members = {name: _Member(arguments, of.get(name, {})) for name, arguments in commands.items()}
        self.ended: Counter[str] = Counter()  # by themselves, with a code other than 0
        self.restarts = 0
        self._folder = folder
        self._mark = secrets.token_hex(8)
        self._environment = {**os.environ, **environment, MARK: self._mark}

    def __enter__(self) -> Self:
        self.supervise()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Whatever is left after an error is killed; see :meth:`stop` for the orderly end."""
        for member in self.members.values():
            if member.process is not None and member.process.poll() is None:
                member.process.kill()
                member.process.wait()
        for pid in self.processes():
            send(pid, signal.SIGKILL)

    def supervise(self) -> None:
        """Start what does not run."""
        now = time.monotonic()
        for name, member in self.members.items():
            process = member.process
            if process is not None and process.poll() is not None:
                if not member.killed:
                    self.ended[f"{name} with code {process.returncode}"] += 1
                    member.start_at = now + RESTART_SECONDS
                self.restarts += 1
                member.process = process = None
            if process is None and now >= member.start_at:
                member.killed = False
                with (self._folder / f"{name}.log").open("ab") as log:
                    # with the test run killed, the fleet goes too
                    follow = (str(find_program("setpriv")), "--pdeathsig", "KILL")
                    member.process = subprocess.Popen(
                        [*follow, sys.executable, "-m", "geoswarm", *member.arguments],
                        stdin=subprocess.DEVNULL,
                        stdout=log,
                        stderr=subprocess.STDOUT,
                        env={**self._environment, **member.environment},
                    )

    def kill(self, name: str) -> bool:
        """Kill a member at once; False when it does not run now."""
        member = self.members[name]
        if member.process is None or member.process.poll() is not None:
            return False
        member.killed = True
        member.process.kill()
        member.process.wait()
        return True

    def stop(self) -> dict[str, int]:
        """Ask all to end, and return their exit codes; one that does not is an error."""
        running = {name: m.process for name, m in self.members.items() if m.process is not None}
        for process in running.values():
            process.terminate()
        deadline = time.monotonic() + END_SECONDS
        return {name: process.wait(max(deadline - time.monotonic(), 0.1)) for name, process in running.items()}

    def logs(self, lines: int = 15) -> str:
        """Return the end of every log."""
        tails = []
        for log in sorted(self._folder.glob("*.log")):
            end = log.read_text(errors="replace").splitlines()[-lines:]
            tails.append("\n".join([f"--- {log.name}", *end]))
        return "\n".join(tails)

    def processes(self) -> list[int]:
        """Return all living processes that carry the mark."""
        mark = f"{MARK}={self._mark}\0".encode()
        return [pid for pid in _pids() if mark in _read(pid, "environ") + b"\0"]

    def below(self) -> dict[str, list[int]]:
        """Return the processes that workers have made, by what they are: pool, fork server, evaluation."""
        parents = {pid: _parent(pid) for pid in self.processes()}
        mains = {m.process.pid for name, m in self.members.items() if name.startswith("worker") and m.process}
        fork_servers = [
            pid
            for pid in parents
            if b"geoswarm.solver.runner.fork_server" in _read(pid, "cmdline") and parents[pid] not in mains
        ]
        heads = [pid for pid in fork_servers if parents[pid] not in fork_servers]
        pool = [pid for pid, parent in parents.items() if parent in mains and pid not in fork_servers]
        evaluations = [pid for pid in fork_servers if parents[pid] in heads]
        return {"pool": pool, "fork server": heads, "evaluation": evaluations}


def send(pid: int, number: signal.Signals) -> bool:
    """Send a signal to one process; False when it is gone already."""
    with contextlib.suppress(ProcessLookupError):
        os.kill(pid, number)
        return True
    return False


def _pids() -> list[int]:
    return [int(entry.name) for entry in Path("/proc").iterdir() if entry.name.isdigit()]


def _read(pid: int, name: str) -> bytes:
    try:
        return Path(f"/proc/{pid}/{name}").read_bytes()
    except OSError:  # it has ended meanwhile
        return b""


def _parent(pid: int) -> int:
    fields = _read(pid, "stat").rpartition(b")")[2].split()
    return int(fields[1]) if fields else 0
