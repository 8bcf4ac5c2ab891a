"""A job, the files that are attached to it, and what becomes of its failed evaluations."""

from __future__ import annotations

from datetime import datetime
from typing import Any

from geoswarm.records.record import Number, described, record
from geoswarm.records.states import ENDED_STATES, JobState
from geoswarm.records.statistics import FitKind, SeriesShare

__all__ = ["Attachment", "Event", "Generation", "Job", "Retry", "SearchBest"]


@record
class SearchBest:
    """The best evaluation of a search, before the runs that followed it."""

    objective: float
    parameters: dict[str, float] = described("all parameters")


@record
class Job:
    """A submitted problem and its progress; ``objective`` and ``parameters`` are the best so far."""

    id: str
    name: str
    state: JobState
    forward_model: str
    method: str
    stop_reasons: list[str] = described("every stop criterion that was satisfied at the end")
    objective: Number = described("lowest objective f so far; null before the first success")
    parameters: dict[str, float] | None = described("all parameters (free, fixed, linked) at that objective")
    at_bounds: dict[str, str] | None = described(
        "free parameters that lie at a bound of their range: 'lower' or 'upper'", default=None
    )
    intervals: dict[str, tuple[float, float] | None] | None = described(
        "95 % intervals of the free parameters, where a search ended with them; null for one without an interval",
        default=None,
    )
    verdicts: dict[str, str] | None = described(
        "kinds of the verdicts on the free parameters then; statistics have the sentences, and what follow-ups add",
        default=None,
    )
    verdict_words: dict[str, str] | None = described("the same in words, as every page shows them", default=None)
    fit: FitKind | None = described("kind of the verdict on the fit then", default=None)
    shares: list[SeriesShare] | None = described(
        "root mean square of each series then, and its share in the objective",
        default=None,
    )
    search_best: SearchBest | None = described("best of the search alone, where further runs followed it", default=None)
    evaluations: int = described("counted in finished generations")
    search_evaluations: int | None = described("of the search, once it has ended and its answer follows", default=None)
    answer_evaluations: int | None = described("upper bound of the evaluations after the search", default=None)
    generations: int
    failed_evaluations: int
    created_at: datetime
    started_at: datetime | None
    finished_at: datetime | None
    seconds: float | None = described("running time so far")
    error: str | None = described("why the job failed")
    seed: int
    free_parameters: list[str]
    max_evaluations: int | None = described("planned number of evaluations, when there is one")
    priority: int
    retrying: bool = described("its failed evaluations are being rerun; then it returns to its previous state")
    owner: str | None = described("owner of the key that submitted it; null: no key, or that of the environment")
    parent: str | None = described("id of the job whose follow-up it is; null: of none, or it is deleted", default=None)
    tags: list[str] = described("words to find it by, sorted", default_factory=list)
    note: str | None = described(
        "what somebody wrote about it, in Markdown; null: nobody did, or in lists", default=None
    )
    last_event: int = described("id of its newest event: follow the events after it")
    trend: list[Number] | None = described(
        "lowest objective so far at evenly spaced generations; only in lists, on request", default=None
    )
    versions: dict[str, str] | None = described(
        "versions of geoswarm, python and the packages that calculate, at its start; null: not started, or not recorded"
    )
    warnings: list[str] = described(
        "one objective in all runs; other versions that were used; what it waits for, if there is no room"
    )

    @property
    def ended(self) -> bool:
        """Whether the job is finished, failed or cancelled."""
        return self.state in ENDED_STATES

    def _repr_html_(self) -> str:
        """Show the job in a notebook."""
        from geoswarm.solver.progress.notebook import result_html

        facts = {
            "id": self.id,
            "state": self.state if self.error is None else f"{self.state}: {self.error}",
            "objective": "-" if self.objective is None else f"{self.objective:.6g}",
            "evaluations": f"{self.evaluations} in {self.generations} generations, {self.failed_evaluations} failed",
            "stopped by": ", ".join(self.stop_reasons),
            "seed": str(self.seed),
        }
        known = self.parameters or {}
        remarks = {name: "" if name in self.free_parameters else "fixed or linked" for name in known}
        return result_html(self.name, facts, self.parameters, remarks)


@record
class Retry:
    """Failed evaluations that are rerun."""

    evaluations: int = described("their number")
    job: Job


@record
class Event:
    """Something that happened to a job; ids grow with time, so that a reader can continue after the last one seen."""

    id: int
    kind: str = described("state, generation or kernels")
    data: dict[str, Any]

    @property
    def ends_job(self) -> bool:
        """Whether the job has ended with this event."""
        return self.kind == "state" and self.data.get("state") in ENDED_STATES


@record
class Generation:
    """One finished generation."""

    number: int
    evaluations: int = described("total so far")
    failed: int = described("failed evaluations so far")
    best_objective: Number = described("lowest objective inside this generation")
    objective: Number = described("lowest objective so far")
    parameters: dict[str, float] | None = described("parameters of the lowest objective so far")
    created_at: datetime
    finished_at: datetime
    diversity: float | None = described(
        "scatter of the particles: near 1 all over the space, 0 at one point; null: not requested"
    )


@record
class Attachment:
    """A file that is attached to a job, without its content."""

    sha256: str = described("SHA-256 of the content; the file's address")
    name: str
    media_type: str = described("what it is by its content")
    size: int = described("bytes")
    created_at: datetime = described("when it was attached")
