"""The identified parameters of a job with their uncertainty, run through a forward model."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import OF_JOB
from geoswarm.solver.methods.given_points import GivenPointsMethod

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["PredictMethod"]

Positive = Annotated[float, Field(gt=0)]
Sentence = Annotated[str, Field(min_length=1, max_length=2000)]


class PredictMethod(GivenPointsMethod):
    """A sample of the parameters of another job: first the optimum of each of its basins, then the draws."""

    title: ClassVar[str] = "prediction"
    keeps_parts: ClassVar[bool] = True

    kind: Literal["predict"] = "predict"
    points: dict[str, list[float]] = Field(
        min_length=1, description="values of each free parameter: the optima of the basins, then the draws"
    )
    shares: list[Annotated[float, Field(ge=0, le=1)]] = Field(
        min_length=1, description="shares of the basins; as many points are their optima"
    )
    weights: list[Annotated[float, Field(ge=0)]] = Field(
        min_length=1, description="weights of the draws, with the sum 1"
    )
    basins: list[Annotated[int, Field(ge=0)]] = Field(min_length=1, description="basin of each draw, from 0")
    noise_factors: list[Positive] = Field(
        min_length=1, description="of the error of a reading in each draw: an estimated error is uncertain itself"
    )
    level: float = Field(0.9, gt=0, lt=1, description="of the band")
    readings: dict[str, Positive] = Field(
        default={}, description="standard deviation of a future reading by series, base units, where it is known"
    )
    unmeasured: list[str] = Field(default=[], description="series without measured values: their y is meaningless")
    basis: Literal["covariance", "posterior"] = Field("covariance", description="where the draws come from")
    undecided: list[str] = Field(default=[], description="parameters drawn over their searched range")
    alarm: Sentence | None = Field(None, description="why the band is unreliable")
    remarks: list[Sentence] = Field(default=[], max_length=50, description="what the band contains, in sentences")
    question: str | None = Field(None, max_length=64, description="hash of the problem whose parameters these are")
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)

    def in_words(self) -> str:
        """Name it."""
        return f"follow-up: prediction by {len(self.weights)} draws from the {self.basis}"

    def issues(self, problem: Problem) -> list[Issue]:
        """Compare points, weights and series with the problem."""
        issues = super().issues(problem)
        if issues:
            return issues
        draws = (self.planned(0) or 0) - len(self.shares)
        if draws < 1:
            return [Issue("method.points", f"must have draws behind the optima of {len(self.shares)} basins")]
        for name in ("weights", "basins", "noise_factors"):
            if len(getattr(self, name)) != draws:
                message = f"must have as many entries as there are draws ({draws}), got {len(getattr(self, name))}"
                issues.append(Issue(f"method.{name}", message))
        if max(self.basins) >= len(self.shares):
            issues.append(Issue("method.basins", f"must be below the number of shares ({len(self.shares)})"))
        if not sum(self.weights) > 0.0:
            issues.append(Issue("method.weights", "must not all be 0"))
        observed = {o.series for o in problem.observations}
        for name in ("readings", "unmeasured"):
            unknown = [series for series in getattr(self, name) if series not in observed]
            if unknown:
                issues.append(Issue(f"method.{name}", f"unknown series {unknown[0]}; observed: {', '.join(observed)}"))
        return issues
