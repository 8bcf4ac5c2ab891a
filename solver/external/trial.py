"""One detailed trial run of a program: its folder is kept, and what it wrote and what was read is shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.external.errors import OutputError, RunFailedError
from geoswarm.solver.external.outputs.base import OutputReader
from geoswarm.solver.external.reading_time import reading

__all__ = ["SeriesTrial", "TrialRun", "is_watched", "note", "watched"]


@dataclass(frozen=True, slots=True)
class SeriesTrial:
    """What was read of one series.

    Parameters
    ----------
    name, file
        Of the series.
    x, y
        Shape (n,), in the units of the file; empty where it could not be read.
    x_unit, y_unit
        These units.
    lines
        Number and text of the line that each point was read from; 0 where a file has no lines.
    error
        Why it could not be read, in words.
    """

    name: str
    file: str
    x: FloatArray
    y: FloatArray
    x_unit: str
    y_unit: str
    lines: tuple[tuple[int, str], ...]
    error: str | None


@dataclass(frozen=True, slots=True)
class TrialRun:
    """One call of a program.

    Parameters
    ----------
    call
        Program and arguments.
    folder
        Where it ran; kept.
    written
        Files that were written, copied or linked for it.
    made
        Files that are there besides, after the run.
    ended
        How it ended, in words; None: it was not started.
    printed
        The last of what it printed.
    failure
        Why the run failed, in words.
    series
        What was read.
    """

    call: tuple[str, ...]
    folder: Path
    written: tuple[str, ...]
    made: tuple[str, ...]
    ended: str | None
    printed: str
    failure: str | None
    series: tuple[SeriesTrial, ...]


@dataclass
class _Trial:
    runs: list[TrialRun] = field(default_factory=list)


_current: ContextVar[_Trial | None] = ContextVar("trial", default=None)


@contextmanager
def watched() -> Iterator[list[TrialRun]]:
    """Watch the runs of programs in the body, made in this thread; gives the list that they are added to."""
    trial = _Trial()
    token = _current.set(trial)
    try:
        yield trial.runs
    finally:
        _current.reset(token)


def is_watched() -> bool:
    """Whether runs are watched now."""
    return _current.get() is not None


def note(
    call: tuple[str, ...],
    folder: Path,
    written: tuple[str, ...],
    ended: str | None,
    printed: str,
    failure: str | None,
    readers: Mapping[str, OutputReader],
    seconds: float | None,
) -> None:
    """Note a run that has ended, if runs are watched now; ``seconds``: limit of the call [s]."""
    trial = _current.get()
    if trial is None:
        return
    found = (path.relative_to(folder) for path in folder.rglob("*") if not path.is_dir())
    there = [path.as_posix() for path in sorted(found, key=lambda path: (len(path.parts), path))]
    made = tuple(name for name in there if name not in written)
    series = () if ended is None else tuple(_read(name, reader, folder, seconds) for name, reader in readers.items())
    trial.runs.append(TrialRun(call, folder, written, made, ended, printed, failure, series))


def _read(name: str, reader: OutputReader, folder: Path, seconds: float | None) -> SeriesTrial:
    x, y, lines, error = np.empty(0), np.empty(0), list[tuple[int, str]](), None
    try:
        with reading(f"series {name} from {reader.file}", seconds):
            x, y = reader.read(folder)
            lines = reader.traced(folder)
    except (OutputError, RunFailedError) as failed:
        error = str(failed)
    return SeriesTrial(name, reader.file, x, y, reader.x_unit, reader.y_unit, tuple(lines), error)
