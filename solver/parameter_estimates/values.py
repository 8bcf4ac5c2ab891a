"""What evaluations share: a value or why there is none, what was drawn to find it, and the straight line."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import SolverError

__all__ = [
    "Arc",
    "ClassicalValue",
    "Construction",
    "DrawnLine",
    "DrawnPoint",
    "Estimate",
    "NoEvaluationError",
    "straight_line",
]


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
class Estimate:
    """A value that a parameter may have: ``source`` is a method or a correlation, ``reading`` whether it was read.

    ``ends``: less and plus the published scatter; both the value where none is published.
    """

    value: float
    ends: tuple[float, float]
    source: str
    reading: bool

    @classmethod
    def read(cls, value: float, source: str) -> Estimate:
        """One of the readings, without scatter."""
        return cls(value, (value, value), source, True)


class NoEvaluationError(SolverError):
    """A curve does not allow an evaluation; the message says what is missing."""


def straight_line(x: FloatArray, y: FloatArray) -> tuple[float, float, float]:
    """Return slope, value at x = 0, and the sum of squares of what is left; x and y of shape (n,).

    Raises
    ------
    NoEvaluationError
        All x are the same.
    """
    middle = float(x.mean())
    dx, dy = x - middle, y - y.mean()
    square = float(dx @ dx)
    if not square > 0.0:
        raise NoEvaluationError("the points of a straight line are all at the same place")
    slope = float(dx @ dy) / square
    left = dy - slope * dx
    return slope, float(y.mean()) - slope * middle, float(left @ left)


Role: TypeAlias = Literal["main", "helper"]


@dataclass(frozen=True, slots=True)
class DrawnLine:
    """A line of a construction, through points (n,); ``helper`` lines are thin."""

    label: str
    x: FloatArray
    y: FloatArray
    role: Role = "helper"


@dataclass(frozen=True, slots=True)
class DrawnPoint:
    """A point with what it says."""

    label: str
    x: float
    y: float


@dataclass(frozen=True, slots=True)
class Arc:
    """A half circle over the x axis: a Mohr circle between two principal stresses, kPa."""

    smallest: float
    largest: float


@dataclass(frozen=True, slots=True)
class Construction:
    """One construction.

    Parameters
    ----------
    name
        Of the figure, without that of the test: casagrande, log_log, root_time_2, log_time_2, mohr_circles.
    part
        Name of the test in a combined model; empty otherwise.
    heading, caption
        What stands above and below it.
    x_quantity, x_unit, y_quantity, y_unit
        What the axes show; the values are in these units.
    x, y
        Readings, shape (n,); empty where there are none, as of Mohr circles.
    lines, marks, arcs
        What was drawn.
    joined
        Whether readings are joined in their order, as those of loading and unloading.
    log, downwards
        Whether x is on a log scale, and y grows downwards.
    first_loading
        False: of a stage whose load is not larger than all before.
    """

    name: str
    part: str
    heading: str
    caption: str
    x_quantity: str
    x_unit: str
    y_quantity: str
    y_unit: str
    x: FloatArray
    y: FloatArray
    lines: tuple[DrawnLine, ...]
    marks: tuple[DrawnPoint, ...] = ()
    arcs: tuple[Arc, ...] = ()
    joined: bool = False
    log: bool = False
    downwards: bool = False
    first_loading: bool = True
