"""Measured points, and what single evaluations give there, in the units that the user gave."""

from __future__ import annotations

from typing import Literal

from geoswarm.records.arrays import Floats, Measured
from geoswarm.records.record import Number, described, record
from geoswarm.records.statistics import SeriesShare

__all__ = ["Fit", "FitCurve", "FitDiagram", "FitDiagrams", "FitParameter", "FitSeries"]


@record
class FitParameter:
    """A parameter as given in the problem."""

    name: str
    symbol: str
    unit: str = described("empty for a pure number")
    form: Literal["free", "fixed", "linked"]
    value: float | None = described("of a fixed one")
    expression: str | None = described("of a linked one")
    lower: float | None
    upper: float | None
    scale: Literal["linear", "log"] | None
    initial: float | None
    typical_lower: float | None = described(
        "ends of the usual range of the quantity; null where none is known", default=None
    )
    typical_upper: float | None = None


@record(eq=False)
class FitSeries:
    """Measured points of one series, by rising x."""

    series: str
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    weight: float
    x: Measured
    measured: Measured
    breaks: Measured = described("x at which a load is applied")
    gross_x: Measured = described("of readings marked as gross errors, which are in no misfit")
    gross_measured: Measured
    x_names: list[str] = described("what x = 1, 2, ... is called; empty where x is a quantity", default_factory=list)
    distance: Literal["vertical", "orthogonal"] = described("how its residuals are measured", default="vertical")


@record(eq=False)
class FitCurve:
    """Calculated values of one evaluation at the measured points."""

    role: Literal["initial", "best", "chosen"] = described("initial: the first evaluation that succeeded")
    generation: int
    particle: int
    objective: Number
    parameters: dict[str, float] = described("all of them, by name")
    shares: list[SeriesShare]
    values: dict[str, Floats] = described("calculated values of each series, in its y_unit")
    residuals: dict[str, Floats] = described(
        "of each series, in its y_unit: calculated less measured, or distances from the calculated curve"
    )


@record(eq=False)
class Fit:
    """Measured points, and what the first and the best evaluation give there."""

    objective_unit: str = described("empty where series of different units add up")
    parameters: list[FitParameter]
    series: list[FitSeries]
    curves: list[FitCurve]


@record(eq=False)
class FitDiagram:
    """A diagram that engineers draw of a test: one quantity over another, measured and of the best evaluation."""

    name: str = described("as the figure of the report is called")
    heading: str
    test: str = described("name of the test in a combined model; empty otherwise")
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    log: bool = described("x is logarithmic")
    downwards: bool = described("y grows downwards")
    x: Floats = described("of the calculated line; null between pieces that are not joined")
    y: Floats
    measured_x: Measured
    measured_y: Measured


@record
class FitDiagrams:
    """Diagrams of the tests of a job."""

    items: list[FitDiagram]
