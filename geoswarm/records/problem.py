"""What a check of a problem says, and what forward models have."""

from __future__ import annotations

from typing import Any, Literal

from geoswarm.records.evaluation import Response
from geoswarm.records.record import Number, described, record
from geoswarm.records.statistics import WeightShare

__all__ = ["CheckResult", "ForwardModelDetail", "ForwardModelSummary", "Parameter", "Series", "TestRun", "WarmStart"]


@record
class TestRun:
    """One forward calculation to test the problem."""

    __test__ = False

    state: Literal["finished", "failed"]
    parameters: dict[str, float] = described("all parameters, by name")
    objective: Number
    misfits: dict[str, Number]
    responses: dict[str, Response] = described("calculated series at their observed points, base units")
    seconds: float
    reason: str | None
    message: str | None


@record
class WarmStart:
    """An earlier job with the same forward model: `warm_start: {jobs: [ID]}` offers its runs to the search."""

    job: str
    name: str
    evaluations: int = described("that could be taken over at no cost, 2000 at most are counted")


@record
class CheckResult:
    """What a valid problem will run and cost."""

    valid: Literal[True] = True
    name: str
    forward_model: str
    method: str
    free_parameters: list[str]
    data_points: int
    planned_evaluations: int | None = described("null when only time or quality ends the search")
    left_to_answer: int | None = described(
        "how many of these the search leaves for minimum and intervals; null without planned_evaluations"
    )
    test_run: TestRun
    estimated_seconds: float | None = described(
        "time of all planned evaluations on one worker and of the search itself"
    )
    warnings: list[str] = described("what is probably unintended or not modelled, and what to do")
    notes: dict[str, list[str]] = described("how the readings of each series were processed, if they were")
    assumptions: list[str] = described("what the forward model assumes where the problem says nothing")
    shares: list[WeightShare] = described("what the weights make of each series")
    warm_starts: list[WarmStart] = described("earlier jobs that the search can use, newest first")


@record
class Parameter:
    """A parameter of a forward model; limits in its unit."""

    name: str
    symbol: str
    unit: str
    description: str
    default: float | None = described("null: the problem must give it")
    lower: Number
    upper: Number
    lower_open: bool = described("the lower limit itself is refused")
    upper_open: bool
    typical: tuple[float, float] | None
    source: str = described("source of the typical range; empty: none")


@record
class Series:
    """An output of a forward model: y over x, in base units."""

    name: str
    description: str
    x_quantity: str
    x_unit: str
    y_quantity: str
    y_unit: str
    x_lower: Number
    x_upper: Number
    x_integer: bool
    x_increasing: bool


@record
class ForwardModelSummary:
    """A kind of forward model; ``model`` names a registered model, null for all other kinds."""

    kind: str
    description: str
    model: str | None


@record
class ForwardModelDetail(ForwardModelSummary):
    """A kind of forward model in full."""

    json_schema: dict[str, Any] = described("JSON schema of the forward_model section")
    example: dict[str, Any] | None = described("a forward_model section of this kind")
    depends_on_section: bool = described(
        "parameters and series follow from the section (a formula, a combination); listed for the example"
    )
    note: str | None
    parameters: list[Parameter]
    series: list[Series]
