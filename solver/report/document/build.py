"""From a run to its report: statistics, figures, content, HTML and PDF in one object that makes each part once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from geoswarm.solver.arrays import FloatArray
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
from geoswarm.solver.identifiability.optimum.basins import equivalent_objective, exchangeable, heads_elsewhere
from geoswarm.solver.identifiability.optimum.bending import likelihood_intervals
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.hidden import Unseen
from geoswarm.solver.identifiability.optimum.polish import Polished, polish
from geoswarm.solver.identifiability.stored.findings import answer_of
from geoswarm.solver.identifiability.stored.follow_ups import follow_up_of
from geoswarm.solver.identifiability.stored.linearised import jacobian_from_samples
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.document.content import Content, report_content
from geoswarm.solver.report.document.html import html_fragment, html_report
from geoswarm.solver.report.document.pdf import pdf_report
from geoswarm.solver.report.figures.figure_set import FigureSet
from geoswarm.solver.report.figures.style import save_figure
from geoswarm.solver.report.record import Optimum, RunRecord, record_of_result
from geoswarm.solver.report.uncertainty import NOTHING_FURTHER, Uncertainty

__all__ = ["Report", "linearise_here", "linearise_stored", "report_of_result"]


_MOST_RUNS = 2000  # of one polish
_MOST_DESCENTS = 12  # beside that from the best sample
_MOST_SWAPS = 10  # pairs of parameters
_HEIGHT = 2.0  # times as high as a basin reaches: descents cost little
_BETTER = 1e-9  # relative decrease of the objective
_SAME = 1e-9  # relative difference of parameters


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
        follow_up = follow_up_of(problem)
        if follow_up is not None and not follow_up.compares:  # its objectives compare with no reading
            record, samples = replace(record, best=None), samples.select(np.empty(0, dtype=np.int64))
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
                elsewhere=(*(() if optimum is None else optimum.elsewhere), *uncertainty.findings.explored),
                left=uncertainty.findings.left,
                looked=() if optimum is None else optimum.looked,
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

    @property
    def lowest_objective(self) -> float:
        """At the optimum that is reported: polished where somebody went there, of the best evaluation otherwise."""
        findings = self.uncertainty.findings
        if self.optimum is not None:
            return float(self.optimum.polished.objective)
        if findings.linearisation is not None and findings.objective is not None:
            return findings.objective
        return float(self.samples.objectives[self.samples.best])

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
    noise: Mapping[str, float] | float | None = None,
) -> Report:
    """Make the report of a run in this process.

    Parameters
    ----------
    linearise
        Whether to polish the optimum and calculate the sensitivities there, with some hundred further forward runs of a
        quick model, from stored runs otherwise. By default after a swarm alone: a search that went on to its minimum
        made the runs that it was given, and the best of a sampling is not an optimum.
    noise
        Known standard deviation of a reading, base units; that of the problem file when absent.
    """
    samples, record, seed = Samples.from_result(problem, result), record_of_result(problem, result), result.seed
    found, stored, uncertainty = None, None, NOTHING_FURTHER
    wanted = problem.method.role == "search" if linearise is None else linearise
    if result.answer is not None and not linearise:
        after = [one.evaluation for one in result.history if one.generation >= result.answer.generation]
        uncertainty = Uncertainty(answer_of(Calibration(problem, seed), result.answer, after, noise=noise))
    elif wanted and samples.size:
        found = linearise_here(problem, samples, seed, noise=noise)
    if wanted and found is None and uncertainty.findings.linearisation is None:
        stored = linearise_stored(problem, samples, seed, noise=noise)
    return Report(
        problem,
        record,
        samples,
        threshold=threshold,
        optimum=found,
        linearisation=stored,
        noise=noise,
        uncertainty=uncertainty,
    )


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
    try:
        descents = _Descents(calibration, samples, noise)
        descents.settle()
        descents.swap()
        if descents.settle():
            descents.swap()
        found = likelihood_intervals(calibration, descents.found)
    except SolverError:
        return None
    return Optimum(descents.told, found, tuple(descents.further), tuple(descents.looked))


class _Descents:
    """Descents from the best sample, and from runs that point to other basins, until none is left.

    Parameters
    ----------
    calibration, samples
        The problem and its runs.
    noise
        Known standard deviation of a reading, base units; that of the problem file when None.
    """

    def __init__(self, calibration: Calibration, samples: Samples, noise: Mapping[str, float] | float | None) -> None:
        problem = calibration.problem
        self._calibration, self._samples, self._noise = calibration, samples, noise
        self._known = problem_noise(problem) if noise is None else known_noise(problem, noise)
        self.best = self._first = polish(calibration, samples.parameters[samples.best], max_evaluations=_MOST_RUNS)
        self.found = self._linearise()
        self._runs, self._left = self.best.evaluations, _MOST_DESCENTS
        self.further: list[tuple[FloatArray, float]] = []
        """Minima beside the best, and other runs that were made."""
        self.looked: list[FloatArray] = []
        """Where descents have begun or ended."""

    @property
    def told(self) -> Polished:
        """The best minimum; what is told is the way from the best sample, wherever its descent began."""
        return replace(self.best, start_objective=self._first.start_objective, evaluations=self._runs)

    def settle(self) -> bool:
        """Descend wherever another basin shows; return whether the best minimum changed."""
        before = self.best
        while self._left and (start := self._next()) is not None:
            other = polish(self._calibration, start, max_evaluations=_MOST_RUNS)
            self._left, self._runs = self._left - 1, self._runs + other.evaluations
            self.looked += [start, other.parameters]
            if other.objective < self.best.objective * (1.0 - _BETTER):
                self.best, other = other, self.best
                self.found = self._linearise()
            self.further.append((other.parameters, other.objective))
        return self.best is not before

    def swap(self) -> None:
        """Run the best minimum with the values of exchangeable parameters swapped."""
        pairs = exchangeable(self._calibration, self.best.parameters)[:_MOST_SWAPS]
        runs = [self._calibration.evaluate(place) for _, _, place in pairs]
        self.further += [(run.parameters, run.objective) for run in runs if run.objective is not None]

    def _linearise(self) -> Linearisation:
        differences = evaluate_differences(self._calibration, self.best.parameters)
        return from_evaluations(self._calibration, *differences, noise=self._noise)

    def _next(self) -> FloatArray | None:
        """Where to go down next: the best run that points to another basin, or a good one that was left."""
        samples, found, best = self._samples, self.found, self.best.objective
        limit = equivalent_objective(self._calibration, best, self._known)
        unseen = Unseen.of(samples, found, best, self.further)
        rows = unseen.unfinished(0.0, [samples.to_unit(place) for place in self.looked], height=_HEIGHT, made=True)
        starts = [place for place, _ in unseen.places_of(self._calibration.space, rows)]
        starts += [samples.parameters[head] for head in heads_elsewhere(samples, found, limit, best)]
        done = np.array([*self.looked, self.best.parameters])
        new = (place for place in starts if not np.isclose(done, place, rtol=_SAME, atol=0.0).all(axis=1).any())
        return next(new, None)
