"""How far a job is within its generation, and what its follow-ups would cost."""

from __future__ import annotations

from typing import Literal

from geoswarm.records.record import Number, described, record

__all__ = ["FollowUpCost", "FollowUpCosts", "Progress"]


@record
class Progress:
    """The generation that runs now; a finished run counts here at once, in the job when its generation has ended."""

    generation: int
    pending: int = described("runs of this generation that wait")
    running: int
    finished: int
    failed: int
    objective: Number = described("lowest objective so far, that of this generation included")
    evaluations: int = described("finished and failed runs of all generations, this one included")
    search_evaluations: int | None = described("of the search, once it has ended and its answer follows", default=None)
    answer_evaluations: int | None = described("upper bound of the evaluations after the search", default=None)
    seconds: Number = described("recent mean time of a run; null before one has finished")
    workers: int = described("live workers that are free or run this job")
    seconds_left: Number = described(
        "time until all planned runs end, if they take as long as those so far; null: not known"
    )


@record
class FollowUpCost:
    """Estimated runs and time of a follow-up."""

    kind: Literal["sensitivity", "profile", "jackknife", "explore", "sobol", "again"] = described(
        "again: the search as it was"
    )
    evaluations: int
    exact: bool = described("false: an estimate, as the search for the minimum and for steps decides")
    seconds: Number = described("mean time of a run of the job times runs, shared by the free workers; null: not known")
    refused: str | None = described("why it cannot be submitted now; null: it can")


@record
class FollowUpCosts:
    """Estimated runs and time of the follow-ups of a job."""

    items: list[FollowUpCost]
    run_seconds: Number = described("mean time of a run of the job")
    workers: int = described("live workers that hold no run")
