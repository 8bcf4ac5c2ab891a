"""From a run to its report: statistics, figures, content, HTML and PDF in one object that makes each part once."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability import (
    Linearisation,
    Samples,
    Statistics,
    analyse,
    linearise,
)
from geoswarm.solver.identifiability.optimum.refitted import with_refits
from geoswarm.solver.identifiability.stored.findings import answer_of
from geoswarm.solver.identifiability.stored.follow_ups import follow_up_of
from geoswarm.solver.identifiability.stored.linearised import jacobian_from_samples
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.compared import Compared
from geoswarm.solver.report.document.content import Content, report_content
from geoswarm.solver.report.document.html import html_fragment, html_report
from geoswarm.solver.report.document.pdf import pdf_report
from geoswarm.solver.report.figures.figure_set import FigureSet
from geoswarm.solver.report.figures.style import save_figure
from geoswarm.solver.report.parts import PARTS, Part
from geoswarm.solver.report.record import RunRecord, record_of_result
from geoswarm.solver.report.uncertainty import NOTHING_FURTHER, Uncertainty
from geoswarm.solver.system.processes import without_garbage_collection

__all__ = ["Report", "linearise_stored", "report_of_result"]


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
    linearisation
        At the best sample, from stored evaluations (:func:`linearise_stored`).
    noise
        Known standard deviation of a reading, base units; that of the problem file when absent.
    uncertainty
        What follow-ups and a posterior sample have found; their sensitivities go before those from stored evaluations.
    compared
        Another set of parameters beside the result.

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
        linearisation: Linearisation | None = None,
        noise: Mapping[str, float] | float | None = None,
        uncertainty: Uncertainty = NOTHING_FURTHER,
        compared: Compared | None = None,
    ) -> None:
        follow_up = follow_up_of(problem)
        if follow_up is not None and not follow_up.compares:  # its objectives compare with no reading
            record, samples = replace(record, best=None), samples.select(np.empty(0, dtype=np.int64))
        self.problem = problem
        self.record = record
        self.samples = samples
        self.uncertainty = uncertainty
        self.compared = compared
        self._linearisation, self._noise = linearisation, noise
        self.statistics: Statistics | None = None
        if samples.size:
            calibration = Calibration(problem, record.seed)
            found = uncertainty.findings.linearisation or linearisation
            if found is not None and uncertainty.findings.jackknife is not None:
                found = with_refits(found, uncertainty.findings.jackknife)
            self.statistics = analyse(
                calibration,
                samples,
                threshold=threshold,
                noise=noise,
                linearisation=found,
                at_optimum=uncertainty.findings.responses,
                elsewhere=uncertainty.findings.explored,
                left=uncertainty.findings.left,
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
            linearisation=self._linearisation,
            noise=self._noise,
            uncertainty=self.uncertainty,
            compared=self.compared,
        )

    @property
    def lowest_objective(self) -> float:
        """At the optimum that is reported: where the sensitivities are, of the best evaluation otherwise."""
        findings = self.uncertainty.findings
        if findings.linearisation is not None and findings.objective is not None:
            return findings.objective
        return float(self.samples.objectives[self.samples.best])

    @cached_property
    def figures(self) -> FigureSet:
        """The figures by name."""
        samples = self.samples if self.samples.size else None
        return FigureSet(self.problem, self.record, samples, self.statistics, self.uncertainty, self.compared)

    @cached_property
    def content(self) -> Content:
        """What the report says."""
        return report_content(self.problem, self.record, self.statistics, self.figures, self.uncertainty, self.compared)

    def html(self, parts: Collection[Part] = PARTS) -> str:
        """Return the page, with some of its parts."""
        return html_report(self._with(parts))

    def _with(self, parts: Collection[Part]) -> Content:
        return self.content if set(parts) == set(PARTS) else self.content.only(parts)

    def fragment(self) -> str:
        """Return a short form for a notebook."""
        return html_fragment(self.content)

    def _repr_html_(self) -> str:
        """Show verdicts and facts in a notebook."""
        return self.fragment()

    def pdf(self, parts: Collection[Part] = PARTS) -> bytes:
        """Return the PDF, with some of its parts."""
        return pdf_report(self._with(parts))

    @without_garbage_collection()
    def save(
        self,
        folder: Path,
        *,
        html: bool = True,
        pdf: bool = True,
        figures: Sequence[str] | None = None,
        told: Callable[[int, int], None] = lambda _done, _of: None,
    ) -> list[Path]:
        """Write figures (those of the report unless named) as PNG, SVG and CSV, and the reports; return the files.

        ``told``: is called with how many figures and reports are written, and of how many.
        """
        reports: list[Path] = []
        written: list[Path] = []
        names = self.figures.shown if figures is None else figures
        of = len(names) + html + pdf
        for done, name in enumerate(names):
            told(done, of)
            written += save_figure(self.figures.draw(name), folder, name)
            table = folder / f"{name}.csv"
            table.write_text(self.figures.csv(name), encoding="utf-8")
            written.append(table)
        if html:
            told(len(names), of)
            reports.append(folder / "report.html")
            reports[-1].write_text(self.html(), encoding="utf-8")
        if pdf:
            told(of - 1, of)
            reports.append(folder / "report.pdf")
            reports[-1].write_bytes(self.pdf())
        return reports + written


def report_of_result(
    problem: Problem,
    result: CalibrationResult,
    *,
    threshold: float | None = None,
    noise: Mapping[str, float] | float | None = None,
    compared: Compared | None = None,
) -> Report:
    """Make the report of a run in this process.

    Parameters
    ----------
    noise
        Known standard deviation of a reading, base units; that of the problem file when absent.
    compared
        Another set of parameters beside the result.
    """
    samples, record, seed = Samples.from_result(problem, result), record_of_result(problem, result), result.seed
    stored, uncertainty = None, NOTHING_FURTHER
    if result.answer is not None:
        after = [one.evaluation for one in result.history if one.generation >= result.answer.generation]
        uncertainty = Uncertainty(answer_of(Calibration(problem, seed), result.answer, after, noise=noise))
    if uncertainty.findings.linearisation is None:
        stored = linearise_stored(problem, samples, seed, noise=noise)
    return Report(
        problem,
        record,
        samples,
        threshold=threshold,
        linearisation=stored,
        noise=noise,
        uncertainty=uncertainty,
        compared=compared,
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
