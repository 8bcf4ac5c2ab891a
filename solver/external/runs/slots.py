"""Slots: how many runs of a program at once on this machine, whatever processes they belong to."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

from geoswarm.solver.system.activity import waiting
from geoswarm.solver.system.file_locks import try_lock

__all__ = ["slot"]

_FIRST_PAUSE, _LONGEST_PAUSE = 0.002, 0.25


@contextmanager
def slot(folder: Path, count: int | None) -> Iterator[int]:
    """Hold the first free slot, numbered from 0; wait while all are taken, which does not count as run time.

    Parameters
    ----------
    folder
        Of the locks: one for all processes that share the slots.
    count
        Slots that there are; None: as many as are wanted.
    """
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    with ExitStack() as held:
        with waiting():
            number = _taken(folder, count, held)
        yield number


def _taken(folder: Path, count: int | None, held: ExitStack) -> int:
    """Take the first free slot, as long as something is held."""
    pause = _FIRST_PAUSE
    while True:
        number = 0
        while count is None or number < count:
            with ExitStack() as one:
                file = one.enter_context((folder / f"slot-{number}").open("wb"))
                if try_lock(file):
                    held.push(one.pop_all())
                    return number
            number += 1
        time.sleep(pause)
        pause = min(2.0 * pause, _LONGEST_PAUSE)
