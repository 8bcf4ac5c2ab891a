"""The sections of a problem file as pydantic models: names, types, limits and defaults of everything written in it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, TypeAlias, Union

from pydantic import AfterValidator, Field
from pydantic_core import PydanticCustomError

from geoswarm.solver.forward.registry import AnyForwardModelSpec
from geoswarm.solver.index_properties import IndexSection
from geoswarm.solver.methods.base import Method
from geoswarm.solver.methods.particle_swarm import ParticleSwarmMethod
from geoswarm.solver.methods.registry import built_in_methods
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.running import Answering, Failures, Limits
from geoswarm.solver.problem.test_table.section import SpecimenRow, SpecimenTable
from geoswarm.solver.problem.weighting import Weighting
from geoswarm.solver.section import Section

__all__ = [
    "FixedSection",
    "FreeSection",
    "LinkedSection",
    "MethodSection",
    "NoiseSection",
    "PARAMETER_FORMS",
    "ParameterSection",
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
    scale: Scale = Field(
        "linear",
        description="log: the search runs over the logarithm; both bounds above 0. "
        "Recommended for bounds more than a factor of 100 apart",
    )
    initial: float | None = Field(None, description="estimate to start from; the first particle of the swarm")
    integer: bool = Field(False, description="accepts whole numbers only, as do its bounds")


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


def _printable(value: str) -> str:
    if not value.isprintable():
        raise PydanticCustomError("name", "must be printable text on one line, without control characters")
    return value


ProblemName = Annotated[str, Field(min_length=1, max_length=200), AfterValidator(_printable)]
"""The name of a problem, and of its job."""


class Settings(Section):
    """Settings of a problem beyond physics and method."""

    name: ProblemName = Field("calibration", description="name of the problem")
    constraints: list[str] = Field(
        default=[],
        max_length=100,
        description='comparisons that every proposal must satisfy: "lambda_star > kappa_star"',
    )
    weighting: Weighting | None = Field(
        None,
        description="multiply the weights of the series by what a scheme gives: by_error (precision of the readings), "
        "by_count (number of readings), by_range (range of the readings), by_test (by range, each part of a combined "
        "problem alike)",
    )
    noise: NoiseSection | None = Field(
        None,
        description="what is known of the errors of the readings; if absent, intervals allow for what the residuals "
        "show, and below 50 readings a series for a correlation that they cannot exclude",
    )
    accept: list[str] = Field(
        default=[],
        max_length=1000,
        description="series whose readings are meant as they are, although no soil can have them by size or unit",
    )
    seed: int | None = Field(
        None, ge=0, le=_LARGEST_SEED, description="fixes all random numbers; chosen and reported if absent"
    )
    priority: int = Field(
        0,
        ge=-10,
        le=10,
        description="in the service: of an owner's jobs, those with a higher priority get more workers "
        "(an administrator's: of all jobs)",
    )


class NoiseSection(Section):
    """What is known of the errors of the readings."""

    kind: Literal["white", "correlated"] = Field(
        description="white: errors are independent, and intervals allow for nothing else; correlated: errors of "
        "neighbouring readings of a series are alike, and intervals always allow for that"
    )
    series: list[str] = Field(
        default=[], max_length=1000, description="the series of which this is known; all if there are none"
    )


class WarmStart(Section):
    """Earlier runs offered to the search."""

    jobs: list[str] = Field(
        min_length=1,
        max_length=20,
        description="ids of jobs of the service with the same forward model; their runs are offered to the search "
        "(`geoswarm run --warm-start DIR` offers those of a folder)",
    )


class ProblemFile(Settings):
    """A calibration problem: what to calculate, what to identify, what was measured, how to search and when to stop."""

    forward_model: AnyForwardModelSpec = Field(description="what is calculated; its kind determines the other keys")
    parameters: dict[str, ParameterSection] = Field(min_length=1, max_length=100, description="parameters by name")
    observations: list[ObservationSection] = Field(min_length=1, max_length=1000, description="what was measured")
    method: MethodSection = Field(default=ParticleSwarmMethod(), description="how to search")
    stopping: Stopping = Field(default=Stopping(), description="when to stop; a particle swarm needs one criterion")
    limits: Limits = Field(default=Limits(), description="what one evaluation may use")
    failures: Failures = Field(default=Failures(), description="what happens when an evaluation fails")
    answer: Answering = Field(default=Answering(), description="the runs after a search that its result needs")
    index_properties: IndexSection | None = Field(
        None, description="of the soil: correlations then suggest values of the parameters"
    )
    tests: str | list[SpecimenRow] | SpecimenTable | None = Field(
        None,
        description="laboratory tests, one row a test: a table (CSV file or workbook), or a list; each becomes a part "
        "of a combined forward model with its observations, which then need not be given",
    )
    warm_start: WarmStart | None = Field(None, description="earlier runs that an accelerated swarm learns from")
