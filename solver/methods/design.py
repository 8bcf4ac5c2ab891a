"""Sensitivities of candidate tests at the optimum of a job and at draws around it: which of them would tell most."""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import Field

from geoswarm.solver.errors import Issue
from geoswarm.solver.methods.base import OF_JOB
from geoswarm.solver.methods.given_points import GivenPointsMethod
from geoswarm.solver.section import Section

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["CandidateReadings", "Criterion", "DesignCandidate", "DesignMethod", "DesignParameter", "DesignPoint"]

Positive = Annotated[float, Field(gt=0)]
Sentence = Annotated[str, Field(min_length=1, max_length=2000)]
Name = Annotated[str, Field(min_length=1, max_length=200)]
Criterion = Literal["widths", "volume", "prediction"]


class CandidateReadings(Section):
    """Readings of one series: places in its observed x, and their standard deviation, base units."""

    series: str
    at: list[Annotated[int, Field(ge=0)]] = Field(min_length=1)
    error: Positive | None = Field(None, description="none for what is predicted")


class DesignCandidate(Section):
    """A test or measuring points that could be had."""

    name: Name
    cost: Positive | None = None
    readings: list[CandidateReadings] = Field(min_length=1)


class DesignParameter(Section):
    """A parameter of the job: its value at the best optimum, its bounds and scale."""

    value: float
    lower: float
    upper: float
    scale: Literal["linear", "log"]
    decided: bool = Field(description="whether the data limit it within its bounds")


class DesignPoint(Section):
    """Which sensitivity a point is for: it moves one parameter away from a centre, in parts of its range."""

    centre: Annotated[int, Field(ge=0)]
    parameter: str | None = Field(None, description="none at the centre itself")
    offset: float = 0.0


class DesignMethod(GivenPointsMethod):
    """The optimum of each basin and draws around it, and beside each centre two places along each parameter."""

    title: ClassVar[str] = "choice of further tests"
    keeps_parts: ClassVar[bool] = True

    kind: Literal["design"] = "design"
    points: dict[str, list[float]] = Field(min_length=1, description="values of each free parameter")
    plan: list[DesignPoint] = Field(min_length=1, description="what each point is for")
    basins: list[Annotated[int, Field(ge=0)]] = Field(min_length=1, description="basin of each centre, from 0")
    weights: list[Annotated[float, Field(ge=0)]] = Field(min_length=1, description="of the centres")
    identified: dict[str, DesignParameter] = Field(min_length=1, description="parameters of the job, in its order")
    covariances: list[list[list[float]]] = Field(
        min_length=1, description="of each basin, parts of the ranges: what the data of the job leave uncertain"
    )
    quantile: Positive = Field(description="of Student's t, for the half width of a 95 % interval")
    candidates: list[DesignCandidate] = Field(min_length=1, max_length=200)
    prediction: DesignCandidate | None = Field(None, description="what is to be predicted")
    criterion: Criterion = Field("widths", description="what the candidates are put in order by")
    alarm: Sentence | None = Field(None, description="why nothing of it can be relied on")
    remarks: list[Sentence] = Field(default=[], max_length=50)
    question: str | None = Field(None, max_length=64, description="hash of the problem of the job")
    of: str | None = Field(None, min_length=1, max_length=64, description=OF_JOB)

    def in_words(self) -> str:
        """Name it."""
        return f"follow-up: worth of {len(self.candidates)} candidate tests"

    def issues(self, problem: Problem) -> list[Issue]:
        """Compare plan, centres and candidates with the problem."""
        issues = super().issues(problem) or self.lengths(plan=self.plan)
        if len(self.basins) != len(self.weights):
            issues.append(Issue("method.weights", f"must be as many as basins ({len(self.basins)})"))
        if max(self.basins) >= len(self.covariances) or max(p.centre for p in self.plan) >= len(self.basins):
            issues.append(Issue("method.basins", "must each have a covariance, and each centre of the plan a basin"))
        size = len(self.identified)
        if any(len(c) != size or any(len(row) != size for row in c) for c in self.covariances):
            issues.append(Issue("method.covariances", f"must have {size} rows and columns, one a parameter"))
        lengths = {o.series: o.x.size for o in problem.observations}
        for candidate in (*self.candidates, *(() if self.prediction is None else (self.prediction,))):
            for readings in candidate.readings:
                if max(readings.at) >= lengths.get(readings.series, 0):
                    message = f"{candidate.name}: no such point of series {readings.series}"
                    issues.append(Issue("method.candidates", message))
        return issues
