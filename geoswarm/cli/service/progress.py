"""The progress bar of searches: on stderr, and only on a terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TypeAlias

from geoswarm.cli.words.output import number, progress_console

__all__ = ["Update", "progress_bar"]

Update: TypeAlias = Callable[[int, int, float | None, int | None, int | None], None]
"""Called with evaluations so far, number of the last finished generation, best objective so far, and evaluations of a
search that has ended with how many may follow it."""


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

    columns = (
        TextColumn("{task.description}", markup=False),
        BarColumn(),
        TextColumn("{task.fields[counts]}"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=progress_console(), transient=True) as bars:
        task = bars.add_task(name, total=planned, counts="starting")

        def update(
            evaluations: int, generation: int, objective: float | None, searched: int | None, following: int | None
        ) -> None:
            if searched is None or following is None:
                total, of = planned, f" of at most {planned}" if planned else ""
                counts = f"{evaluations}{of} evaluations, generation {generation}"
            else:
                total, done = searched + following, evaluations - searched
                counts = f"search ended after {searched} evaluations, intervals: {done} of at most {following}"
            text = f"{counts}, best objective {number(objective)}"
            bars.update(task, total=total, completed=evaluations, counts=text)

        yield update
