"""What to do: about a finding, as records that each surface words, and about a parameter, as changes of the problem."""

from __future__ import annotations

from typing import Any, Literal

from geoswarm.records.record import Number, described, record

__all__ = ["FittedLine", "Proposal", "Remedy"]


@record(closed=True)
class Remedy:
    """Something to do about a finding."""

    kind: Literal[
        "gross_errors",
        "check_readings",
        "primary_consolidation",
        "stage_ends",
        "change_model",
        "thin",
        "error",
        "sensitivity",
        "profile",
        "explore",
    ] = described("what; the last three are follow-ups")
    series: str | None = described("the series that it is about")
    values: dict[str, Any] = described("numbers and names that belong to it")
    changes: list[str] = described("keys of the observation, in the problem file, that it changes")
    text: str = described("the remedy in the words of problem file and command line")


@record(closed=True)
class FittedLine:
    """Line through the good fits, by which one parameter may be linked to another."""

    parameter: str
    partner: str
    scale: Literal["linear", "log"]
    intercept: float
    slope: float
    lower: float
    upper: float
    residual: Number
    correlation: float
    count: int
    expression: str


@record(closed=True)
class Proposal:
    """Something to do about a parameter."""

    kind: Literal["fix", "link", "widen", "add_test"]
    parameter: str
    sentence: str
    changes: dict[str, Any] = described("parts of the problem to replace")
    line: FittedLine | None
