"""Methods of follow-up jobs: planned evaluations around an optimum or over the whole space, instead of a search."""

from __future__ import annotations

from typing import Annotated, ClassVar, Literal, TypeAlias

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.problem.base import Section

__all__ = [
    "FOLLOW_UPS",
    "FollowUpMethod",
    "GlobalMethod",
    "MorrisMethod",
    "ProfileMethod",
    "SensitivityMethod",
    "SobolMethod",
]

_Positive = Annotated[float, Field(gt=0)]
_OF = "id of the job whose optimum this is, which then shows what is found"


class SensitivityMethod(Section):
    """Sensitivities at an optimum by differences of fourth order, 4 d + 1 evaluations a step.

    Without a step, one is found for each parameter: further generations move only those parameters whose derivative is
    not certain yet, and a last one, of 2 d evaluations, lies at the ends of the intervals that they give.
    """

    kind: Literal["sensitivity"] = "sensitivity"
    at: dict[str, float] = Field(min_length=1, description="the optimum: values of all free parameters")
    step: float | None = Field(
        None,
        gt=0,
        le=0.1,
        description="largest difference, in parts of the range in search coordinates; where absent, it is found for "
        "each parameter, and it takes some more evaluations",
    )
    polish: bool = Field(
        False, description="go to the minimum first by Levenberg-Marquardt steps, one generation of 2 d + 1 each"
    )
    of: str | None = Field(None, min_length=1, max_length=64, description=_OF)

    def planned(self, free: int) -> int | None:
        """Number of evaluations at most; None when it is not known before."""
        return None if self.polish or self.step is None else 4 * free + 1


class ProfileMethod(Section):
    """Profile objectives: the lowest objective for every value of one parameter, all parameters and sides at once."""

    kind: Literal["profile"] = "profile"
    at: dict[str, float] = Field(min_length=1, description="the optimum: values of all free parameters")
    rise: dict[str, _Positive] = Field(
        min_length=1, description="rise of the objective at the ends of the interval, of each parameter to profile"
    )
    step: dict[str, Annotated[float, Field(gt=0, le=0.1)]] = Field(
        default={}, description="first step away from the optimum, in parts of the range; 0.05 where absent"
    )
    of: str | None = Field(None, min_length=1, max_length=64, description=_OF)

    def planned(self, free: int) -> int | None:  # noqa: ARG002  (the form of all methods)
        """None: how far the profiles go is not known before."""
        return None


class SobolMethod(Section):
    """Sobol indices over the whole space, the share of the variation by parameter; samples (d + 2) evaluations."""

    kind: Literal["sobol"] = "sobol"
    samples: int = Field(256, ge=8, le=2**17, description="base points, a power of two")
    batch: int = Field(200, ge=1, le=1000, description="evaluations in a generation")
    of: str | None = Field(None, min_length=1, max_length=64, description=_OF)
    further: ClassVar[int] = 2
    """Evaluations of a base point beside one a parameter."""

    @field_validator("samples")
    @classmethod
    def _power_of_two(cls, value: int) -> int:
        if value & (value - 1):
            raise PydanticCustomError("power_of_two", "must be a power of two, not {value}", {"value": value})
        return value

    def planned(self, free: int) -> int | None:
        """Number of evaluations."""
        return self.samples * (free + self.further)


class MorrisMethod(Section):
    """Elementary effects of Morris over the whole space, a cheap screening; samples (d + 1) evaluations."""

    kind: Literal["morris"] = "morris"
    samples: int = Field(20, ge=8, le=100_000, description="trajectories")
    batch: int = Field(200, ge=1, le=1000, description="evaluations in a generation")
    of: str | None = Field(None, min_length=1, max_length=64, description=_OF)
    further: ClassVar[int] = 1
    """Evaluations of a trajectory beside one a parameter."""

    def planned(self, free: int) -> int | None:
        """Number of evaluations."""
        return self.samples * (free + self.further)


GlobalMethod: TypeAlias = SobolMethod | MorrisMethod
FollowUpMethod: TypeAlias = SensitivityMethod | ProfileMethod | GlobalMethod

FOLLOW_UPS: dict[str, type[FollowUpMethod]] = {
    "sensitivity": SensitivityMethod,
    "profile": ProfileMethod,
    "sobol": SobolMethod,
    "morris": MorrisMethod,
}
"""Methods of follow-up jobs by kind."""
