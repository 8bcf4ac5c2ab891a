"""What comes next, from a calibration in this process: predictions, and the worth of further tests."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability.prediction.bands import PredictedSeries, Prediction
from geoswarm.solver.identifiability.worth.outcome import Design
from geoswarm.solver.problem import Problem
from geoswarm.solver.system.extras import has, needs_extra
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from geoswarm.solver.report.document.build import Report

__all__ = ["Predicted", "design", "predict"]


class Predicted:
    """A prediction: median and band of each series, in the units that its points were given in.

    Parameters
    ----------
    found
        As the solver gives it.
    """

    def __init__(self, found: Prediction) -> None:
        self.found = found

    def __getitem__(self, series: str) -> PredictedSeries:
        """The band of a series: ``x``, ``median``, ``lower``, ``upper``, each of shape (m,); KeyError names them."""
        return self.found[series]

    @property
    def series(self) -> tuple[str, ...]:
        """Names of the series."""
        return tuple(one.series for one in self.found.series)

    @property
    def level(self) -> float:
        """Probability of the band at each x."""
        return self.found.level

    @property
    def basins(self) -> tuple[tuple[float, dict[str, float]], ...]:
        """Share and optimum of each set of parameters that the data allow."""
        return tuple((basin.share, dict(basin.parameters)) for basin in self.found.basins)

    @property
    def alarm(self) -> str | None:
        """Why the band is unreliable; None if nothing is wrong."""
        return self.found.alarm

    @property
    def remarks(self) -> tuple[str, ...]:
        """What the band contains, and its caveats, in sentences."""
        return self.found.remarks

    def to_json(self) -> dict[str, Any]:
        """Plain JSON values, as ``geoswarm predict --json`` writes them."""
        return self.found.to_json()

    def plot(self, axes: Axes | Iterable[Axes] | None = None) -> Figure | list[Axes]:
        """Draw median and band.

        Parameters
        ----------
        axes
            Matplotlib axes, one for each series; None for the figure of the report.

        Returns
        -------
        The figure, or the axes.
        """
        if not has("matplotlib"):
            raise ImportError(needs_extra("a figure", "matplotlib"))
        from geoswarm.solver.report.figures.outlook.prediction_plot import prediction_figure

        if axes is None:
            return prediction_figure(self.found.name, self.found)
        chosen = list(axes) if isinstance(axes, Iterable) else [axes]
        if len(chosen) != len(self.found.series):
            raise ValueError(f"axes: {len(chosen)} are given, there are {len(self.found.series)} series")
        for one, place in zip(self.found.series, chosen, strict=True):
            place.fill_between(one.x, one.lower, one.upper, alpha=0.3, label=f"{per_cent(self.level)} band")
            place.plot(one.x, one.median, label="median")
            place.set_xlabel(f"{one.x_quantity} [{one.x_unit or '-'}]")
            place.set_ylabel(f"{one.y_quantity} [{one.y_unit or '-'}]")
        return chosen

    def __repr__(self) -> str:
        def band(one: PredictedSeries) -> str:
            ends: tuple[FloatArray, ...] = (one.median, one.lower, one.upper)
            middle, low, high = (float(np.asarray(values)[-1]) for values in ends)
            return f"{one.series} {middle:.6g} ({low:.6g} to {high:.6g})"

        told = ", ".join(band(one) for one in self.found.series)
        return f"<Predicted {per_cent(self.level)} at the last x: {told}{'; ' + self.alarm if self.alarm else ''}>"


def predict(
    report: Report,
    other: Problem | Mapping[str, Any] | str | Path,
    *,
    runs: int,
    level: float,
    noise: Mapping[str, float] | float | None,
    source: Literal["auto", "posterior", "covariance"],
    workers: int,
) -> Predicted:
    """Predict another problem with the identified parameters; see :meth:`geoswarm.Result.predict`."""
    from geoswarm.solver.calibration import Calibration
    from geoswarm.solver.identifiability.stored.findings import findings_of
    from geoswarm.solver.identifiability.stored.posterior import sample_posterior
    from geoswarm.solver.report.questions import prediction_question
    from geoswarm.solver.runs.local import calibrate

    calibration = Calibration(report.problem, report.record.seed)
    question = prediction_question(
        report,
        _document(other),
        runs=runs,
        level=level,
        noise=noise,
        source=source,
        posterior=lambda: sample_posterior(calibration, report.samples, noise=noise),
        programs=True,
    )
    result = calibrate(question, workers=workers)
    findings = findings_of(question, result.seed, [record.evaluation for record in result.history], noise=noise)
    if not findings.predictions:
        raise SolverError("; ".join(findings.notes))
    return Predicted(findings.predictions[0])


def design(
    report: Report,
    candidates: Mapping[str, Any] | str | Path,
    *,
    predicted: Problem | Mapping[str, Any] | str | Path | None,
    criterion: Literal["widths", "volume", "prediction"] | None,
    draws: int,
    noise: Mapping[str, float] | float | None,
    workers: int,
) -> Design:
    """Evaluate the worth of candidate tests; see :meth:`geoswarm.Result.design`."""
    from geoswarm.solver.identifiability.stored.findings import findings_of
    from geoswarm.solver.report.questions import design_question
    from geoswarm.solver.runs.local import calibrate

    question = design_question(
        report,
        Path(candidates) if isinstance(candidates, str) else candidates,
        predict=None if predicted is None else _document(predicted),
        criterion=criterion,
        draws=draws,
        noise=noise,
        programs=True,
    )
    result = calibrate(question, workers=workers)
    findings = findings_of(question, result.seed, [record.evaluation for record in result.history], noise=noise)
    if not findings.designs:
        raise SolverError("; ".join(findings.notes))
    return findings.designs[0]


def _document(other: Problem | Mapping[str, Any] | str | Path) -> Mapping[str, Any] | Path:
    if isinstance(other, Problem):
        return other.document()
    return Path(other) if isinstance(other, str) else other
