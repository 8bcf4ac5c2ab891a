"""What a calibration has found."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from geoswarm.calibration.folder import opened_folder, write_folder
from geoswarm.calibration.outlook import Predicted, design, predict
from geoswarm.calibration.runs import Runs
from geoswarm.solver.errors import SolverError
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult, EvaluationRecord, GenerationRecord
from geoswarm.solver.system.extras import has, needs_extra

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from geoswarm.solver.calibration import Evaluation
    from geoswarm.solver.identifiability import Statistics
    from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests
    from geoswarm.solver.identifiability.worth.outcome import Design
    from geoswarm.solver.report.document.build import Report

__all__ = ["Result", "jackknife", "lacking_for_reports"]


class Result:
    """Outcome of a calibration with its whole history.

    Parameters
    ----------
    problem
        The calibrated problem.
    found
        The outcome.

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
    >>> result.stop_reasons, result.evaluations <= 100
    (('max_evaluations',), True)
    >>> print(f"{result.objective:.3f}")
    0.008
    >>> result.statistics().fit.kind
    'describes'
    """

    def __init__(self, problem: Problem, found: CalibrationResult) -> None:
        self.problem = problem
        self.found = found
        """The outcome as the solver gives it."""

    @property
    def parameters(self) -> dict[str, float]:
        """The best values of all parameters by name, fixed and linked ones included.

        Raises
        ------
        SolverError
            No forward run succeeded; the message says why.
        """
        if self.found.parameters is None:
            raise self._nothing()
        return dict(self.found.parameters)

    @property
    def objective(self) -> float:
        """The lowest objective, in base units squared; raises SolverError where no forward run succeeded."""
        if self.found.objective is None:
            raise self._nothing()
        return self.found.objective

    @property
    def best(self) -> Evaluation:
        """The best evaluation: ``responses`` and ``misfits`` by series; raises SolverError where there is none."""
        if self.found.best is None:
            raise self._nothing()
        return self.found.best

    @cached_property
    def runs(self) -> Runs:
        """Every evaluation: columns as arrays."""
        return Runs(self.problem, self.found)

    @property
    def state(self) -> Literal["finished", "failed"]:
        """``finished``, or ``failed`` if no evaluation succeeded or a failure ended the calibration (``failures``)."""
        return "failed" if self.found.state == "failed" else "finished"

    @property
    def error(self) -> str | None:
        """Why it failed; None if it did not."""
        return self.found.error

    @property
    def stop_reasons(self) -> tuple[str, ...]:
        """The criteria that ended it."""
        return self.found.stop_reasons

    @property
    def evaluations(self) -> int:
        """Number of evaluations, without a generation whose failure ended the calibration (``failures``)."""
        return self.found.evaluations

    @property
    def failed_evaluations(self) -> int:
        """Number of failed evaluations."""
        return self.found.failed_evaluations

    @property
    def generations(self) -> int:
        """Number of generations."""
        return self.found.generations

    @property
    def seconds(self) -> float:
        """Wall time [s]."""
        return self.found.seconds

    @property
    def seed(self) -> int:
        """Seed of all random numbers."""
        return self.found.seed

    @property
    def history(self) -> list[EvaluationRecord]:
        """Every evaluation as a record."""
        return self.found.history

    @property
    def generation_records(self) -> list[GenerationRecord]:
        """Every generation as a record."""
        return self.found.generation_records

    @cached_property
    def _report(self) -> Report:
        from geoswarm.solver.report.document.build import report_of_result

        return report_of_result(self.problem, self.found)

    def statistics(self, *, threshold: float | None = None) -> Statistics:
        """Show what the data say about each parameter: verdicts, correlations, intervals (``docs/statistics.md``).

        The same as ``geoswarm statistics DIR``: no further runs.

        Parameters
        ----------
        threshold
            Objective up to which a fit counts as good; proposed if None.

        Raises
        ------
        SolverError
            No forward run succeeded, or the threshold is wrong.
        """
        if threshold is not None and (isinstance(threshold, bool) or not isinstance(threshold, Real)):
            raise TypeError(f"threshold must be above 0, in base units squared; got {threshold!r}")
        report = self._report if threshold is None else self._report.with_threshold(threshold)
        if report.statistics is None:
            raise self._nothing()
        return report.statistics

    def predict(
        self,
        problem: Problem | Mapping[str, Any] | str | Path,
        *,
        runs: int = 200,
        level: float = 0.9,
        noise: Mapping[str, float] | float | None = None,
        source: Literal["auto", "posterior", "covariance"] = "auto",
        workers: int = 1,
    ) -> Predicted:
        """Predict another problem with the identified parameters and their uncertainty (``docs/prediction.md``).

        Parameters
        ----------
        problem
            A problem, a mapping with its sections, or a problem file. Its free or omitted parameters are taken from
            this result by name; its observations say where the series are wanted: ``points: {x: [..]}`` is enough.
        runs
            Number of forward runs of that problem.
        level
            Probability of the band at each x.
        noise
            Known standard deviation of a reading of this calibration, base units, one for all series or one each.
        source
            Where the parameters are drawn from; ``auto``: the covariance at the optimum, and a trusted posterior sample
            where the model is nonlinear.
        workers
            Number of processes that share the runs.

        Raises
        ------
        ProblemError
            Lists every mistake in ``problem``.
        SolverError
            There are no sensitivities at an optimum: the runs after the search did not suffice, or it had none; the
            error of a reading is not known; or too few runs succeed.
        """
        report = self._with_noise(noise)
        return predict(report, problem, runs=runs, level=level, noise=noise, source=source, workers=workers)

    def design(
        self,
        candidates: Mapping[str, Any] | str | Path,
        *,
        predict: Problem | Mapping[str, Any] | str | Path | None = None,
        criterion: Literal["widths", "volume", "prediction"] | None = None,
        draws: int = 8,
        noise: Mapping[str, float] | float | None = None,
        workers: int = 1,
    ) -> Design:
        """Rank candidate tests by how much they would narrow the intervals or a prediction (``docs/prediction.md``).

        Parameters
        ----------
        candidates
            ``{"candidates": [{"name": .., "observations": [{"series": .., "points": {"x": [..]}, "error": ..}]}, ..]}``
            with a ``forward_model`` where it is not that of this result; or a file of them.
        predict
            A problem whose prediction is to become narrower, as for :meth:`predict`.
        criterion
            How to rank them: by ``widths`` of all intervals, ``volume`` of their common region, or ``prediction``.
        draws
            Number of points around the optima over which the worth is averaged.
        noise
            Known standard deviation of a reading of this calibration, base units.

        Returns
        -------
        ``candidates``, the best first, each with ``name``, ``parameters`` (expected reduction of each interval, parts
        of its width), ``widths``, ``volume`` and ``prediction``.

        Raises
        ------
        ProblemError, SolverError
            As :meth:`predict`.
        """
        report = self._with_noise(noise)
        return design(
            report, candidates, predicted=predict, criterion=criterion, draws=draws, noise=noise, workers=workers
        )

    def jackknife(self, *, runs: int | None = None, workers: int = 1) -> WithoutTests:
        """Fit the parameters again without each test of a combined problem with three tests or more.

        Parameters
        ----------
        runs
            Forward runs at most, which all fits share; 1 + 6 (parameters + tests) when None.
        workers
            Number of processes that share the runs.

        Returns
        -------
        ``tests``; ``names`` of the parameters; ``values`` without each test, shape (tests, parameters), and
        ``intervals`` between the tests, shape (parameters, 2), natural values, nan where the other tests do not
        determine a parameter; ``pulling(name)``: the test without which a parameter moves farthest; ``notes``.

        Raises
        ------
        SolverError
            There are fewer than three tests, or no sensitivities at an optimum.
        """
        return jackknife(self._report, runs=runs, workers=workers)

    def _with_noise(self, noise: Mapping[str, float] | float | None) -> Report:
        if noise is None:
            return self._report
        from geoswarm.solver.report.document.build import report_of_result

        return report_of_result(self.problem, self.found, noise=noise)

    def report(self, folder: str | Path) -> list[Path]:
        """Write report, figures and tables into a folder, as ``geoswarm run --output``; return the files.

        Raises
        ------
        ImportError
            The packages that draw and typeset are not installed.
        SolverError
            The folder cannot be written, or holds an interrupted run.
        """
        lacking = lacking_for_reports()
        if lacking is not None:
            raise ImportError(lacking)
        report = self._report
        opened = opened_folder(Path(folder), self.problem, seed=self.seed)
        try:
            return write_folder(opened, self.found, report)
        finally:
            opened.complete()  # whatever happened: there is no run to go on with

    def plot(self, axes: Axes | Iterable[Axes] | None = None) -> list[Axes]:
        """Draw measured and calculated values of each series, in the units of the observation.

        Parameters
        ----------
        axes
            Matplotlib axes, one for each series; None for a new figure.

        Returns
        -------
        The axes, one a series.
        """
        from geoswarm.calibration.plot import plot_curves
        from geoswarm.solver.report.curves import series_curves

        return plot_curves(series_curves(self.problem, self.best.responses, self.parameters), axes)

    def _nothing(self) -> SolverError:
        return SolverError(self.found.error or "no forward run succeeded")

    def _repr_html_(self) -> str:
        """Show the result in a notebook."""
        return self.found._repr_html_()

    def __repr__(self) -> str:
        found = self.found
        if found.parameters is None or found.error is not None:
            return f"<Result {self.state}: {found.error}>"
        values = ", ".join(f"{name} = {value:.6g}" for name, value in found.parameters.items())
        stopped = ", ".join(found.stop_reasons) or self.state
        return f"<Result {stopped}: objective {found.objective:.6g} at {values}; {found.evaluations} evaluations>"


def lacking_for_reports() -> str | None:
    """What is not installed that reports need, and how to get it; None: everything is there."""
    missing = next((module for module in ("matplotlib", "jinja2", "reportlab") if not has(module)), None)
    return None if missing is None else needs_extra("a report", missing)


def jackknife(report: Report, *, runs: int | None, workers: int) -> WithoutTests:
    """Fit the parameters without each test; see :meth:`geoswarm.Result.jackknife`."""
    from geoswarm.solver.identifiability.stored.findings import findings_of
    from geoswarm.solver.identifiability.stored.follow_ups import jackknife_problem
    from geoswarm.solver.runs.local import calibrate

    found = None if report.statistics is None else report.statistics.linearisation
    question = jackknife_problem(report.problem, found, seed=report.record.seed, runs=runs)
    result = calibrate(question, workers=workers)
    findings = findings_of(question, result.seed, [record.evaluation for record in result.history])
    if findings.jackknife is None:
        raise SolverError("; ".join(findings.notes))
    return findings.jackknife
