"""The progress bar of searches: on stderr, and only on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

from geoswarm.cli.words.output import note, number, progress_console

__all__ = ["Update", "counted", "progress_bar"]

Update: TypeAlias = Callable[[int, int, float | None, int | None, int | None], None]
"""Called with evaluations so far, number of the last finished generation, best objective so far, and evaluations of a
search that has ended with how many may follow it."""

_BAR, _SHORTEST_NAME = 14, 8
_BESIDE_THE_NAME = 64  # bar, numbers and time


@contextmanager
def counted(what: str) -> Iterator[Callable[[int, int], None]]:
    """Say what is done in the body; on a terminal with "3 of 9", by what the body reports, until it has ended."""
    if not sys.stderr.isatty():
        note(what)
        yield lambda _done, _of: None
        return
    from rich.text import Text

    with progress_console().status(Text(what)) as status:

        def told(done: int, of: int) -> None:
            status.update(Text(f"{what}: {done} of {of}"))

        yield told


@contextmanager
def progress_bar(name: str, planned: int | None) -> Iterator[Update]:
    """Show a bar while the body runs.

    Parameters
    ----------
    name
        Text before the bar.
    planned
        Largest number of evaluations, or None: then the bar only shows that something happens.
    """
    if not sys.stderr.isatty():
        yield lambda *_: None
        return
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    console = progress_console()
    room = max(console.width - _BESIDE_THE_NAME, _SHORTEST_NAME)
    shown = name if len(name) <= room else f"{name[: room - 1]}…"
    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(_BAR),
        TextColumn("{task.fields[counts]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=console, transient=True) as bars:
        task = bars.add_task(shown, total=planned, counts="starting")

        def update(
            evaluations: int, _generation: int, objective: float | None, searched: int | None, following: int | None
        ) -> None:
            if searched is None or following is None:
                total, of = planned, f" of {planned}" if planned else ""
                counts = f"{evaluations}{of} evaluations"
            else:
                total = searched + following
                counts = f"intervals: {evaluations - searched} of {following}"
            text = f"{counts}, best {number(objective)}"
            bars.update(task, total=total, completed=evaluations, counts=text)

        yield update
