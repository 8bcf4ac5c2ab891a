"""From a run to its report: statistics, figures, content, HTML and PDF in one object that makes each part once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability import (
    Linearisation,
    Samples,
    Statistics,
    analyse,
    from_evaluations,
    linearise,
)
from geoswarm.solver.identifiability.noise import known_noise, problem_noise
from geoswarm.solver.identifiability.optimum.basins import equivalent_objective, heads_elsewhere
from geoswarm.solver.identifiability.optimum.bending import likelihood_intervals
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import Polished, polish
from geoswarm.solver.identifiability.stored.linearised import jacobian_from_samples
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.document.content import Content, report_content
from geoswarm.solver.report.document.html import html_fragment, html_report
from geoswarm.solver.report.document.pdf import pdf_report
from geoswarm.solver.report.figures.figure_set import FigureSet
from geoswarm.solver.report.figures.style import save_figure
from geoswarm.solver.report.record import Optimum, RunRecord, record_of_result
from geoswarm.solver.report.uncertainty import NOTHING_FURTHER, Uncertainty
from geoswarm.solver.runs.local import CalibrationResult

__all__ = ["Report", "linearise_here", "linearise_stored", "report_of_result"]


_MOST_RUNS = 2000  # of one polish
_MOST_BASINS = 2  # beside that of the best sample
_BETTER = 1e-9  # relative decrease of the objective


class Report:
    """Everything that can be shown of one run.

    Parameters
    ----------
    problem, record
        What was asked for and how it went.
    samples
        Successful evaluations.
    threshold
        Objective up to which a fit is good; proposed when None.
    optimum
        Polished and linearised, where somebody made it.
    linearisation
        In place of ``optimum``: at the best sample, from stored evaluations (:func:`linearise_stored`).
    noise
        Known standard deviation of a reading, base units; that of the problem file when absent.
    uncertainty
        What follow-ups and a posterior sample have found; their sensitivities go before those from stored evaluations.

    Raises
    ------
    StatisticsError
        When the threshold is wrong.
    """

    def __init__(
        self,
        problem: Problem,
        record: RunRecord,
        samples: Samples,
        *,
        threshold: float | None = None,
        optimum: Optimum | None = None,
        linearisation: Linearisation | None = None,
        noise: Mapping[str, float] | float | None = None,
        uncertainty: Uncertainty = NOTHING_FURTHER,
    ) -> None:
        self.problem = problem
        self.record = record
        self.samples = samples
        self.optimum = optimum
        self.uncertainty = uncertainty
        self._linearisation, self._noise = linearisation, noise
        self.statistics: Statistics | None = None
        if samples.size:
            calibration = Calibration(problem, record.seed)
            found = uncertainty.findings.linearisation or linearisation
            self.statistics = analyse(
                calibration,
                samples,
                threshold=threshold,
                noise=noise,
                linearisation=found if optimum is None else optimum.linearisation,
                at_optimum=uncertainty.findings.responses if optimum is None else optimum.polished.evaluation.responses,
                elsewhere=() if optimum is None else optimum.elsewhere,
            )

    def with_threshold(self, threshold: float) -> Report:
        """Return the same with another threshold; nothing is calculated again that does not hang on it.

        Raises
        ------
        StatisticsError
            When the threshold is wrong.
        """
        return Report(
            self.problem,
            self.record,
            self.samples,
            threshold=threshold,
            optimum=self.optimum,
            linearisation=self._linearisation,
            noise=self._noise,
            uncertainty=self.uncertainty,
        )

    @cached_property
    def figures(self) -> FigureSet:
        """The figures by name."""
        samples = self.samples if self.samples.size else None
        return FigureSet(self.problem, self.record, samples, self.statistics, self.uncertainty)

    @cached_property
    def content(self) -> Content:
        """What the report says."""
        return report_content(self.problem, self.record, self.statistics, self.figures, self.optimum, self.uncertainty)

    def html(self) -> str:
        """Return the page."""
        return html_report(self.content)

    def fragment(self) -> str:
        """Return a short form for a notebook."""
        return html_fragment(self.content)

    def _repr_html_(self) -> str:
        """Show verdicts and facts in a notebook."""
        return self.fragment()

    def pdf(self) -> bytes:
        """Return the PDF."""
        return pdf_report(self.content)

    def save(
        self, folder: Path, *, html: bool = True, pdf: bool = True, figures: Sequence[str] | None = None
    ) -> list[Path]:
        """Write report.html, report.pdf and figures (all unless named) as PNG, SVG and CSV; return the files."""
        written: list[Path] = []
        if html:
            written.append(folder / "report.html")
            written[-1].write_text(self.html(), encoding="utf-8")
        if pdf:
            written.append(folder / "report.pdf")
            written[-1].write_bytes(self.pdf())
        for name in self.figures.names if figures is None else figures:
            written += save_figure(self.figures.draw(name), folder, name)
            table = folder / f"{name}.csv"
            table.write_text(self.figures.csv(name), encoding="utf-8")
            written.append(table)
        return written


def report_of_result(
    problem: Problem,
    result: CalibrationResult,
    *,
    threshold: float | None = None,
    linearise: bool | None = None,
) -> Report:
    """Make the report of a run in this process.

    Parameters
    ----------
    linearise
        Whether to polish the optimum and calculate the sensitivities there, with some hundred further forward runs of a
        quick model, from stored runs otherwise. By default after a swarm only: the best of a sampling is no optimum.
    """
    samples = Samples.from_result(problem, result)
    wanted = problem.method.role == "search" if linearise is None else linearise
    found = linearise_here(problem, samples, result.seed) if wanted and samples.size else None
    stored = linearise_stored(problem, samples, result.seed) if wanted and found is None else None
    record = record_of_result(problem, result)
    return Report(problem, record, samples, threshold=threshold, optimum=found, linearisation=stored)


def linearise_stored(
    problem: Problem, samples: Samples, seed: int, *, noise: Mapping[str, float] | float | None = None
) -> Linearisation | None:
    """Linearise at the best sample of a swarm without a forward run; None where they are not dense enough."""
    if problem.method.role != "search" or not samples.responses or samples.size == 0:
        return None
    calibration = Calibration(problem, seed)
    try:
        return linearise(calibration, jacobian_from_samples(calibration, samples), noise=noise)
    except SolverError:
        return None


def linearise_here(
    problem: Problem, samples: Samples, seed: int, *, noise: Mapping[str, float] | float | None = None
) -> Optimum | None:
    """Polish the best sample and linearise there, with forward runs in this process.

    Basins that the search left unfinished are polished, too; the optimum is the best of all. None where the data do not
    allow it, and for forward models that are not quick (:attr:`geoswarm.solver.forward.base.ForwardModelSpec.quick`).
    """
    if not problem.forward_model.quick:
        return None
    calibration = Calibration(problem, seed)
    known = problem_noise(problem) if noise is None else known_noise(problem, noise)
    try:
        best = polish(calibration, samples.parameters[samples.best], max_evaluations=_MOST_RUNS)
        found = _linearise(calibration, best, noise)
        limit = equivalent_objective(calibration, best.objective, known)
        heads = heads_elsewhere(samples, found, limit, best.objective)[:_MOST_BASINS]
        further = [polish(calibration, samples.parameters[head], max_evaluations=_MOST_RUNS) for head in heads]
        for other in sorted(further, key=lambda polished: polished.objective)[:1]:
            if other.objective < best.objective * (1.0 - _BETTER):
                others = [best, *(polished for polished in further if polished is not other)]
                # what is told is the way from the best evaluation, wherever the best descent began
                runs = best.evaluations + sum(polished.evaluations for polished in further)
                found = _linearise(calibration, other, noise)
                best, further = replace(other, start_objective=best.start_objective, evaluations=runs), others
    except SolverError:
        return None
    return Optimum(best, found, tuple((polished.parameters, polished.objective) for polished in further))


def _linearise(
    calibration: Calibration, polished: Polished, noise: Mapping[str, float] | float | None
) -> Linearisation:
    found = from_evaluations(calibration, *evaluate_differences(calibration, polished.parameters), noise=noise)
    return likelihood_intervals(calibration, found)
