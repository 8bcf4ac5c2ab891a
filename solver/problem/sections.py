"""The sections of a problem file as pydantic models: names, types, limits and defaults of everything written in it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias, Union

from pydantic import AfterValidator, Field, field_validator, model_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.forward.registry import AnyForwardModelSpec
from geoswarm.solver.methods.base import Method
from geoswarm.solver.methods.particle_swarm import ParticleSwarmMethod
from geoswarm.solver.methods.registry import built_in_methods
from geoswarm.solver.problem.preparation import Resample
from geoswarm.solver.problem.running import Failures, Limits
from geoswarm.solver.problem.tables.cells import moment_in
from geoswarm.solver.problem.weighting import Weighting
from geoswarm.solver.section import Section

__all__ = [
    "FixedSection",
    "FreeSection",
    "LinkedSection",
    "MethodSection",
    "ObservationSection",
    "PARAMETER_FORMS",
    "ParameterSection",
    "PointsSection",
    "ProblemFile",
    "Settings",
    "Scale",
    "Stopping",
    "WarmStart",
]

Scale: TypeAlias = Literal["linear", "log"]

_LARGEST_SEED = 2**53 - 1  # every JSON reader keeps whole numbers up to here exactly


class FreeSection(Section):
    """A parameter to be identified between bounds."""

    lower: float = Field(description="lowest value, in the parameter's unit")
    upper: float = Field(description="highest value")
    scale: Scale = Field("linear", description="log: the search runs over the logarithm; both bounds above 0")
    initial: float | None = Field(None, description="estimate to start from; the first particle of the swarm")
    integer: bool = Field(False, description="takes whole numbers only, as do its bounds")


class FixedSection(Section):
    """A parameter with a known value."""

    value: float = Field(description="the value, in the parameter's unit")


class LinkedSection(Section):
    """A parameter that follows from others."""

    expression: str = Field(description='value as an expression of other parameters, such as "0.5 * lambda_star"')


ParameterSection: TypeAlias = FreeSection | FixedSection | LinkedSection

PARAMETER_FORMS: dict[str, type[FreeSection] | type[FixedSection] | type[LinkedSection]] = {
    "free": FreeSection,
    "fixed": FixedSection,
    "linked": LinkedSection,
}
"""The three forms of a parameter; no key belongs to two of them."""


class PointsSection(Section):
    """Measured points inside the problem file."""

    x: list[float] = Field(min_length=1, description="x of the points, in x_unit")
    y: list[float] = Field(min_length=1, description="measured y, in y_unit")
    weight: list[Annotated[float, Field(ge=0)]] | None = Field(
        None, description="weights w_h of the points; all 1 if absent"
    )
    inputs: dict[str, list[float]] | None = Field(
        None, description="further quantities at the points that a formula uses by name, one value for each x"
    )


def _moment(text: str) -> str:
    if moment_in(text) is None:
        raise PydanticCustomError("moment", "must be a date with or without time, such as 2024-03-01 08:30")
    return text


Moment: TypeAlias = Annotated[str, AfterValidator(_moment)]

_OF_A_FILE = ("sheet", "x_column", "y_column", "weight_column", "inputs", "x_origin")


class ObservationSection(Section):
    """Measured points of one series."""

    series: str = Field(description="name of a series of the forward model")
    points: PointsSection | None = Field(None, description="the points themselves; give these or file")
    file: str | None = Field(
        None, min_length=1, description="CSV or XLSX file with columns x, y[, weight], relative to this file"
    )
    sheet: str | None = Field(None, min_length=1, description="sheet of an XLSX file; the first with cells if absent")
    x_column: str | None = Field(None, min_length=1, description="header of the file's x column, if it is not x")
    y_column: str | None = Field(None, min_length=1, description="header of the file's y column, if it is not y")
    weight_column: str | None = Field(
        None, min_length=1, description="header of the weight column, if it is not weight"
    )
    inputs: dict[str, str] | None = Field(
        None, description="columns of further quantities that a formula uses, header by name: {T: temperature}"
    )
    x_origin: Moment | None = Field(
        None, description='where x holds dates: the one at which x is 0 ("2024-03-01 08:30"); the first if absent'
    )
    x_unit: str | None = Field(
        None, description="unit of x in the data; that of its heading, or the series' base unit, if absent"
    )
    y_unit: str | None = Field(
        None, description="unit of y in the data; that of its heading, or the series' base unit, if absent"
    )
    sort: bool = Field(False, description="put the readings in the order of x first")
    repeated_x: Literal["average", "shift"] | None = Field(
        None,
        description="readings at equal x: average takes their mean, shift spreads them evenly up to the next x",
    )
    resample: Resample | None = Field(
        None, description="means of neighbouring readings in place of very many: {per_decade: 20} or {every: 10}"
    )
    weight: float = Field(1.0, ge=0, description="weight w_g of the series in the objective")
    error: float | None = Field(None, gt=0, description="standard deviation of a reading, in y_unit, where it is known")
    x_from: float | None = Field(None, description="points of a smaller x, in x_unit, take no part")
    x_to: float | None = Field(None, description="points of a larger x, in x_unit, take no part")
    stage_x_from: float | None = Field(
        None,
        ge=0,
        description="of a test in stages: readings sooner after their load than this, in x_unit, take no part (those "
        "before the end of primary consolidation, which the soil laws do not contain)",
    )
    leave_out_stages: list[Annotated[int, Field(ge=1)]] = Field(
        default=[], max_length=1000, description="numbers of stages, from 1, whose readings take no part"
    )

    @model_validator(mode="after")
    def _one_source(self) -> ObservationSection:
        if (self.points is None) == (self.file is None):
            given = "both are given" if self.file else "none is given"
            raise PydanticCustomError("one_source", "give either points or file; {given}", {"given": given})
        columns = [name for name in _OF_A_FILE if getattr(self, name) is not None]
        if self.file is None and columns:
            raise PydanticCustomError(
                "columns", "{columns} can only be given with file", {"columns": ", ".join(columns)}
            )
        return self


if TYPE_CHECKING:
    MethodSection: TypeAlias = Method
else:
    MethodSection = Annotated[Union[built_in_methods()], Field(discriminator="kind")]  # noqa: UP007  of a tuple


class Stopping(Section):
    """When a calibration ends: as soon as one criterion is satisfied."""

    max_evaluations: int | None = Field(None, ge=1, description="largest number of forward calculations")
    max_seconds: float | None = Field(None, gt=0, description="largest running time in seconds")
    target_objective: float | None = Field(
        None, ge=0, description="the objective is at or below this value [base unit²]"
    )
    stagnation_generations: int | None = Field(None, ge=1, description="generations without a lower objective")

    @property
    def is_empty(self) -> bool:
        """Whether there is no criterion at all."""
        return all(getattr(self, name) is None for name in Stopping.model_fields)


class Settings(Section):
    """What of a problem is neither physics nor method."""

    name: str = Field("calibration", min_length=1, max_length=200, description="name of the problem")

    @field_validator("name")
    @classmethod
    def _printable(cls, value: str) -> str:
        if not value.isprintable():
            raise PydanticCustomError("name", "must be printable text on one line, without control characters")
        return value

    constraints: list[str] = Field(
        default=[], max_length=100, description='comparisons that hold for every proposal: "lambda_star > kappa_star"'
    )
    weighting: Weighting | None = Field(
        None,
        description="multiply the weights of the series by what a scheme gives: by_error (precision of the readings), "
        "by_count (number of readings), by_range (range of the readings)",
    )
    seed: int | None = Field(
        None, ge=0, le=_LARGEST_SEED, description="fixes all random numbers; chosen and reported if absent"
    )
    priority: int = Field(
        0,
        ge=-10,
        le=10,
        description="in the service: one's own jobs of a higher one get more workers "
        "(an administrator's: among all jobs)",
    )


class WarmStart(Section):
    """Earlier runs to learn from."""

    jobs: list[str] = Field(
        min_length=1,
        max_length=20,
        description="ids of jobs of the service with the same forward model; their runs are offered to the search "
        "(`geoswarm run --warm-start DIR` offers those of a folder)",
    )


class ProblemFile(Settings):
    """A calibration problem: what to calculate, what to identify, what was measured, how to search and when to stop."""

    forward_model: AnyForwardModelSpec = Field(description="what is calculated; its kind decides about the other keys")
    parameters: dict[str, ParameterSection] = Field(min_length=1, max_length=100, description="parameters by name")
    observations: list[ObservationSection] = Field(min_length=1, max_length=1000, description="what was measured")
    method: MethodSection = Field(default=ParticleSwarmMethod(), description="how to search")
    stopping: Stopping = Field(default=Stopping(), description="when to stop; a particle swarm needs one criterion")
    limits: Limits = Field(default=Limits(), description="what one evaluation may use")
    failures: Failures = Field(default=Failures(), description="what happens when an evaluation fails")
    warm_start: WarmStart | None = Field(None, description="earlier runs that an accelerated swarm learns from")
