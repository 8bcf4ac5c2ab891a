"""What a calibration has found."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from numbers import Real
from pathlib import Path
from typing import TYPE_CHECKING, Literal

from geoswarm.calibration.folder import opened_folder, write_folder
from geoswarm.calibration.runs import Runs
from geoswarm.solver.errors import SolverError
from geoswarm.solver.problem import Problem
from geoswarm.solver.runs.local import CalibrationResult, EvaluationRecord, GenerationRecord
from geoswarm.solver.system.extras import has, needs_extra

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from geoswarm.solver.calibration import Evaluation
    from geoswarm.solver.identifiability import Statistics
    from geoswarm.solver.report.document.build import Report

__all__ = ["Result", "lacking_for_reports"]


class Result:
    """Outcome of a calibration with its whole history.

    Parameters
    ----------
    problem
        What was calibrated.
    found
        The outcome.
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
        """``failed`` when no evaluation succeeded, or one failed that ends the calibration (``failures``)."""
        return self.found.state

    @property
    def error(self) -> str | None:
        """Why it failed, None: it has not."""
        return self.found.error

    @property
    def stop_reasons(self) -> tuple[str, ...]:
        """The criteria that ended it."""
        return self.found.stop_reasons

    @property
    def evaluations(self) -> int:
        """Number of evaluations; without the generation whose failure has ended the calibration (``failures``)."""
        return self.found.evaluations

    @property
    def failed_evaluations(self) -> int:
        """Number of those that failed."""
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
        """What fixes all its random numbers."""
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
        """Tell what the data say about each parameter: verdicts, correlations, intervals (``docs/statistics.md``).

        The same as ``geoswarm statistics DIR``: no further run, unless the forward model is quick.

        Parameters
        ----------
        threshold
            Objective up to which a fit is good; proposed if None.

        Raises
        ------
        SolverError
            No forward run succeeded, or the threshold is wrong.
        """
        if threshold is not None and (isinstance(threshold, bool) or not isinstance(threshold, Real)):
            raise TypeError(f"threshold is {threshold!r}; a number above 0 is accepted, in base units squared")
        report = self._report if threshold is None else self._report.with_threshold(threshold)
        if report.statistics is None:
            raise self._nothing()
        return report.statistics

    def report(self, folder: str | Path) -> list[Path]:
        """Write report, figures and tables into a folder, as ``geoswarm run --output``; return the files.

        Raises
        ------
        ImportError
            What draws and sets is not installed.
        SolverError
            The folder cannot be written, or holds a run that was cut off.
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
            Of Matplotlib, one for each series; None: a new figure.

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
