"""The sections of a problem file on running its evaluations: limits, and what happens when one fails."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Annotated, Any, Literal, TypeAlias

from pydantic import BaseModel, ConfigDict, Field

from geoswarm.solver.errors import FailureReason

__all__ = [
    "DEFAULT_RETRIES",
    "SHARE_OF_SEARCH",
    "Answering",
    "Failures",
    "Limits",
    "Policy",
    "fatal_message",
    "least_answer",
]

Policy: TypeAlias = Literal["penalise", "fail"]

DEFAULT_RETRIES: Mapping[str, int] = {"worker_lost": 2}
"""Further tries by reason where the problem says nothing: only what is not the calculation's own doing."""


class Limits(BaseModel):
    """What one evaluation may use. An evaluation that exceeds it is killed with all processes that it started."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    seconds_per_evaluation: float | None = Field(None, gt=0, description="wall time of one evaluation in seconds")
    memory_mb: float | None = Field(
        None, ge=16, description="memory of one evaluation with all processes that it starts, in MiB"
    )


class Failures(BaseModel):
    """What happens when an evaluation fails: retries first, then the policy."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    retry: dict[FailureReason, Annotated[int, Field(ge=0, le=1000)]] = Field(
        default={}, description="further attempts by reason; worker_lost 2 and all others 0 if absent"
    )
    policy: Policy | dict[FailureReason, Policy] = Field(
        "penalise",
        description="penalise: the search treats it as infinitely bad and continues; fail: the job ends as failed;"
        " for all reasons, or by reason",
    )

    def retries(self, reason: str) -> int:
        """Return the number of retries of an evaluation that failed for this reason."""
        given: Mapping[Any, int] = self.retry  # a stored reason is any text
        return given.get(reason, DEFAULT_RETRIES.get(reason, 0))

    def tries_again(self, reason: str, earlier: Sequence[str]) -> bool:
        """Whether an evaluation that failed for this reason is retried after the ``earlier`` outcomes."""
        return list(earlier).count(reason) < self.retries(reason)

    def ends_job(self, reason: str) -> bool:
        """Whether a failure for this reason, without retries left, ends the job."""
        given: Mapping[Any, Policy] | Policy = self.policy
        return (given if isinstance(given, str) else given.get(reason)) == "fail"


SHARE_OF_SEARCH = 0.75
"""Part of the evaluations and the time of a job that its search may take at least, where it is followed by others."""

_QUICK_RUNS = 200
_LEFT_TO_AUTO = 15  # runs for each free parameter: sensitivities, steps to the minimum, ends of intervals, other basins


class Answering(BaseModel):
    """The runs after a search that its result needs: down to the minimum, and the sensitivities there."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    max_evaluations: Annotated[int, Field(ge=1)] | Literal["auto", "off"] = Field(
        "auto",
        description="largest number of runs after the search, for minimum and intervals; auto: a third of those of the "
        "search, or five for each free parameter if that is more, and at least 200 of a model that takes "
        "milliseconds; off: none",
    )

    def most(self, free: int, search: int, *, quick: bool = False) -> int:
        """Return the largest number of runs after a search of this number of evaluations."""
        if self.max_evaluations == "auto":
            return max(search // 3, 5 * free, _QUICK_RUNS if quick else 0)
        return 0 if self.max_evaluations == "off" else self.max_evaluations

    def share_of(self, limit: int, free: int, *, learns: bool) -> int:
        """Return how many of a job's evaluations its search leaves to the runs after it.

        A quarter at most. A search that learns has a response surface, from which less is left to find.
        """
        quarter = limit - int(SHARE_OF_SEARCH * limit)
        if self.max_evaluations == "auto":
            left = min(_LEFT_TO_AUTO * free, quarter) if learns else quarter
        else:
            left = min(self.most(free, 0), quarter)
        return left if left >= least_answer(free) else 0


def least_answer(free: int) -> int:
    """Return the number of runs for the sensitivities to a number of free parameters: differences of two sizes."""
    return 4 * free + 1


def fatal_message(generation: int, particle: int, reason: str, message: str | None) -> str:
    """Say which failed evaluation ended a job."""
    text = f"evaluation {particle} of generation {generation} failed ({reason}), which ends the job (failures.policy)"
    return f"{text}: {message}" if message else text
