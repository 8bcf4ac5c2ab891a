"""A forward model that misbehaves in every way that a real one may; installed for tests through its entry point.

``y = slope * x`` for each of the prepared points. What it does on the way is its ``behaviour``, for values of ``slope``
above ``above`` only, and only while the file ``cured`` does not exist.
"""

from __future__ import annotations

import os
import signal
import sys
import time
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Literal, NoReturn

import numpy as np

from geoswarm import DivergedError, FloatArray, ForwardModelSpec, ForwardRun, ParameterInfo, SeriesInfo

Behaviour = Literal[
    "sleep",
    "wait",
    "uneven",
    "gated",
    "compute",
    "for_ever",
    "for_ever_once",
    "fork",
    "eat",
    "exit",
    "leave",
    "crash",
    "diverge",
    "diverge_once",
    "chatter",
]


class MisbehavingSpec(ForwardModelSpec):
    """Misbehaves on request."""

    kind: Literal["misbehaving"] = "misbehaving"
    behaviour: Behaviour = "sleep"
    seconds: float = 0.0
    above: float = 0.0
    cured: str = ""
    notes: str = ""
    gate: str = ""

    def build(self) -> MisbehavingModel:
        """Build it."""
        return MisbehavingModel(self)


class MisbehavingModel:
    """y = slope * x, after some misbehaviour."""

    open_parameters = False
    parameters = (ParameterInfo("slope", "slope", "", "slope"),)
    series = (SeriesInfo("y", "a line", "x", "dimensionless", "y", "dimensionless"),)

    def __init__(self, spec: MisbehavingSpec) -> None:
        self.spec = spec

    def grid(self, series: str) -> FloatArray:  # noqa: ARG002
        return np.arange(3.0)

    def check(self, parameters: Mapping[str, float]) -> str | None:  # noqa: ARG002
        return None

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        def run(values: Mapping[str, float]) -> dict[str, FloatArray]:
            cured = self.spec.cured and Path(self.spec.cured).exists()
            if values["slope"] > self.spec.above and not cured:
                self._misbehave(values)
            return {name: values["slope"] * x for name, x in points.items()}

        return run

    def _misbehave(self, values: Mapping[str, float]) -> None:
        match self.spec.behaviour:
            case "sleep":
                time.sleep(self.spec.seconds)
            case "wait":  # for a file of ``notes`` with the name of its value
                time.sleep(self.spec.seconds)
                while not Path(self.spec.notes, f"{values['slope']:g}").exists():
                    time.sleep(0.002)
            case "uneven":  # a third of the runs take four times as long
                time.sleep(self.spec.seconds * (4.0 if int(1e9 * values["slope"]) % 3 == 0 else 1.0))
            case "gated":
                self._wait_for_the_gate()
            case "compute":
                self._compute()
            case "for_ever":
                self._hang()
            case "for_ever_once":
                with suppress(FileExistsError):  # of several at once the first one only
                    Path(self.spec.cured).touch(exist_ok=False)
                    self._hang()
            case "fork":
                self._run_away()
            case "eat":
                self._note(os.getpid())
                eaten = []
                while True:
                    eaten.append(np.ones(2**20))
                    time.sleep(0.002)
            case "exit":
                sys.exit(3)
            case "leave":
                os._exit(3)
            case "crash":
                os.kill(os.getpid(), signal.SIGSEGV)
            case "diverge":
                os.write(2, b"iteration 17: residual 1e+30\n")
                raise DivergedError("no equilibrium in stage 2")
            case "diverge_once":
                Path(self.spec.cured).touch()
                raise DivergedError("no licence")
            case "chatter":
                while True:
                    os.write(1, b"still iterating\n" * 4096)

    def _wait_for_the_gate(self) -> None:
        """Draw the next number, by lengthening ``notes``, and wait until the file ``gate`` lets so many through."""
        numbers = os.open(self.spec.notes, os.O_WRONLY | os.O_APPEND | os.O_CREAT)
        os.write(numbers, b".")
        number = os.lseek(numbers, 0, os.SEEK_CUR)
        os.close(numbers)
        while number > int(Path(self.spec.gate).read_text()):
            time.sleep(0.01)

    def _compute(self) -> None:
        """Use the processor for ``seconds``, whatever the clock says."""
        until = time.process_time() + self.spec.seconds
        total = 0.0
        while time.process_time() < until:
            total += float(np.sqrt(np.arange(1000.0)).sum())

    def _run_away(self) -> None:
        """Start a process that ignores what it can, one in a session of its own, and one whose parent has left."""
        for signal_number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            signal.signal(signal_number, signal.SIG_IGN)
        for new_session, leave in ((False, False), (True, False), (True, True)):
            if os.fork() == 0:
                if new_session:
                    os.setsid()
                if leave and os.fork() != 0:
                    os._exit(0)
                self._hang()
        self._hang()

    def _hang(self) -> NoReturn:
        self._note(os.getpid())
        while True:
            time.sleep(1.0)

    def _note(self, pid: int) -> None:
        if self.spec.notes:
            with open(self.spec.notes, "a") as notes:  # noqa: PTH123
                notes.write(f"{pid}\n")
