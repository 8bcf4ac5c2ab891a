"""Stand-ins for forward models of other packages, which are read, built and asked in a process apart.

Workers and the process of the HTTP service hold jobs of all users: code that is not ours must not end them. After
:func:`isolate_foreign_models` no such model is imported in this process: :func:`parse_spec` gives a stand-in, whose
questions go to a process (:mod:`.isolated_host`) that may die, hang or run out of memory. Evaluations are made in the
evaluation process (:mod:`.runner`), as for every model.
"""

from __future__ import annotations

import contextlib
import json
import os
import select
import subprocess
import sys
import threading
import time
from collections.abc import Collection, Mapping
from functools import cache, partial
from typing import Any, LiteralString

import numpy as np
from pydantic import ConfigDict, PrivateAttr, ValidationError
from pydantic_core import InitErrorDetails, PydanticCustomError

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import BrokenForwardModelError, Issue, ProblemError
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec, ForwardRun, SeriesInfo
from geoswarm.solver.forward.registry import read_foreign_sections
from geoswarm.solver.parameter_info import ParameterInfo
from geoswarm.solver.runner.evaluator import NoProcessError
from geoswarm.solver.system.environment import clean_environment, numerics
from geoswarm.solver.system.installed import load_after
from geoswarm.solver.system.processes import child_program, kill_session, memory_of

__all__ = ["isolate_foreign_models"]

_BOOTSTRAP = child_program("geoswarm.solver.runner.isolated_host")
_LOOK_SECONDS = 0.1
_MESSAGE: LiteralString = "{message}"


def isolate_foreign_models(memory_mb: float, passed: tuple[str, ...] = (), *, seconds: float = 300.0) -> None:
    """Keep forward models of other packages out of this process from now on.

    Their laws and methods come into it once they were loaded, and models with such laws built, in the process apart
    without ending it.

    Parameters
    ----------
    memory_mb, seconds
        What one question may take; then the process that works on it is killed.
    passed
        Names of environment variables that forward models get in addition to the usual ones.
    """
    host = _Host(memory_mb, passed, seconds)
    read_foreign_sections(partial(_read, host), lambda section: host.ended_by(json.dumps(dict(section)), "build"))
    load_after(cache(lambda group, kind: host.ended_by(group, "load", kind)))


class _EndedError(Exception):
    """The process ended before it had answered; the message says how."""


class _Host:
    """The process, started with the first question and again after its end. Safe to use from several threads."""

    def __init__(self, memory_mb: float, passed: tuple[str, ...], seconds: float) -> None:
        self._memory_mb = memory_mb
        self._passed = passed
        self._seconds = seconds
        self._process: subprocess.Popen[bytes] | None = None
        self._lock = threading.Lock()
        self._number = 0

    def ask(self, section: str, question: str, *given: Any) -> Any:
        """Return the answer to a question about the model of a section.

        Raises
        ------
        ValidationError, ProblemError, RunFailedError
            What the model raised.
        BrokenForwardModelError
            It raised anything else, or ended the process, twice.
        NoProcessError
            There is none to be had: no model is to blame.
        """
        with self._lock:
            try:
                answer = self._asked(section, question, given)
            except _EndedError:  # perhaps not by this question
                try:
                    answer = self._asked(section, question, given)
                except _EndedError as ended:
                    kind = json.loads(section)["kind"]
                    raise BrokenForwardModelError(f"forward model '{kind}' {ended}") from None
        if "found" in answer:
            return answer["found"]
        if "errors" in answer:
            details = [
                InitErrorDetails(
                    type=PydanticCustomError("forward_model", _MESSAGE, {"message": text}), loc=tuple(place), input=None
                )
                for place, text in answer["errors"]
            ]
            raise ValidationError.from_exception_data("forward_model", details)
        if "issues" in answer:
            raise ProblemError([Issue(*issue) for issue in answer["issues"]])
        if "reason" in answer:
            raise RunFailedError(answer["reason"], answer["message"])
        raise BrokenForwardModelError(answer["message"])

    def ended_by(self, section: str, question: str, *given: Any) -> str | None:
        """How a question ends the process, twice; None where it does not, whatever the answer."""
        with self._lock:
            for _ in range(2):
                try:
                    self._asked(section, question, given)
                except _EndedError as error:
                    ended = str(error)
                else:
                    return None
        return ended

    def _asked(self, section: str, question: str, given: tuple[Any, ...]) -> dict[str, Any]:
        self._number += 1
        asked = {"number": self._number, "ask": question, "section": section, "given": given}
        try:
            process = self._started()
            answer: dict[str, Any] = json.loads(self._exchanged(process, json.dumps(asked).encode() + b"\n"))
            if answer.pop("number") != self._number:
                raise ValueError
        except _EndedError:
            raise
        except (OSError, ValueError, LookupError, TypeError, AttributeError):
            self._end()
            raise _EndedError("gave an answer that does not fit the question") from None
        return answer

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self._end()
            try:
                self._process = subprocess.Popen(
                    [sys.executable, "-c", _BOOTSTRAP],
                    stdin=subprocess.PIPE,
                    stdout=subprocess.PIPE,
                    env={**clean_environment(os.environ, self._passed), **numerics()},
                    start_new_session=True,
                )
            except OSError as error:
                raise NoProcessError(f"no process for forward models could be started: {error}") from error
            self._send_all(self._process, json.dumps({"path": sys.path}).encode() + b"\n")
        return self._process

    def _exchanged(self, process: subprocess.Popen[bytes], data: bytes) -> bytes:
        """Send a line and return the answer, while limits are kept."""
        self._send_all(process, data)
        assert process.stdout is not None
        answer = bytearray()
        deadline = time.monotonic() + self._seconds
        while not answer.endswith(b"\n"):
            if select.select([process.stdout], [], [], _LOOK_SECONDS)[0]:
                if not (part := os.read(process.stdout.fileno(), 65536)):
                    raise _EndedError(f"ended its process ({self._end(ending=True)})")
                answer += part
            elif time.monotonic() > deadline:
                self._end()
                raise _EndedError(f"gave no answer within {self._seconds:g} s, and its process was killed")
            elif (used := memory_of(process.pid)) > self._memory_mb:
                self._end()
                raise _EndedError(f"used {used:.0f} MiB, more than {self._memory_mb:g} MiB, and its process was killed")
        return bytes(answer)

    def _send_all(self, process: subprocess.Popen[bytes], data: bytes) -> None:
        assert process.stdin is not None
        os.set_blocking(process.stdin.fileno(), False)
        deadline = time.monotonic() + self._seconds
        view = memoryview(data)
        while view:
            if select.select([], [process.stdin], [], _LOOK_SECONDS)[1]:
                try:
                    view = view[os.write(process.stdin.fileno(), view) :]
                except BrokenPipeError:
                    raise _EndedError(f"ended its process ({self._end(ending=True)})") from None
            elif time.monotonic() > deadline:
                self._end()
                raise _EndedError(f"took no question within {self._seconds:g} s, and its process was killed")

    def _end(self, *, ending: bool = False) -> str:
        """Kill the process and what it has started; return how it had ended; ``ending``: it ends by itself."""
        process, self._process = self._process, None
        if process is None:
            return "not started"
        with contextlib.suppress(subprocess.TimeoutExpired):
            process.wait(1.0 if ending else 0.0)
        code = process.poll()
        process.kill()
        process.wait()
        kill_session(process.pid)
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()
        return "killed" if code is None else f"signal {-code}" if code < 0 else f"exit status {code}"


