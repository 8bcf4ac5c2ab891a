"""Compiles kernels before a command calculates, and shows that it does."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from geoswarm.cli.words.output import duration, note, progress_console

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["COMPILING", "all_ready", "note_event", "ready"]

COMPILING = "Compiling the kernels for this machine: once after an installation."
LINE_SECONDS = 10.0


def ready(problem: Problem) -> float:
    """Compile the kernels that a problem needs, unless that was done before; return the time it took [s]."""
    from geoswarm.solver.warm import compile_kernels, missing_kernels

    if not missing_kernels(problem.forward_model):
        return 0.0
    note(COMPILING)
    with _showing() as tell:
        seconds = compile_kernels(problem, tell)
    note(_compiled_in(seconds))
    return seconds


def all_ready() -> None:
    """Compile all kernels, several at once, unless that was done before."""
    from geoswarm.solver.warm import missing_groups, warm

    missing = missing_groups()
    if not missing:
        return
    note(COMPILING)
    began = time.monotonic()
    left = set(missing)
    with _showing() as tell:
        tell(0, len(missing))

        def report(group: str, _seconds: float) -> None:
            left.discard(group)
            tell(len(missing) - len(left), len(missing))

        warm(report)
    note(_compiled_in(time.monotonic() - began))


def note_event(data: Mapping[str, Any]) -> None:
    """Note what an event says of kernels that a worker compiles."""
    compiled = data.get("compiled", 0)  # not in events of 0.1
    if data["seconds"] is not None:
        note(_compiled_in(data["seconds"]))
    else:
        note(_counts(compiled, data["missing"]) if compiled else COMPILING)


def _compiled_in(seconds: float) -> str:
    return f"Kernels compiled in {duration(seconds)}."


def _counts(compiled: int, missing: int) -> str:
    return f"{compiled} of {missing} groups of kernels are compiled."


@contextmanager
def _showing() -> Iterator[Callable[[int, int], None]]:
    """Show a bar on a terminal, else a line now and then; on stderr."""
    if not sys.stderr.isatty():
        yield _Lines().tell
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("groups of kernels"), BarColumn(), TextColumn("{task.fields[counts]}"), TimeElapsedColumn())
    with Progress(*columns, console=progress_console(), transient=True) as bars:
        task = bars.add_task("", total=None, counts="")

        def tell(compiled: int, missing: int) -> None:
            bars.update(task, completed=compiled, total=missing, counts=f"{compiled} of {missing}")

        yield tell


class _Lines:
    """Progress for logs and pipes."""

    def __init__(self) -> None:
        self._told = time.monotonic()

    def tell(self, compiled: int, missing: int) -> None:
        """Write a line when the last one is some time ago."""
        now = time.monotonic()
        if 0 < compiled < missing and now - self._told >= LINE_SECONDS:
            self._told = now
            note(_counts(compiled, missing))
