"""Compiles kernels before a command calculates, and shows that it does."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from geoswarm.cli.words.output import duration, note, progress_console

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["COMPILING", "all_ready", "compiled_in", "ready"]

COMPILING = "Compiling the kernels for this machine: once after an installation, about a minute."
LINE_SECONDS = 10.0


def compiled_in(seconds: float) -> str:
    """Say how long it took."""
    return f"Kernels compiled in {duration(seconds)}."


def ready(problem: Problem) -> float:
    """Compile the kernels that a problem needs, unless that was done before; return the time it took [s]."""
    from geoswarm.solver.warm import compile_kernels, missing_kernels

    if not missing_kernels(problem.forward_model):
        return 0.0
    note(COMPILING)
    with _showing() as tell:
        seconds = compile_kernels(problem, tell)
    note(compiled_in(seconds))
    return seconds


def all_ready() -> None:
    """Compile all kernels, several at once, unless that was done before; a note on stderr says so."""
    from geoswarm.solver.warm import missing_groups, warm

    if not missing_groups():
        return
    note(COMPILING)
    began = time.monotonic()
    warm()
    note(compiled_in(time.monotonic() - began))


@contextmanager
def _showing() -> Iterator[Callable[[int, int], None]]:
    """Show a bar on a terminal, else a line now and then; on stderr."""
    if not sys.stderr.isatty():
        yield _Lines().tell
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (TextColumn("kernels"), BarColumn(), TextColumn("{task.fields[counts]}"), TimeElapsedColumn())
    with Progress(*columns, console=progress_console(), transient=True) as bars:
        task = bars.add_task("", total=None, counts="")

        def tell(compiled: int, planned: int) -> None:
            bars.update(task, completed=compiled, total=planned, counts=f"{compiled} of about {planned}")

        yield tell


class _Lines:
    """Progress for logs and pipes."""

    def __init__(self) -> None:
        self._told = time.monotonic()

    def tell(self, compiled: int, planned: int) -> None:
        """Write a line when the last one is some time ago."""
        now = time.monotonic()
        if now - self._told >= LINE_SECONDS:
            self._told = now
            note(f"{compiled} of about {planned} kernels are compiled.")
