"""All cases in the order of the manual, by chapter."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from geoswarm.verification.case import Case
from geoswarm.verification.cases import (
    cam_clay,
    consolidation,
    creep,
    finite_elements,
    ground,
    hardening_soil,
    hypoplasticity,
    inference,
    limit_loads,
    strength,
)

__all__ = ["CHAPTERS", "Chapter", "UnknownCaseError", "find_cases"]


@dataclass(frozen=True, slots=True)
class Chapter:
    """Cases that are a page of the manual, ``name`` for the command line and its file."""

    name: str
    title: str
    cases: tuple[Case, ...]


CHAPTERS: tuple[Chapter, ...] = (
    Chapter("creep", "Soft soil creep", creep.CASES),
    Chapter("cam-clay", "Modified Cam clay and soft soil", cam_clay.CASES),
    Chapter("hardening-soil", "Hardening soil and small-strain stiffness", hardening_soil.CASES),
    Chapter("hypoplasticity", "Hypoplasticity of sand and clay", hypoplasticity.CASES),
    Chapter("strength", "Strength", strength.CASES),
    Chapter("consolidation", "Consolidation of specimens", consolidation.CASES),
    Chapter("ground", "Layered ground", ground.CASES),
    Chapter("finite-elements", "Finite elements", finite_elements.CASES),
    Chapter("limit-loads", "Limit loads by finite elements", limit_loads.CASES),
    Chapter("inference", "Statistics and search", inference.CASES),
)


class UnknownCaseError(ValueError):
    """A name that is neither a case nor a chapter: ``name``, and the names that are ``known``."""

    def __init__(self, name: str, known: Sequence[str]) -> None:
        super().__init__(name)
        self.name, self.known = name, tuple(known)


def find_cases(names: Sequence[str] = ()) -> tuple[Case, ...]:
    """Return the cases of these names, in the order of the manual; a chapter stands for its cases, no name for all.

    Raises
    ------
    UnknownCaseError
        For a name of neither.
    """
    known = [name for chapter in CHAPTERS for name in (chapter.name, *(one.name for one in chapter.cases))]
    for name in names:
        if name not in known:
            raise UnknownCaseError(name, known)
    return tuple(
        one for chapter in CHAPTERS for one in chapter.cases if not names or one.name in names or chapter.name in names
    )
