"""Records of the fit: measured points, and what single evaluations give there, in the units that the user gave."""

from __future__ import annotations

from dataclasses import dataclass

from geoswarm.client.arrays import Floats

__all__ = ["Fit", "FitCurve", "FitParameter", "FitSeries", "FitShare"]


@dataclass(frozen=True, slots=True)
class FitParameter:
    """A parameter as it stands in the problem; ``form`` is free, fixed or linked, ``unit`` empty for a pure number."""

    name: str
    symbol: str
    unit: str
    form: str
    value: float | None
    expression: str | None
    lower: float | None
    upper: float | None
    scale: str | None
    initial: float | None


@dataclass(frozen=True, slots=True, eq=False)
class FitSeries:
    """Measured points of one series, by rising x, both of shape (m,); ``breaks``: x at which a load is applied."""

    series: str
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    weight: float
    x: Floats
    measured: Floats
    breaks: Floats


@dataclass(frozen=True, slots=True)
class FitShare:
    """Part of one series in the objective, from 0 to 1; root mean square of its residuals in the data's unit."""

    series: str
    weight: float
    misfit: float | None
    share: float
    root_mean_square: float | None
    unit: str


@dataclass(frozen=True, slots=True, eq=False)
class FitCurve:
    """What one evaluation gives at the measured points.

    Attributes
    ----------
    role
        ``initial`` (the first evaluation that succeeded), ``best`` or ``chosen``.
    parameters
        All of them, by name.
    values
        Calculated values by series, shape (m,), in its ``y_unit``; NaN where not finite.
    """

    role: str
    generation: int
    particle: int
    objective: float | None
    parameters: dict[str, float]
    shares: list[FitShare]
    values: dict[str, Floats]


@dataclass(frozen=True, slots=True, eq=False)
class Fit:
    """Measured points with the curves; ``objective_unit`` is empty where series of different units add up."""

    objective_unit: str
    parameters: list[FitParameter]
    series: list[FitSeries]
    curves: list[FitCurve]
