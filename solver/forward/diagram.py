"""Diagrams that engineers draw of a test, of one series over another: declared by the test, drawn by reports."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from geoswarm.solver.arrays import FloatArray

__all__ = ["Derived", "Diagram", "Readings"]

Readings: TypeAlias = Mapping[str, FloatArray]
"""Values by the name of a quantity, at the same moments, shape (m,) each, base units."""


@dataclass(frozen=True)
class Derived:
    """A quantity that was not measured itself, derived from readings of others.

    Parameters
    ----------
    quantity
        Name of the series that follows, without the prefix of its axis.
    needs
        Those that it follows from; what a series runs over counts as one of them.
    of
        From the readings, and the calculated values where the test begins, to its values.
    """

    quantity: str
    needs: tuple[str, ...]
    of: Callable[[Readings, Mapping[str, float]], FloatArray]


@dataclass(frozen=True)
class Diagram:
    """One series over another.

    Parameters
    ----------
    name
        Of the figure.
    heading, caption
        What stands above and below it.
    x, y
        Names of the series without the prefix of their axis: ``p`` is ``time_p`` over time.
    log
        Whether x is logarithmic.
    downwards
        Whether y grows downwards.
    small
        The diagram is of small values of x: it is drawn where one of at most this was read; None: always.
    derived
        What follows from other readings where x or y was not measured.
    """

    name: str
    heading: str
    caption: str
    x: str
    y: str
    log: bool = False
    downwards: bool = False
    small: float | None = None
    derived: tuple[Derived, ...] = ()
