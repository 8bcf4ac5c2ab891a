"""What was drawn to find a value: readings, lines and points, for a figure."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from geoswarm.solver.arrays import FloatArray

__all__ = ["Arc", "Construction", "Line", "Mark"]

Role: TypeAlias = Literal["main", "helper"]


@dataclass(frozen=True, slots=True)
class Line:
    """A line of a construction, through points (n,); ``helper`` lines are thin."""

    label: str
    x: FloatArray
    y: FloatArray
    role: Role = "helper"


@dataclass(frozen=True, slots=True)
class Mark:
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
    lines: tuple[Line, ...]
    marks: tuple[Mark, ...] = ()
    arcs: tuple[Arc, ...] = ()
    joined: bool = False
    log: bool = False
    downwards: bool = False
    first_loading: bool = True
