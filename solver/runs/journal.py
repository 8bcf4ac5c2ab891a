"""Finished evaluations of an in-process run, on disk: an interrupted run continues from them to the same history.

A journal is a file of records, only ever appended to. A record is its kind (one byte), its length, a checksum and its
content, so a record that was cut off is found and left out. Kinds, in order: the run (problem, seed), the search at its
start, then evaluations as they finish, and after each generation what follows it.
"""

from __future__ import annotations

import errno
import json
import os
import struct
import time
import zlib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.course import Course
from geoswarm.solver.progress.state import Progress, Step
from geoswarm.solver.system.file_locks import try_lock

__all__ = ["Journal", "Keeper", "RunIdentity", "Stored", "read_journal"]

_FRAME = struct.Struct("<cQI")
_RUN, _START, _EVALUATION, _STEP = b"R", b"S", b"E", b"G"
_SECONDS_BETWEEN_SYNCS = 1.0


class Keeper:
    """What an in-process calibration hands over during the run; this one keeps nothing."""

    seconds = 0.0
    """Running time of the part before this one [s]."""

    def start(self, course: Course, slots: int) -> Progress:
        """Return the search at its start."""
        return course.start(slots)

    def recall(self, position: FloatArray) -> Evaluation | None:
        """Return the outcome at natural values, shape (d,), if it is known from an earlier part of this run."""
        del position
        return None

    def finished(self, position: FloatArray, evaluation: Evaluation, seconds: float) -> None:
        """Keep an outcome; ``seconds`` is the running time so far."""

    def known_step(self, generation: int) -> Step | None:
        """Return what followed a generation, if that is known from an earlier part of this run."""
        del generation
        return None

    def closed(self, generation: int, evaluations: Sequence[Evaluation], step: Step, seconds: float) -> None:
        """Keep a whole generation in particle order and what follows it, also one from an earlier part of this run."""


@dataclass(frozen=True, slots=True)
class RunIdentity:
    """What must match to continue a run: the canonical problem without its seed, the seed, and the offer."""

    problem: Mapping[str, Any]
    seed: int
    offer: str | None = None

    def differences(self, other: RunIdentity) -> list[str]:
        """Name the sections that differ."""
        names = [*self.problem, *(name for name in other.problem if name not in self.problem)]
        found = [name for name in names if self.problem.get(name) != other.problem.get(name)]
        found += ["seed"] if self.seed != other.seed else []
        return found + (["--warm-start"] if self.offer != other.offer else [])


@dataclass(frozen=True, slots=True)
class Stored:
    """A journal as read; ``size`` is the length of its whole records [bytes]."""

    run: RunIdentity
    start: Progress | None
    evaluations: Mapping[bytes, Evaluation]
    steps: Mapping[int, Step]
    seconds: float
    size: int


def read_journal(path: Path) -> Stored | None:
    """Read a journal; None when there is none, or not one whole record of it.

    Raises
    ------
    ValueError
        When a whole record cannot be understood.
    """
    run: RunIdentity | None = None
    start: Progress | None = None
    evaluations: dict[bytes, Evaluation] = {}
    steps: dict[int, Step] = {}
    seconds, size = 0.0, 0
    try:
        stream = path.open("rb")
    except FileNotFoundError:
        return None
    with stream:
        for kind, text, arrays, size in _records(stream):  # noqa: B007  the end of the last whole record is needed
            data = json.loads(text)
            if kind == _RUN:
                run = RunIdentity(**data)
            elif kind == _START:
                start = Progress.from_json(data)
            elif kind == _EVALUATION:
                position, evaluation = _evaluation(data, arrays)
                evaluations[position] = evaluation
                seconds = data["at"]
            elif kind == _STEP:
                steps[data["generation"]] = Step(Progress.from_json(data["progress"]), tuple(data["stop_reasons"]))
                seconds = data["at"]
    return None if run is None else Stored(run, start, evaluations, steps, seconds, size)


