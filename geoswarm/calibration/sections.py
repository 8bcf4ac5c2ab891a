"""Sections of the problem file, made in Python: parameter, series, observation."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.residuals import Distance

__all__ = ["Section", "fixed", "free", "linked", "observed", "series"]

Section: TypeAlias = dict[str, Any]
"""A section of a problem file; its mistakes are reported together when a problem is made of it."""


def free(
    lower: float,
    upper: float,
    *,
    scale: Literal["linear", "log"] = "linear",
    initial: float | None = None,
    integer: bool = False,
) -> Section:
    """A parameter to be identified between bounds.

    Parameters
    ----------
    lower, upper
        Bounds, in the parameter's unit.
    scale
        ``log``: the search runs over the logarithm; both bounds above 0.
    initial
        Estimate to start from.
    integer
        Whether it takes whole numbers only.

    Examples
    --------
    >>> import geoswarm as gs
    >>> gs.free(1e3, 1e5, scale="log")
    {'lower': 1000.0, 'upper': 100000.0, 'scale': 'log'}
    """
    section: Section = {"lower": lower, "upper": upper, "scale": scale}
    section |= {} if initial is None else {"initial": initial}
    return section | ({"integer": True} if integer else {})


def fixed(value: float) -> Section:
    """A parameter with a known value.

    Examples
    --------
    >>> import geoswarm as gs
    >>> gs.fixed(20)
    {'value': 20}
    """
    return {"value": value}


def linked(expression: str) -> Section:
    """A parameter that follows from others, such as ``linked("0.5 * lambda_star")``.

    Examples
    --------
    >>> import geoswarm as gs
    >>> gs.linked("0.5 * lambda_star")
    {'expression': '0.5 * lambda_star'}
    """
    return {"expression": expression}


def series(*, x_unit: str | None = None, y_unit: str | None = None, description: str = "") -> Section:
    """Units of a function's values, where they are not those of the observation.

    Parameters
    ----------
    x_unit, y_unit
        Units in which the function gets x and returns values; a plain number if None.
    description
        What the series is.

    Examples
    --------
    >>> import geoswarm as gs
    >>> gs.series(x_unit="day", y_unit="mm")
    {'x_unit': 'day', 'y_unit': 'mm'}
    """
    units = {"x_unit": x_unit, "y_unit": y_unit, "description": description or None}
    return {name: value for name, value in units.items() if value is not None}


def observed(
    x: npt.ArrayLike,
    y: npt.ArrayLike,
    *,
    error: float | None = None,
    weight: float = 1.0,
    weights: npt.ArrayLike | None = None,
    distance: Distance | None = None,
    x_unit: str | None = None,
    y_unit: str | None = None,
    inputs: Mapping[str, npt.ArrayLike] | None = None,
    sort: bool = False,
    repeated_x: Literal["average", "shift"] | None = None,
    resample: Mapping[str, int] | None = None,
    x_from: float | None = None,
    x_to: float | None = None,
    stage_x_from: float | None = None,
    leave_out_stages: Sequence[int] = (),
) -> Section:
    """Measured points of one series.

    Parameters
    ----------
    x, y
        Points, each of shape (m,): anything that NumPy converts to numbers.
    error
        Standard deviation of a reading, in the unit of y, where it is known.
    weight
        Weight of the series in the objective.
    weights
        Weights of the points, shape (m,); all 1 if absent.
    distance
        ``orthogonal``: residuals are the distances of the readings from the calculated curve, as for peaks that may
        shift along x; differences of y if absent.
    x_unit, y_unit
        Units of the data; those of the series if absent. A function without ``series`` uses these units, too.
    inputs
        Further quantities at the points that a formula uses by name, each of shape (m,).
    sort, repeated_x, resample, x_from, x_to, stage_x_from, leave_out_stages
        As in a problem file (``docs/problem-file.md``).

    Raises
    ------
    ProblemError
        The points are not a list of numbers.

    Examples
    --------
    >>> import geoswarm as gs
    >>> settlement = gs.observed([1, 10, 100], [0.8, 2.1, 3.0], x_unit="min", y_unit="mm", error=0.05)
    >>> settlement["points"]["y"], settlement["error"]
    ([0.8, 2.1, 3.0], 0.05)
    """
    points: Section = {"x": _numbers("x", x), "y": _numbers("y", y)}
    if weights is not None:
        points["weight"] = _numbers("weights", weights)
    if inputs:
        points["inputs"] = {name: _numbers(f"inputs.{name}", values) for name, values in inputs.items()}
    given = {
        "error": error,
        "distance": distance,
        "x_unit": x_unit,
        "y_unit": y_unit,
        "repeated_x": repeated_x,
        "resample": None if resample is None else dict(resample),
        "x_from": x_from,
        "x_to": x_to,
        "stage_x_from": stage_x_from,
        "leave_out_stages": list(leave_out_stages) or None,
        "sort": sort or None,
    }
    return {"points": points, "weight": weight} | {name: value for name, value in given.items() if value is not None}


def _numbers(name: str, values: npt.ArrayLike) -> list[float]:
    try:
        array = np.asarray(values)
    except ValueError as error:
        raise ProblemError([Issue(f"observed.{name}", f"must be a list of numbers: {error}")]) from None
    if array.dtype.kind not in "fiu":
        what = "an empty list" if not array.size else f"values of type {array.dtype}"
        raise ProblemError([Issue(f"observed.{name}", f"must be a list of numbers, got {what}")])
    if array.ndim != 1:
        raise ProblemError([Issue(f"observed.{name}", f"must have one dimension, got the shape {array.shape}")])
    return [float(value) for value in array]