def _read(host: _Host, section: Mapping[str, Any]) -> IsolatedSpec:
    described = host.ask(json.dumps(dict(section)), "describe")
    spec = IsolatedSpec(**described["section"])
    spec._host, spec._facts = host, described["facts"]
    return spec


class IsolatedSpec(ForwardModelSpec):
    """The section of a forward model of another package, which is asked in a process apart."""

    model_config = ConfigDict(extra="allow")

    _host: _Host = PrivateAttr()
    _facts: dict[str, Any] = PrivateAttr()

    def _ask(self, question: str, *given: Any) -> Any:
        return self._host.ask(self.model_dump_json(), question, *given)

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Those of the model."""
        return tuple(self._facts["assumptions"])

    @property
    def kernels(self) -> frozenset[str]:
        """Those of the model."""
        return frozenset(self._facts["kernels"])

    @property
    def only_here(self) -> bool:
        """As the model says."""
        return bool(self._facts["only_here"])

    @property
    def quick(self) -> bool:
        """As the model says."""
        return bool(self._facts["quick"])

    @property
    def runs_outside(self) -> bool:
        """As the model says."""
        return bool(self._facts["runs_outside"])

    @property
    def runs_programs(self) -> bool:
        """As the model says."""
        return bool(self._facts["runs_programs"])

    def at_once(self, workers: int, machines: int = 1) -> int:
        """Asked."""
        return int(self._ask("at_once", workers, machines))

    def remedy_for(self, series: str) -> str:
        """Asked."""
        return str(self._ask("remedy_for", series))

    def shown(self, text: str) -> str:
        """Asked."""
        return str(self._ask("shown", text))

    def unavailable(self) -> str | None:
        """Asked; a model that cannot answer is not available."""
        try:
            why = self._ask("unavailable")
        except BrokenForwardModelError as error:
            return str(error)
        return None if why is None else str(why)

    def build(self) -> IsolatedModel:
        """The stand-in of the model, which is built in the process apart."""
        described = self._ask("build")
        kind = _TellingModel if described["tells_unused"] else IsolatedModel
        return kind(self._host, self.model_dump_json(), described)


class IsolatedModel(ForwardModel):
    """A forward model of another package, which is asked in a process apart."""

    def __init__(self, host: _Host, section: str, described: Mapping[str, Any]) -> None:
        self._host = host
        self._section = section
        self._parameters = tuple(
            ParameterInfo(**{**info, "typical": None if info["typical"] is None else tuple(info["typical"])})
            for info in described["parameters"]
        )
        self._series = tuple(SeriesInfo(**{**info, "x_names": tuple(info["x_names"])}) for info in described["series"])
        self._open = bool(described["open_parameters"])

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Its parameters."""
        return self._parameters

    @property
    def open_parameters(self) -> bool:
        """Whether it takes others."""
        return self._open

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Its series."""
        return self._series

    def _ask(self, question: str, *given: Any) -> Any:
        return self._host.ask(self._section, question, *given)

    def grid(self, series: str) -> FloatArray:
        """Asked."""
        return np.array(self._ask("grid", series), dtype=np.float64)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """Asked."""
        why = self._ask("check", dict(parameters))
        return None if why is None else str(why)

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Prepare it in the process apart; each run of it is made there."""
        plain = {name: x.tolist() for name, x in points.items()}
        self._ask("prepare", plain)

        def run(values: Mapping[str, float]) -> dict[str, FloatArray]:
            found = self._ask("run", plain, dict(values))
            return {name: np.array(y, dtype=np.float64) for name, y in found.items()}

        return run


class _TellingModel(IsolatedModel):
    """One that knows which parameters change nothing."""

    def unused(self, names: Collection[str]) -> tuple[str, ...]:
        """Asked."""
        return tuple(self._ask("unused", list(names)))
