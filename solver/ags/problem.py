"""The folder of a problem that tests of a file make: its text with what was assumed, and the files beside it."""

from __future__ import annotations

import textwrap
from dataclasses import dataclass
from pathlib import Path

from geoswarm.solver.ags.contents import Contents
from geoswarm.solver.ags.document import made_of
from geoswarm.solver.ags.tables import AgsError
from geoswarm.solver.ags.wishes import Wishes
from geoswarm.solver.external.copies import Copies
from geoswarm.solver.problem.text.writing import problem_yaml

__all__ = ["PROBLEM", "Imported", "imported"]

PROBLEM = "problem.yaml"
_WIDTH = 118


@dataclass(frozen=True, slots=True)
class Imported:
    """What is to be written, and what is to be told; ``problem`` says whether there is one."""

    copies: Copies
    notes: tuple[str, ...]
    problem: bool


def imported(contents: Contents, folder: Path, wishes: Wishes) -> Imported:
    """Make a problem of some tests, and a CSV file of each instrument's readings; nothing is written yet.

    Parameters
    ----------
    folder
        Where they will lie.

    Raises
    ------
    AgsError
        Nothing can be made of them.
    FileInTheWayError
        Something would be overwritten.
    """
    made = made_of(contents, wishes)
    copies = Copies(folder)
    for name, content in made.instruments.items():
        copies.add_as(f"{name}.csv", content, 0o644)
    if made.document is None:
        return Imported(copies, made.notes, False)
    if (folder / PROBLEM).exists():
        raise AgsError(f"{folder / PROBLEM} exists and is never overwritten; give another --output DIR")
    for part in made.parts:
        for one in part.readings:
            copies.add_as(f"{one.name}.csv", one.csv, 0o644)
    head = [
        f"# Made of {contents.file} (AGS 4): {', '.join(id for id, _ in (*contents.compression, *contents.shear))}",
        "# Assumed, or to be known:",
    ]
    remarks = [line for note in made.notes for line in _remark(note)]
    copies.add_as(PROBLEM, ("\n".join([*head, *remarks]) + "\n" + problem_yaml(made.document)).encode(), 0o644)
    return Imported(copies, made.notes, True)


def _remark(text: str) -> list[str]:
    return textwrap.wrap(
        text,
        _WIDTH,
        initial_indent="# - ",
        subsequent_indent="#   ",
        break_long_words=False,
        break_on_hyphens=False,
    )
