"""One value that a ruler on the diagram gives, and one that a parameter may have by it."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["Candidate", "ClassicalValue"]


@dataclass(frozen=True, slots=True)
class ClassicalValue:
    """One value of the readings.

    Parameters
    ----------
    part
        Test that it belongs to; empty where there is but one, or where it belongs to several.
    symbol, unit
        As of the identified value.
    method
        How it was found.
    value
        None where the readings do not allow it.
    why
        Why there is none.
    stage
        Number of the stage that it belongs to, from 1; None: the whole test.
    first_loading
        Whether the load of that stage is larger than all before.
    """

    part: str
    symbol: str
    method: str
    value: float | None
    why: str = ""
    unit: str = ""
    stage: int | None = None
    first_loading: bool = True


@dataclass(frozen=True, slots=True)
class Candidate:
    """A value that a parameter may have: ``source`` is a method or a correlation, ``reading`` whether it was read.

    ``ends``: less and plus the published scatter; both the value where none is published.
    """

    value: float
    ends: tuple[float, float]
    source: str
    reading: bool

    @classmethod
    def read(cls, value: float, source: str) -> Candidate:
        """One of the readings, without scatter."""
        return cls(value, (value, value), source, True)
