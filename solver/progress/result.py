"""What a calibration in this process returns: its evaluations, generations and best parameters."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.answer import Answer
from geoswarm.solver.progress.notebook import result_html
from geoswarm.solver.progress.state import Best, Progress
from geoswarm.solver.progress.stopping import fails_always

__all__ = [
    "CalibrationResult",
    "EvaluationRecord",
    "GenerationRecord",
    "alike_warning",
    "count_alike",
    "generation_record",
    "no_success_message",
]

_TELLING = 5
"""This number of runs with one objective is no coincidence."""


@dataclass(frozen=True, slots=True)
class EvaluationRecord:
    """One evaluation with its place in the history."""

    generation: int
    particle: int
    evaluation: Evaluation


@dataclass(frozen=True, slots=True)
class GenerationRecord:
    """One finished generation.

    Parameters
    ----------
    number
        Counted from 0.
    evaluations, failed
        Totals so far.
    best_objective
        Best of this generation; None when all its evaluations failed.
    objective, parameters
        Best so far and all its parameter values by name; None while no evaluation has succeeded.
    search_evaluations, answer_evaluations
        Evaluations of the search, and how many may follow it; None while it goes on, and of runs that are read again.
    alike
        Number of runs since the start if all of them gave one objective, else -1.
    """

    number: int
    evaluations: int
    failed: int
    best_objective: float | None
    objective: float | None
    parameters: dict[str, float] | None
    search_evaluations: int | None = field(default=None, compare=False)
    answer_evaluations: int | None = field(default=None, compare=False)
    alike: int = field(default=-1, compare=False)


@dataclass(frozen=True, slots=True)
class CalibrationResult:
    """Outcome of a calibration with its whole history.

    ``state`` is ``failed`` when no evaluation succeeded; ``error`` then counts the reasons. It is ``running`` when more
    runs follow: after the search, those of its answer. ``answer``: where the runs after the search began, if there were
    any; their evaluations are in the history.
    """

    state: Literal["running", "finished", "failed"]
    stop_reasons: tuple[str, ...]
    objective: float | None
    parameters: dict[str, float] | None
    best: Evaluation | None
    best_generation: int | None
    best_particle: int | None
    evaluations: int
    failed_evaluations: int
    generations: int
    seconds: float
    seed: int
    error: str | None
    history: list[EvaluationRecord] = field(repr=False)
    generation_records: list[GenerationRecord] = field(repr=False)
    answer: Answer | None = field(default=None, repr=False)

    def _repr_html_(self) -> str:
        """Show the result in a notebook."""
        facts = {
            "state": self.state if self.error is None else f"{self.state}: {self.error}",
            "objective": "-" if self.objective is None else f"{self.objective:.6g}",
            "evaluations": f"{self.evaluations} in {self.generations} generations, {self.failed_evaluations} failed",
            "stopped by": ", ".join(self.stop_reasons),
            "time": f"{self.seconds:.3g} s",
            "seed": str(self.seed),
        }
        return result_html("Calibration", facts, self.parameters, {})


def generation_record(
    problem: Problem, number: int, objectives: Sequence[float | None], after: Progress, alike: int = -1
) -> GenerationRecord:
    """Summarise a finished generation from its objectives and the progress after it."""
    best, answer = after.best, after.answer
    return GenerationRecord(
        number=number,
        evaluations=after.evaluations,
        failed=after.failed,
        best_objective=min((f for f in objectives if f is not None), default=None),
        objective=best.objective if best else None,
        parameters=problem.values(best.parameters.tolist()) if best else None,
        search_evaluations=answer.evaluations if answer else None,
        answer_evaluations=answer.most if answer else None,
        alike=alike,
    )


def count_alike(before: int, best: Best | None, objectives: Sequence[float | None]) -> int:
    """Return how many runs since the start gave one objective, -1 as soon as two differ.

    Parameters
    ----------
    before, best
        Count and best run before this generation.
    """
    found = [f for f in objectives if f is not None]
    different = len({*found, *([] if best is None else [best.objective])}) > 1
    return -1 if before < 0 or different else before + len(found)


def alike_warning(alike: int) -> str | None:
    """Warn of a forward model whose responses do not depend on its parameters."""
    if alike < _TELLING:
        return None
    return (
        f"all {alike} runs so far gave the same objective, though their parameters differ: the forward model does not "
        "use them. Check that the program reads the files that are written for each run, not those of an earlier one"
    )


def no_success_message(reasons: Counter[str], first_message: str | None) -> str:
    """Say why a calibration without one successful evaluation failed, with the reasons counted."""
    counts = ", ".join(f"{count} {reason.replace('_', ' ')}" for reason, count in sorted(reasons.items()))
    message = f"all {reasons.total()} evaluations failed ({counts})"
    if fails_always(reasons, reasons.total()):
        message += ", which ends the search: the forward model fails whatever the parameters are"
    return f"{message}; first message: {first_message}" if first_message else message
