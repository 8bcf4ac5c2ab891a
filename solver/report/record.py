"""What a report is made from, wherever the run was: in this process, in a service, or in a folder of files."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult, GenerationRecord
from geoswarm.solver.system.versions import versions

__all__ = ["BestFit", "RunRecord", "environment", "record_of_result"]


@dataclass(frozen=True, slots=True)
class BestFit:
    """The best evaluation: its place, objective, all parameters by name, misfits, responses at the observed points."""

    generation: int
    particle: int
    objective: float
    parameters: dict[str, float]
    misfits: dict[str, float]
    responses: dict[str, FloatArray]


@dataclass(frozen=True, slots=True)
class RunRecord:
    """One run as a report describes it.

    Parameters
    ----------
    id
        Of the job in a service; None for a run in process.
    state
        ``running``, ``paused``, ``finished``, ``failed`` or ``cancelled``.
    evaluations, failed, generations
        Counted over finished generations.
    failures
        Number of failed evaluations by reason.
    seconds
        Running time [s].
    best
        None while no evaluation has succeeded.
    records
        Finished generations in order.
    versions
        What the run was calculated under (:func:`geoswarm.solver.system.versions.versions`); None: not recorded.
    warnings
        What to know about the versions, or about runs that are missing, one sentence each.
    environment
        Names and versions of what made the report.
    """

    id: str | None
    state: str
    stop_reasons: tuple[str, ...]
    error: str | None
    evaluations: int
    failed: int
    generations: int
    failures: Mapping[str, int]
    seconds: float | None
    seed: int
    best: BestFit | None
    records: Sequence[GenerationRecord]
    finished_at: datetime | None = None
    versions: Mapping[str, str] | None = None
    warnings: Sequence[str] = ()
    environment: Mapping[str, str] = field(default_factory=lambda: environment())


def record_of_result(problem: Problem, result: CalibrationResult) -> RunRecord:
    """Tell of a run in this process."""
    best = None
    if result.best is not None and result.parameters is not None and result.objective is not None:
        best = BestFit(
            result.best_generation or 0,
            result.best_particle or 0,
            result.objective,
            problem.values(result.best.parameters.tolist()),
            dict(result.best.misfits),
            dict(result.best.responses),
        )
    failures = Counter(r.evaluation.reason for r in result.history if r.evaluation.reason is not None)
    return RunRecord(
        id=None,
        state=result.state,
        stop_reasons=result.stop_reasons,
        error=result.error,
        evaluations=result.evaluations,
        failed=result.failed_evaluations,
        generations=result.generations,
        failures=dict(failures),
        seconds=result.seconds,
        seed=result.seed,
        best=best,
        records=result.generation_records,
        finished_at=datetime.now(UTC),
        versions=versions(),
    )


def environment() -> dict[str, str]:
    """Return the versions of this process, with those of what draws."""
    try:
        return {**versions(), "matplotlib": version("matplotlib")}
    except PackageNotFoundError:
        return dict(versions())


def method_in_words(problem: Problem) -> str:
    """Return the search method in a few words."""
    return problem.method.in_words()
