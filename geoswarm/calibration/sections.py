"""What a problem says of a parameter, a series, an observation: the sections of the problem file, made in Python."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from geoswarm.solver.errors import Issue, ProblemError

__all__ = ["Section", "fixed", "free", "linked", "observed", "series"]

Section: TypeAlias = dict[str, Any]
"""A section of a problem file: mistakes in it are told when a problem is made of it, all at once."""


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
        It takes whole numbers only.

    Examples
    --------
    >>> free(1e3, 1e5, scale="log")
    {'lower': 1000.0, 'upper': 100000.0, 'scale': 'log'}
    """
    section: Section = {"lower": lower, "upper": upper, "scale": scale}
    section |= {} if initial is None else {"initial": initial}
    return section | ({"integer": True} if integer else {})


def fixed(value: float) -> Section:
    """A parameter with a known value."""
    return {"value": value}


def linked(expression: str) -> Section:
    """A parameter that follows from others, such as ``linked("0.5 * lambda_star")``."""
    return {"expression": expression}


def series(*, x_unit: str | None = None, y_unit: str | None = None, description: str = "") -> Section:
    """How the values of a function are to be read, where its units are not those of the observation.

    Parameters
    ----------
    x_unit, y_unit
        Units in which the function gets x and returns values; a plain number if None.
    description
        What the series is.
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
        Points, each of shape (m,): anything that NumPy takes for numbers.
    error
        Standard deviation of a reading, in the unit of y, where it is known.
    weight
        Of the series in the objective.
    weights
        Of the points, shape (m,); all 1 if absent.
    x_unit, y_unit
        Units of the data; those of the series if absent. A function without ``series`` gets and returns these.
    inputs
        Further quantities at the points that a formula uses by name, each of shape (m,).
    sort, repeated_x, resample, x_from, x_to, stage_x_from, leave_out_stages
        As in a problem file (``docs/problem-file.md``).

    Raises
    ------
    ProblemError
        The points are no numbers, or no list of them.
    """
    points: Section = {"x": _numbers("x", x), "y": _numbers("y", y)}
    if weights is not None:
        points["weight"] = _numbers("weights", weights)
    if inputs:
        points["inputs"] = {name: _numbers(f"inputs.{name}", values) for name, values in inputs.items()}
    given = {
        "error": error,
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
        raise ProblemError([Issue(f"observed.{name}", f"is no list of numbers: {error}")]) from None
    if array.dtype.kind not in "fiu":
        what = "an empty list" if not array.size else f"values of type {array.dtype}"
        raise ProblemError([Issue(f"observed.{name}", f"must be a list of numbers, not {what}")])
    if array.ndim != 1:
        raise ProblemError([Issue(f"observed.{name}", f"must have one dimension, not the shape {array.shape}")])
    return [float(value) for value in array]