class Journal(Keeper):
    """The journal of one run.

    Parameters
    ----------
    path
        File; what is stored there goes on when ``stored`` says what that is, and is replaced otherwise.
    run
        What is run.
    stored
        From :func:`read_journal`.

    Raises
    ------
    BlockingIOError
        When another process writes this journal.
    OSError
        When the file cannot be written, here and in every method that keeps something.
    """

    def __init__(self, path: Path, run: RunIdentity, stored: Stored | None = None) -> None:
        self.path = path
        self._stored = stored
        self._file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT | getattr(os, "O_BINARY", 0), 0o666), "r+b", 0)
        self._synced = time.monotonic()
        if not try_lock(self._file):
            self._file.close()
            raise BlockingIOError(errno.EWOULDBLOCK, "another process is running into this folder", str(path))
        try:
            if stored is None:
                self._file.truncate(0)
                self._write(_RUN, {"problem": run.problem, "seed": run.seed, "offer": run.offer})
            else:
                self.seconds = stored.seconds
                self._file.truncate(stored.size)
                self._file.seek(stored.size)
        except BaseException:
            self._file.close()
            raise

    def start(self, course: Course, slots: int) -> Progress:
        """Return the search at its start, as it was then."""
        if self._stored is not None and self._stored.start is not None:
            return self._stored.start
        progress = course.start(slots)
        self._write(_START, progress.to_json())
        return progress

    def recall(self, position: FloatArray) -> Evaluation | None:
        """Return the outcome at a position if it is in the journal."""
        return None if self._stored is None else self._stored.evaluations.get(position.tobytes())

    def finished(self, position: FloatArray, evaluation: Evaluation, seconds: float) -> None:
        """Append an outcome."""
        parts = [position, evaluation.parameters, *evaluation.responses.values()]
        data = {
            "objective": evaluation.objective,
            "misfits": evaluation.misfits,
            "responses": list(evaluation.responses),
            "sizes": [part.size for part in parts],
            "reason": evaluation.reason,
            "message": evaluation.message,
            "seconds": evaluation.seconds,
            "at": seconds,
        }
        self._write(_EVALUATION, data, b"".join(np.ascontiguousarray(p, dtype=np.float64).tobytes() for p in parts))

    def known_step(self, generation: int) -> Step | None:
        """Return what followed a generation if it is in the journal."""
        return None if self._stored is None else self._stored.steps.get(generation)

    def closed(self, generation: int, evaluations: Sequence[Evaluation], step: Step, seconds: float) -> None:
        """Append what follows a generation, unless it is in the journal."""
        del evaluations
        if self.known_step(generation) is not None:
            return
        data = {"generation": generation, "progress": step.progress.to_json(), "stop_reasons": step.stop_reasons}
        self._write(_STEP, data | {"at": seconds})
        if time.monotonic() - self._synced > _SECONDS_BETWEEN_SYNCS:
            os.fsync(self._file.fileno())
            self._synced = time.monotonic()

    def close(self) -> None:
        """Close the file; it stays."""
        self._file.close()

    def _write(self, kind: bytes, data: object, arrays: bytes = b"") -> None:
        text = json.dumps(data).encode()
        content = struct.pack("<Q", len(text)) + text + arrays
        record = _FRAME.pack(kind, len(content), zlib.crc32(content)) + content
        view = memoryview(record)
        while view:  # a full disk takes a part, then says so
            view = view[self._file.write(view) or 0 :]


def _records(stream: IO[bytes]) -> Iterator[tuple[bytes, bytes, bytes, int]]:
    """Give kind, text and arrays of every whole record, and where it ends."""
    while len(head := stream.read(_FRAME.size)) == _FRAME.size:
        kind, length, checksum = _FRAME.unpack(head)
        content = stream.read(length) if length < 2**40 else b""
        if len(content) < length or zlib.crc32(content) != checksum:
            return
        (size,) = struct.unpack_from("<Q", content)
        yield kind, content[8 : 8 + size], content[8 + size :], stream.tell()


def _evaluation(data: Mapping[str, Any], arrays: bytes) -> tuple[bytes, Evaluation]:
    values = np.frombuffer(arrays, dtype=np.float64)
    position, parameters, *responses = (p.copy() for p in np.split(values, np.cumsum(data["sizes"])[:-1]))
    return position.tobytes(), Evaluation(
        parameters,
        data["objective"],
        data["misfits"],
        dict(zip(data["responses"], responses, strict=True)),
        data["reason"],
        data["message"],
        data["seconds"],
    )
