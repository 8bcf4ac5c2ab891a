"""The zero reading of a gauge: the first one, that at a given x, or a known number."""

from __future__ import annotations

from typing import Literal

import numpy as np
from pydantic import model_validator

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.problem.issues import number
from geoswarm.solver.section import Section
from geoswarm.solver.sentences import SentenceError, setting

__all__ = ["ZeroReading", "zero_reading"]


class ZeroReading(Section):
    """The zero reading by its x or by its value."""

    x: float | None = None
    y: float | None = None

    @model_validator(mode="after")
    def _one_way(self) -> ZeroReading:
        if (self.x is None) == (self.y is None):
            raise SentenceError(
                "give first, or either ", setting("x"), " or ", setting("y"), ", for example ", setting("y", "12.31")
            )
        return self


def zero_reading(
    zero: Literal["first"] | ZeroReading, x: FloatArray, y: FloatArray, counted: BoolArray
) -> tuple[float | None, str]:
    """Value of the zero reading and what it is in words; None and what is wrong.

    Parameters
    ----------
    x, y
        Readings in the units of the data, shape (m,).
    counted
        Which of them are no gross errors, shape (m,); at least one.
    """
    x, y = x[counted], y[counted]
    if zero == "first":
        return float(y[0]), f"the first reading, {number(float(y[0]))}, was subtracted as the zero reading"
    if zero.y is not None:
        return zero.y, f"the zero reading {number(zero.y)} was subtracted"
    assert zero.x is not None
    order = np.argsort(x, kind="stable")
    x, y = x[order], y[order]
    if not x[0] <= zero.x <= x[-1]:
        reach = f"the readings reach from x = {number(float(x[0]))} to {number(float(x[-1]))}"
        return None, f"there is no reading at x = {number(zero.x)}: {reach}"
    found = float(np.interp(zero.x, x, y))
    how = "" if (x == zero.x).any() else ", between its neighbours"
    return found, f"the reading at x = {number(zero.x)}{how}, {number(found)}, was subtracted as the zero reading"
