"""The in-process calibration loop: the reference that the distributed engine must equal bit for bit."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

from geoswarm.solver.answer import Answer
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation, Offer, Progress, choose_seed
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.methods.widths import Situation
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.running import fatal_message
from geoswarm.solver.runs.evaluators import evaluator
from geoswarm.solver.runs.journal import Keeper
from geoswarm.solver.runs.notebook import result_html
from geoswarm.solver.runs.runlog import RunKey, RunLog
from geoswarm.solver.runs.under_way import UnderWay
from geoswarm.solver.warm import compile_kernels

__all__ = [
    "CalibrationResult",
    "EvaluationRecord",
    "GenerationRecord",
    "calibrate",
    "generation_record",
    "no_success_message",
]


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
    """

    number: int
    evaluations: int
    failed: int
    best_objective: float | None
    objective: float | None
    parameters: dict[str, float] | None


@dataclass(frozen=True, slots=True)
class CalibrationResult:
    """Outcome of a calibration with its whole history.

    ``state`` is ``failed`` when no evaluation succeeded; ``error`` then counts the reasons. ``answer``: where the runs
    after the search began, if there were any; their evaluations are in the history.
    """

    state: Literal["finished", "failed"]
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


def calibrate(
    problem: Problem,
    *,
    workers: int = 1,
    seed: int | None = None,
    on_generation: Callable[[GenerationRecord], None] | None = None,
    offer: Offer | None = None,
    keeper: Keeper | None = None,
    situations: Callable[[Situation, int], Situation] = lambda seen, _: seen,
) -> CalibrationResult:
    """Run a calibration to its end in this process.

    Parameters
    ----------
    problem
        What to calibrate.
    workers
        Number of processes that share a generation; 1 runs everything here. Changes nothing in the result, unless the
        problem leaves the number of particles to it (``auto``).
    seed
        Overrides the problem's seed; with neither a fresh one is chosen and reported.
    on_generation
        Called after every generation.
    offer
        Runs of earlier calibrations with the same forward model, for an accelerated search to learn from.
    keeper
        Keeps evaluations and generations as they finish, and knows those of an earlier part of this run.
    situations
        Given what is seen when a generation is closed, and its number (-1: before the first one), says what decides on
        the next one with ``particles: auto``, as where a history is repeated whose widths are known.

    Raises
    ------
    ProblemError
        When the problem names jobs to start from and no ``offer`` is given.
    InfeasibleSpaceError
        When no feasible proposal is found.
    WorkerLostError
        When a worker process dies.
    """
    if problem.warm_start and offer is None:
        raise ProblemError(
            [Issue("warm_start.jobs", "jobs are known to the service only; give their runs as an offer")]
        )
    seed = choose_seed(problem.seed if seed is None else seed)
    calibration = Calibration(problem, seed, offer)
    history: list[EvaluationRecord] = []
    records: list[GenerationRecord] = []
    log, responses = RunLog(calibration), list[list[dict[str, FloatArray]]]()

    def fetch(keys: Sequence[RunKey]) -> list[dict[str, FloatArray]]:
        return [responses[generation][particle] for generation, particle in keys]

    compile_kernels(problem)  # no part of the search, nor of its time
    keeper = keeper or Keeper()
    began = time.monotonic() - keeper.seconds

    def finished(position: FloatArray, evaluation: Evaluation) -> None:
        keeper.finished(position, evaluation, time.monotonic() - began)

    slots = problem.forward_model.at_once(workers)
    progress = keeper.start(calibration, situations(Situation(slots), -1).slots)
    with evaluator(calibration, workers, finished) as begin:
        under_way = UnderWay(begin, keeper)
        while True:
            under_way.begin(progress.generation, progress.positions)
            if progress.ahead is not None and progress.ahead_begun:
                under_way.begin(progress.generation + 1, progress.ahead)
            evaluations = under_way.results(progress.generation)
            history += [EvaluationRecord(progress.generation, i, e) for i, e in enumerate(evaluations)]
            fatal = _fatal(problem, progress.generation, evaluations)
            if fatal is not None:
                result = _result(problem, seed, progress, (), history, records, time.monotonic() - began)
                return replace(result, state="failed", error=fatal)
            objectives = [e.objective for e in evaluations]
            if calibration.accelerated:
                log.add([e.parameters for e in evaluations], objectives)
                responses.append([e.responses for e in evaluations])
            step, seconds = keeper.known_step(progress.generation), time.monotonic() - began
            if step is None:
                runs = log.runs(fetch) if calibration.accelerated else None
                situation = situations(Situation(slots, [e.seconds for e in evaluations]), progress.generation)
                step = calibration.advance(progress, objectives, seconds, runs, situation=situation)
            keeper.closed(progress.generation, evaluations, step, seconds)
            records.append(generation_record(problem, progress.generation, objectives, step.progress))
            if on_generation is not None:
                on_generation(records[-1])
            if step.stop_reasons:
                break
            if progress.answer is None and step.progress.answer is not None:
                under_way.drop(step.progress.generation)
            progress = step.progress
    return _result(problem, seed, step.progress, step.stop_reasons, history, records, time.monotonic() - began)


def _fatal(problem: Problem, generation: int, evaluations: Sequence[Evaluation]) -> str | None:
    """Say which failure ends the calibration, None: none does."""
    for particle, evaluation in enumerate(evaluations):
        if evaluation.reason is not None and problem.failures.ends_job(evaluation.reason):
            return fatal_message(generation, particle, evaluation.reason, evaluation.message)
    return None


def generation_record(
    problem: Problem, number: int, objectives: Sequence[float | None], after: Progress
) -> GenerationRecord:
    """Summarise a finished generation from its objectives and the progress after it."""
    best = after.best
    return GenerationRecord(
        number=number,
        evaluations=after.evaluations,
        failed=after.failed,
        best_objective=min((f for f in objectives if f is not None), default=None),
        objective=best.objective if best else None,
        parameters=problem.values(best.parameters.tolist()) if best else None,
    )


def no_success_message(reasons: Counter[str], first_message: str | None) -> str:
    """Say why a calibration without one successful evaluation failed, with the reasons counted."""
    counts = ", ".join(f"{count} {reason}" for reason, count in sorted(reasons.items()))
    message = f"all {reasons.total()} evaluations failed ({counts})"
    return f"{message}; first message: {first_message}" if first_message else message


def _result(
    problem: Problem,
    seed: int,
    after: Progress,
    stop_reasons: tuple[str, ...],
    history: list[EvaluationRecord],
    records: list[GenerationRecord],
    seconds: float,
) -> CalibrationResult:
    best = after.best
    error = None
    if best is None:
        reasons = Counter(r.evaluation.reason for r in history if r.evaluation.reason is not None)
        error = no_success_message(reasons, history[0].evaluation.message)
    found = next(
        (r.evaluation for r in history if best and (r.generation, r.particle) == (best.generation, best.particle)), None
    )
    return CalibrationResult(
        state="finished" if best else "failed",
        stop_reasons=stop_reasons,
        objective=best.objective if best else None,
        parameters=problem.values(best.parameters.tolist()) if best else None,
        best=found,
        best_generation=best.generation if best else None,
        best_particle=best.particle if best else None,
        evaluations=after.evaluations,
        failed_evaluations=after.failed,
        generations=len(records),
        seconds=seconds,
        seed=seed,
        error=error,
        history=history,
        generation_records=records,
        answer=after.answer,
    )
