"""The in-process calibration loop: the reference that the distributed engine must equal bit for bit."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import replace

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation, WarmStartRuns, choose_seed
from geoswarm.solver.course import Course
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.methods.widths import Situation
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.running import fatal_message
from geoswarm.solver.progress.result import (
    CalibrationResult,
    EvaluationRecord,
    GenerationRecord,
    count_alike,
    generation_record,
    no_success_message,
)
from geoswarm.solver.progress.state import Progress
from geoswarm.solver.runs.evaluators import evaluator
from geoswarm.solver.runs.journal import Keeper, Stored
from geoswarm.solver.runs.runlog import RunKey, RunLog
from geoswarm.solver.runs.under_way import UnderWay
from geoswarm.solver.warm import compile_kernels

__all__ = ["calibrate", "result_so_far"]


def calibrate(
    problem: Problem,
    *,
    workers: int = 1,
    seed: int | None = None,
    on_generation: Callable[[GenerationRecord], None] | None = None,
    on_search_end: Callable[[CalibrationResult], None] | None = None,
    offer: WarmStartRuns | None = None,
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
    on_search_end
        Called with what a search has found before the runs after it begin; the time that this takes does not count.
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
    course = Course(calibration)
    history: list[EvaluationRecord] = []
    records: list[GenerationRecord] = []
    log, responses = RunLog(calibration), list[list[dict[str, FloatArray]]]()
    failures, alike = Counter[str](), 0

    def fetch(keys: Sequence[RunKey]) -> list[dict[str, FloatArray]]:
        return [responses[generation][particle] for generation, particle in keys]

    compile_kernels(problem)  # no part of the search, nor of its time
    keeper = keeper or Keeper()
    began = time.monotonic() - keeper.seconds

    def finished(position: FloatArray, evaluation: Evaluation) -> None:
        keeper.finished(position, evaluation, time.monotonic() - began)

    slots = problem.forward_model.at_once(workers)
    progress = keeper.start(course, situations(Situation(slots), -1).slots)
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
            failures.update(e.reason for e in evaluations if e.reason is not None)
            if problem.method.learns or problem.answers:
                log.add([e.parameters for e in evaluations], objectives)
                responses.append([e.responses for e in evaluations])
            step, seconds = keeper.known_step(progress.generation), time.monotonic() - began
            if step is None:
                runs = log.runs(fetch) if course.learns(progress) else None
                situation = situations(Situation(slots, [e.seconds for e in evaluations]), progress.generation)
                step = course.advance(progress, objectives, seconds, runs, situation=situation, failures=failures)
            keeper.closed(progress.generation, evaluations, step, seconds)
            alike = count_alike(alike, progress.best, objectives)
            records.append(generation_record(problem, progress.generation, objectives, step.progress, alike))
            if on_generation is not None:
                on_generation(records[-1])
            if step.stop_reasons:
                break
            if progress.answer is None and step.progress.answer is not None:
                under_way.drop(step.progress.generation)
                if on_search_end is not None and keeper.known_step(step.progress.generation) is None:
                    ended = time.monotonic()
                    on_search_end(_result(problem, seed, step.progress, (), history, records, ended - began))
                    began += time.monotonic() - ended
            progress = step.progress
    return _result(problem, seed, step.progress, step.stop_reasons, history, records, time.monotonic() - began)


def result_so_far(problem: Problem, stored: Stored) -> CalibrationResult | None:
    """Return what the whole generations in a journal give; None when there are none.

    Parameters
    ----------
    problem
        That of the journal.
    """
    history: list[EvaluationRecord] = []
    records: list[GenerationRecord] = []
    progress, step = stored.start, None
    while progress is not None and (after := stored.steps.get(progress.generation)) is not None:
        step = after
        evaluations = [stored.evaluations[position.tobytes()] for position in progress.positions]
        history += [EvaluationRecord(progress.generation, i, e) for i, e in enumerate(evaluations)]
        objectives = [e.objective for e in evaluations]
        records.append(generation_record(problem, progress.generation, objectives, step.progress))
        progress = step.progress
    if step is None:
        return None
    return _result(problem, stored.run.seed, step.progress, step.stop_reasons, history, records, stored.seconds)


def _fatal(problem: Problem, generation: int, evaluations: Sequence[Evaluation]) -> str | None:
    """Say which failure ends the calibration, None: none does."""
    for particle, evaluation in enumerate(evaluations):
        if evaluation.reason is not None and problem.failures.ends_job(evaluation.reason):
            return fatal_message(generation, particle, evaluation.reason, evaluation.message)
    return None


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
    serves = best is not None or any(r.evaluation.responses for r in history)  # a prediction keeps parts of failed runs
    if not serves:
        reasons = Counter(r.evaluation.reason for r in history if r.evaluation.reason is not None)
        error = no_success_message(reasons, history[0].evaluation.message)
    found = next(
        (r.evaluation for r in history if best and (r.generation, r.particle) == (best.generation, best.particle)), None
    )
    return CalibrationResult(
        state=("finished" if stop_reasons else "running") if serves else "failed",
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
