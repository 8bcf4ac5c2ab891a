"""Measured and calculated series of a job, in the units that the user gave."""

from __future__ import annotations

from typing import Annotated, Literal

from fastapi import APIRouter, Query
from pydantic import Field

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas import Model, Number
from geoswarm.workers.fit import fit_of

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}", tags=["results"])

MAX_NUMBER = 2**31 - 1


class FitParameter(Model):
    """A parameter as it stands in the problem."""

    name: str
    symbol: str
    unit: str = Field(description="empty for a pure number")
    form: Literal["free", "fixed", "linked"]
    value: float | None = Field(description="of a fixed one")
    expression: str | None = Field(description="of a linked one")
    lower: float | None
    upper: float | None
    scale: Literal["linear", "log"] | None
    initial: float | None


class FitSeries(Model):
    """Measured points of one series, by rising x."""

    series: str
    x_quantity: str
    y_quantity: str
    x_unit: str
    y_unit: str
    weight: float
    x: list[float]
    measured: list[float]
    breaks: list[float] = Field(description="x at which a load is applied")


class FitShare(Model):
    """Part of one series in the objective."""

    series: str
    weight: float
    misfit: Number
    share: float
    root_mean_square: Number = Field(description="of the residuals, weighted as the points are, in unit")
    unit: str = Field(description="of the measured values")


class FitCurve(Model):
    """What one evaluation gives at the measured points."""

    role: Literal["initial", "best", "chosen"] = Field(description="initial: the first evaluation that succeeded")
    generation: int
    particle: int
    objective: Number
    parameters: dict[str, float] = Field(description="all of them, by name")
    shares: list[FitShare]
    values: dict[str, list[Number]] = Field(description="calculated values of each series, in its y_unit")


class Fit(Model):
    """Measured points, and what the first and the best evaluation give there."""

    objective_unit: str = Field(description="empty where series of different units add up")
    parameters: list[FitParameter]
    series: list[FitSeries]
    curves: list[FitCurve]


@router.get("/fit", responses=problems_of(404, 422))
def fit(
    job_id: JobId,
    service: Service,
    generation: Annotated[int | None, Query(ge=0, le=MAX_NUMBER, description="with particle: one more to show")] = None,
    particle: Annotated[int | None, Query(ge=0, le=MAX_NUMBER)] = None,
) -> Fit:
    """Show measured points with what was calculated there, from stored responses; and the parameters with units."""
    if (generation is None) != (particle is None):
        raise DetailError(422, "generation and particle name an evaluation together: give both, or none.")
    chosen = None if generation is None or particle is None else (generation, particle)
    return Fit.model_validate(fit_of(service, job_id, chosen))
