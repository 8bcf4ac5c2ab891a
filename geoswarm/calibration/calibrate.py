"""Runs a calibration from Python."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from geoswarm.calibration.folder import opened_folder, write_folder
from geoswarm.calibration.functions import InProcessWarning, refuse_while_imported, warn_in_process
from geoswarm.calibration.problems import Model, Observations, options_of, problem_of
from geoswarm.calibration.result import Result, lacking_for_reports
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.course import Course
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.external.python.loading import NOT_IMPORTED
from geoswarm.solver.plausibility import require_possible
from geoswarm.solver.problem import Problem
from geoswarm.solver.problem.running import Limits
from geoswarm.solver.progress.result import CalibrationResult, GenerationRecord
from geoswarm.solver.progress.state import Progress, Step
from geoswarm.solver.runs.evaluators import WATCHED
from geoswarm.solver.runs.journal import Keeper
from geoswarm.solver.runs.local import calibrate as calibrate_problem

if TYPE_CHECKING:
    from geoswarm.solver.report.folder.run_folder import RunFolder

__all__ = ["calibrate"]


def calibrate(
    model: Model,
    *,
    parameters: Mapping[str, Any] | None = None,
    observations: Observations | None = None,
    constraints: Sequence[str] | None = None,
    series: Mapping[str, Any] | None = None,
    method: Mapping[str, Any] | None = None,
    stopping: Mapping[str, Any] | None = None,
    limits: Mapping[str, Any] | None = None,
    failures: Mapping[str, Any] | None = None,
    answer: Mapping[str, Any] | None = None,
    weighting: str | None = None,
    noise: Mapping[str, Any] | None = None,
    quick_runs: bool | None = None,
    seed: int | None = None,
    name: str | None = None,
    workers: int = 1,
    output: str | Path | None = None,
    resume: bool = False,
    on_generation: Callable[[GenerationRecord], None] | None = None,
) -> Result:
    """Find the parameters with which a function or a problem fits the measurements best.

    Each argument from ``parameters`` to ``name`` is a section of the problem file (``docs/problem-file.md``) with the
    same meaning; given with a problem, it replaces the problem's own section. The same sections and seed give the same
    history as ``geoswarm run``, for any number of workers.

    Parameters
    ----------
    model
        A function, a problem (:func:`geoswarm.load_problem`), or a mapping with the sections of one. The arguments of a
        function are its parameters; one called ``x`` receives the observed points. It returns an array with a value for
        each observed point, or ``{series: array}``, or ``{series: (x, y)}``, which is interpolated.
    parameters
        By name: :func:`geoswarm.free`, :func:`geoswarm.fixed` or :func:`geoswarm.linked`.
    observations
        One :func:`geoswarm.observed`, or one for each series by name.
    constraints
        Comparisons that every proposal must satisfy, such as ``"E > 100 * k"``.
    series
        By name :func:`geoswarm.series`: units of a function where they are not those of its observations.
    method
        How to search; ``{"kind": "particle_swarm"}`` if None.
    stopping
        When to stop. If None, a function uses :data:`geoswarm.DEFAULT_STOPPING` and a problem its own criteria.
    limits, failures
        What one evaluation may use, and what happens when one fails.
    answer
        How many runs may follow the search, for the minimum and intervals there: ``{"max_evaluations": 50}``.
    noise
        What is known of the errors of the readings: ``{"kind": "white"}`` or ``{"kind": "correlated"}``.
    weighting, seed, name
        Weighting scheme; seed of all random numbers (chosen and reported if None); name of the calibration.
    quick_runs
        True if runs of the function are so short that up to 200 may follow a short search, for the minimum and
        intervals there.
    workers
        Number of processes that share the evaluations.
    output
        Folder for report, figures, tables and, during the run, every finished evaluation, as ``geoswarm run --output``.
    resume
        Continue the interrupted run in ``output`` to the same result; start a new one if there is none.
    on_generation
        Called after every generation.

    Raises
    ------
    ProblemError
        Lists every mistake with its path; also when the file of a function cannot be imported, or no soil can have the
        readings of a laboratory test and ``accept`` of the problem does not name their series.
    SolverError
        No feasible proposal is found, a folder cannot be used, or worker processes cannot be started.

    Warns
    -----
    InProcessWarning
        The function can be called only in this process (a lambda, a nested function, one of a notebook, one of a script
        without main guard), with one worker and without limits. Also where limits do not apply on this system.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def line(x, a, b):
    ...     return a + b * x
    >>> result = gs.calibrate(
    ...     line,
    ...     parameters={"a": gs.free(0, 10), "b": gs.free(0, 10)},
    ...     observations=gs.observed([0, 1, 2, 3], [1.1, 2.9, 5.1, 6.9], error=0.1),
    ...     stopping={"max_evaluations": 100},
    ...     seed=1,
    ... )
    >>> print(f"a = {result.parameters['a']:.2f}, b = {result.parameters['b']:.2f}")
    a = 1.06, b = 1.96
    """
    refuse_while_imported("geoswarm.calibrate")
    if isinstance(workers, bool) or not isinstance(workers, int) or workers < 1:
        raise ValueError(f"workers must be a whole number from 1, got {workers!r}")
    if resume and output is None:
        raise ValueError("resume=True needs output, the folder of the interrupted run")
    options = options_of(
        parameters=parameters,
        observations=observations,
        constraints=constraints,
        series=series,
        method=method,
        stopping=stopping,
        limits=limits,
        failures=failures,
        answer=answer,
        weighting=weighting,
        noise=noise,
        quick_runs=quick_runs,
        seed=seed,
        name=name,
    )
    problem, reason = problem_of(model, options)
    require_possible(problem)
    workers = _told(problem, reason, workers)
    folder = None if output is None else opened_folder(Path(output), problem, resume=resume)
    run_seed = None if folder is None else folder.run.seed
    keeper = _Importable(folder or Keeper())

    def on_search_end(found: CalibrationResult) -> None:
        if folder is not None:
            folder.search_ended(found, figures=lacking_for_reports() is None)

    with _closing(folder):
        found = calibrate_problem(
            problem,
            workers=workers,
            seed=run_seed,
            on_generation=on_generation,
            on_search_end=on_search_end,
            keeper=keeper,
        )
        result = Result(problem, found)
        if folder is not None:
            _write(folder, result)
    return result


def _told(problem: Problem, reason: str | None, workers: int) -> int:
    """Number of workers there can be; what does not hold is warned of."""
    limited = problem.limits != Limits()
    if problem.forward_model.only_here:
        lost = "It runs with one worker and without limits."
        called = getattr(problem.forward_model, "function", "the function")
        warn_in_process(called, reason or "belongs to this Python session", lost=lost)
        return 1
    if limited and not WATCHED:
        message = "limits apply on Linux only: on this system, press Ctrl-C to stop a run that hangs"
        warnings.warn(message, InProcessWarning, stacklevel=3)
    return workers


@contextmanager
def _closing(folder: RunFolder | None) -> Iterator[None]:
    try:
        yield
    finally:
        if folder is not None:
            folder.close()


def _write(folder: RunFolder, result: Result) -> None:
    """Write what ``geoswarm run --output`` writes."""
    lacking = lacking_for_reports()
    if lacking is not None:
        warnings.warn(f"tables only, no report and no figures: {lacking}", UserWarning, stacklevel=3)
    write_folder(folder, result.found, result._report if lacking is None else None)
    folder.complete()


class _Importable(Keeper):
    """Ends a calibration at the first evaluation that finds that its file cannot be imported: none could succeed."""

    def __init__(self, inner: Keeper) -> None:
        self._inner = inner
        self.seconds = inner.seconds

    def start(self, course: Course, slots: int) -> Progress:
        return self._inner.start(course, slots)

    def recall(self, position: FloatArray) -> Evaluation | None:
        return self._inner.recall(position)

    def finished(self, position: FloatArray, evaluation: Evaluation, seconds: float) -> None:
        if evaluation.reason == "bad_output" and NOT_IMPORTED in (evaluation.message or ""):
            raise ProblemError([Issue("forward_model.file", evaluation.message or "")])
        self._inner.finished(position, evaluation, seconds)

    def known_step(self, generation: int) -> Step | None:
        return self._inner.known_step(generation)

    def closed(self, generation: int, evaluations: Sequence[Evaluation], step: Step, seconds: float) -> None:
        self._inner.closed(generation, evaluations, step, seconds)
