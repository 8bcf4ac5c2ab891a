"""Stop criteria: small frozen objects, each judged after every generation; all satisfied reasons are reported.

(i) a maximum number of forward runs or of seconds, (ii) the objective below a limit, (iii) the objective not lowered
during a number of generations (Meier et al. 2008).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import ClassVar, Protocol

__all__ = [
    "ALL_FAILED",
    "MaxEvaluations",
    "MaxSeconds",
    "StagnationGenerations",
    "StopCriterion",
    "SwarmStatus",
    "TargetObjective",
    "fails_always",
    "satisfied_reasons",
]

ALL_FAILED = "all_failed"
"""Reason of a search that ends because its program fails whatever the parameters are."""

_OF_PROGRAM = ("not_started", "program_failed", "no_output", "bad_output")
_ENOUGH = 5


@dataclass(frozen=True, slots=True)
class SwarmStatus:
    """What the criteria judge, after a finished generation.

    Parameters
    ----------
    evaluations
        Forward runs so far, failed ones included.
    next_evaluations
        Forward runs that the next generation would add.
    seconds
        Running time of the job so far [s], pauses excluded.
    objective
        Best objective so far; None while no evaluation has succeeded.
    stagnation
        Finished generations since the best objective was last lowered.
    """

    evaluations: int
    next_evaluations: int
    seconds: float
    objective: float | None
    stagnation: int


class StopCriterion(Protocol):
    """One reason to stop."""

    @property
    def reason(self) -> str:
        """Name of the criterion in the problem file, reported as the stop reason."""

    def satisfied(self, status: SwarmStatus) -> bool:
        """Return whether to stop."""


@dataclass(frozen=True, slots=True)
class MaxEvaluations:
    """Stop before a generation that would exceed a number of forward runs: the limit is never exceeded."""

    limit: int
    reason: ClassVar[str] = "max_evaluations"

    def satisfied(self, status: SwarmStatus) -> bool:
        """Return whether the next generation would exceed the limit."""
        return status.evaluations + max(status.next_evaluations, 1) > self.limit


@dataclass(frozen=True, slots=True)
class MaxSeconds:
    """Stop when the running time [s] has reached a limit."""

    limit: float
    reason: ClassVar[str] = "max_seconds"

    def satisfied(self, status: SwarmStatus) -> bool:
        """Return whether the time is over."""
        return status.seconds >= self.limit


@dataclass(frozen=True, slots=True)
class TargetObjective:
    """Stop when the best objective is at or below a limit."""

    limit: float
    reason: ClassVar[str] = "target_objective"

    def satisfied(self, status: SwarmStatus) -> bool:
        """Return whether the best objective is good enough."""
        return status.objective is not None and status.objective <= self.limit


@dataclass(frozen=True, slots=True)
class StagnationGenerations:
    """Stop when the best objective was not lowered during a number of generations."""

    limit: int
    reason: ClassVar[str] = "stagnation_generations"

    def satisfied(self, status: SwarmStatus) -> bool:
        """Return whether the search stagnates."""
        return status.stagnation >= self.limit


def fails_always(failures: Mapping[str, int], evaluations: int) -> bool:
    """Whether a program has failed in all evaluations, enough of them, and never for a reason of the parameters."""
    return evaluations >= _ENOUGH and sum(failures.get(reason, 0) for reason in _OF_PROGRAM) == evaluations


def satisfied_reasons(criteria: Sequence[StopCriterion], status: SwarmStatus) -> tuple[str, ...]:
    """Return the reasons of all satisfied criteria, in their order."""
    return tuple(criterion.reason for criterion in criteria if criterion.satisfied(status))


def evaluations_left(criteria: Sequence[StopCriterion], evaluations: int) -> int | None:
    """Return how many evaluations may follow these, None: any number."""
    limits = [criterion.limit - evaluations for criterion in criteria if isinstance(criterion, MaxEvaluations)]
    return min(limits, default=None)
