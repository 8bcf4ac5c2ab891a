"""The figures of a run by name: each is drawn when it is asked for, as SVG, PNG, or the numbers behind it as CSV."""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable
from functools import cached_property
from typing import TYPE_CHECKING

from geoswarm.solver.forward.registry import sketches_of
from geoswarm.solver.identifiability import Samples, Statistics
from geoswarm.solver.identifiability.prediction.bands import Prediction
from geoswarm.solver.identifiability.stored.follow_ups import follow_up_of
from geoswarm.solver.identifiability.worth.outcome import Design
from geoswarm.solver.parameter_estimates.classical import classical_evaluation
from geoswarm.solver.parameter_estimates.values import Construction
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.compared import Compared
from geoswarm.solver.report.compression import CompressionCurve, compression_curves
from geoswarm.solver.report.curves import SeriesCurve, initial_values, objective_unit, series_curves
from geoswarm.solver.report.diagrams import DiagramCurve, diagram_curves
from geoswarm.solver.report.figures.compression_plot import compression_figure, compression_rows
from geoswarm.solver.report.figures.construction_plot import (
    chosen_constructions,
    construction_figure,
    construction_rows,
)
from geoswarm.solver.report.figures.diagram_plot import (
    diagram_figure,
    diagram_rows,
    overlay_figure,
    overlay_rows,
)
from geoswarm.solver.report.figures.fit_plot import (
    MOST_BELOW_EACH_OTHER,
    fit_figure,
    fit_rows,
    has_stages,
    stages_figure,
)
from geoswarm.solver.report.figures.intervals_plot import IntervalRow, interval_rows, intervals_figure
from geoswarm.solver.report.figures.labels import ParameterLabel, parameter_labels
from geoswarm.solver.report.figures.matrix_plot import MatrixData, matrix_figure, matrix_rows
from geoswarm.solver.report.figures.outlook.design_plot import design_figure, design_rows
from geoswarm.solver.report.figures.outlook.prediction_plot import prediction_figure, prediction_rows
from geoswarm.solver.report.figures.progress_plots import convergence_figure, convergence_rows, traces_figure
from geoswarm.solver.report.figures.sketch_plot import sketch_figure, sketch_rows
from geoswarm.solver.report.figures.uncertainty_plots import (
    index_rows,
    indices_figure,
    posterior_figure,
    posterior_rows,
    profile_rows,
    profiles_figure,
)
from geoswarm.solver.report.overlays import MANY_TESTS, Overlay, overlays
from geoswarm.solver.report.record import RunRecord
from geoswarm.solver.report.uncertainty import NOTHING_FURTHER, Uncertainty
from geoswarm.solver.sketches.drawing import DrawnSketch

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["FigureSet", "slug"]

Rows = tuple[list[str], list[list[object]]]


_LONGEST = 100


class FigureSet:
    """All figures of one run.

    ``names`` are, as far as there is anything to show: matrix, intervals, profiles, posterior, global_sensitivity,
    prediction.NAME (one each), design,
    sketch (of a test; sketch.PART of each of several), fit, stages.SERIES (one a series that was measured during
    several loads), tests (diagrams that several tests have), compression (of a laboratory test; compression.PART of
    each of several), those that a test declares (stress_path, shear_modulus, compression_line), classical
    (constructions on the readings), convergence,
    traces. A follow-up has neither matrix nor the progress of a search.

    Parameters
    ----------
    problem, record
        What was asked for and how it went.
    samples, statistics
        Successful evaluations and their statistics; None where there are none.
    uncertainty
        What follow-ups and a posterior sample have found.
    compared
        Another set of parameters, whose curves are drawn, too.
    """

    def __init__(
        self,
        problem: Problem,
        record: RunRecord,
        samples: Samples | None,
        statistics: Statistics | None,
        uncertainty: Uncertainty = NOTHING_FURTHER,
        compared: Compared | None = None,
    ) -> None:
        self._compared = compared
        self._problem = problem
        self._record = record
        self._samples = samples
        self._statistics = statistics
        self._uncertainty = uncertainty
        self._drawn: dict[str, Figure] = {}
        self._labels = parameter_labels(problem)
        self._unit = objective_unit(problem)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the figures that can be drawn, in the order of a report."""
        return tuple(self._makers)

    def draw(self, name: str) -> Figure:
        """Draw a figure, once: several forms are rendered from the same one.

        Raises
        ------
        KeyError
            When there is no figure of this name; the message lists those that there are.
        """
        maker = self._maker(name)[0]
        if name not in self._drawn:
            self._drawn[name] = maker()
        return self._drawn[name]

    def rows(self, name: str) -> Rows:
        """Return header and rows of the numbers that a figure shows."""
        return self._maker(name)[1]()

    def csv(self, name: str) -> str:
        """Return the numbers that a figure shows as CSV; None becomes an empty cell."""
        header, rows = self.rows(name)
        stream = io.StringIO()
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
        return stream.getvalue()

    def _maker(self, name: str) -> tuple[Callable[[], Figure], Callable[[], Rows]]:
        if name not in self._makers:
            raise KeyError(f"no figure {name!r}; there are: {', '.join(self._makers) or 'none'}")
        return self._makers[name]

    @cached_property
    def _makers(self) -> dict[str, tuple[Callable[[], Figure], Callable[[], Rows]]]:
        makers: dict[str, tuple[Callable[[], Figure], Callable[[], Rows]]] = {}
        title = self._problem.name
        follow_up = follow_up_of(self._problem) is not None
        records = [] if follow_up else self._record.records
        if self._statistics is not None and self._samples is not None and not follow_up:
            data = self._matrix(self._statistics, self._samples)
            makers["matrix"] = (
                lambda: matrix_figure(f"{title}: what the data can tell", data),
                lambda: matrix_rows(data),
            )
        if self._statistics is not None and self._samples is not None and self._intervals_wanted:
            rows = self._intervals(self._statistics, self._samples)
            makers["intervals"] = (lambda: intervals_figure(f"{title}: parameters", rows), lambda: interval_rows(rows))
        makers |= self._further(title)
        for part, sketch in self._sketches.items():
            makers[part] = _sketch(title, part, sketch)
        if self._record.best is not None:
            other = self._other
            makers["fit"] = (
                lambda: fit_figure(f"{title}: fit", self._curves, other),
                lambda: fit_rows(self._curves),
            )
            if self._overlays:
                makers["tests"] = (
                    lambda: overlay_figure(f"{title}: all tests", self._overlays, other[0] if other else ""),
                    lambda: overlay_rows(self._overlays),
                )
            for curve in self._curves:
                if has_stages(curve):
                    makers[f"stages.{curve.series}"] = _stages(title, curve)
            for compressed in self._compression:
                name = f"compression.{compressed.part}" if compressed.part else "compression"
                makers[name] = _compression(title, compressed)
            for name, declared in self._diagrams.items():
                makers[name] = _diagram(title, declared)
        if self._constructions:
            drawn = self._constructions
            makers["classical"] = (
                lambda: construction_figure(f"{title}: classical evaluation", drawn),
                lambda: construction_rows(drawn),
            )
        if records:
            target = self._problem.stopping.target_objective
            makers["convergence"] = (
                lambda: convergence_figure(f"{title}: convergence", records, self._unit, target),
                lambda: convergence_rows(records),
            )
        if records and self._samples is not None:
            samples = self._samples
            makers["traces"] = (
                lambda: traces_figure(f"{title}: parameters during the search", records, samples, self._labels),
                lambda: _trace_rows(samples),
            )
        return makers

    @cached_property
    def _sketches(self) -> dict[str, DrawnSketch]:
        """By the name of the figure."""
        found = sketches_of(self._problem.forward_model)
        return {f"sketch.{part}" if part else "sketch": one for part, one in found.items()}

    @cached_property
    def _constructions(self) -> tuple[Construction, ...]:
        return chosen_constructions(classical_evaluation(self._problem).constructions)

    @cached_property
    def _diagrams(self) -> dict[str, DiagramCurve]:
        """By the name of the figure."""
        best = self._record.best
        found = () if best is None else diagram_curves(self._problem, best.parameters)
        return {f"{one.diagram.name}.{one.part}" if one.part else one.diagram.name: one for one in found}

    @property
    def shown(self) -> tuple[str, ...]:
        """Names of the figures of a report: without those of single tests that the figure of all tests shows."""
        many = {
            f"{one.name}.{line.test}" for one in self._overlays if len(one.lines) >= MANY_TESTS for line in one.lines
        }
        return tuple(name for name in self.names if name not in many)

    @cached_property
    def _overlays(self) -> tuple[Overlay, ...]:
        """Diagrams that several tests have."""
        if self._record.best is None:
            return ()
        other: tuple[Overlay, ...] = ()
        if self._compared is not None and self._other is not None:
            values = self._compared.fit.parameters
            further = diagram_curves(self._problem, values), compression_curves(self._problem, values, None)
            other = overlays(self._other[1], *further)
        return overlays(self._curves, self._diagrams.values(), self._compression, other)

    @cached_property
    def _other(self) -> tuple[str, list[SeriesCurve]] | None:
        """Name and curves of the other set of parameters."""
        if self._compared is None:
            return None
        fit = self._compared.fit
        return self._compared.name, [c.thinned() for c in series_curves(self._problem, fit.responses, fit.parameters)]

    @property
    def fit_is_wide(self) -> bool:
        """Whether the figure of the fit has two columns."""
        return len(self._problem.observations) > MOST_BELOW_EACH_OTHER

    def told(self, name: str) -> tuple[str, str] | None:
        """Heading and caption of a figure that is named by what it shows; an empty caption: the usual one."""
        if name in self._sketches:
            return self._sketches[name].sketch.test, self._sketches[name].words
        if name in self._predictions:
            return f"Prediction: {self._predictions[name].name}", ""
        if name in self._diagrams:
            return self._diagrams[name].diagram.heading, self._diagrams[name].diagram.caption
        return None

    @property
    def _intervals_wanted(self) -> bool:
        return follow_up_of(self._problem) is None or self._uncertainty.findings.linearisation is not None

    def _further(self, title: str) -> dict[str, tuple[Callable[[], Figure], Callable[[], Rows]]]:
        """Figures of follow-ups and of a posterior sample."""
        makers: dict[str, tuple[Callable[[], Figure], Callable[[], Rows]]] = {}
        findings, posterior = self._uncertainty.findings, self._uncertainty.posterior
        units = {info.name: info.y_unit for info in self._problem.model.series}
        logs = {p.name: p.scale == "log" for p in self._problem.free}
        if findings.profiles:
            makers["profiles"] = (
                lambda: profiles_figure(f"{title}: profiles", findings.profiles, self._labels, logs, self._unit),
                lambda: profile_rows(findings.profiles),
            )
        if posterior is not None:
            makers["posterior"] = (
                lambda: posterior_figure(f"{title}: posterior sample", posterior, self._labels, logs),
                lambda: posterior_rows(posterior, logs),
            )
        if findings.global_sensitivities:
            makers["global_sensitivity"] = (
                lambda: indices_figure(f"{title}: influence", findings.global_sensitivities, self._labels, units),
                lambda: index_rows(findings.global_sensitivities),
            )
        for name, prediction in self._predictions.items():
            makers[name] = _prediction(prediction)
        if self._uncertainty.findings.designs:
            makers["design"] = _design(self._uncertainty.findings.designs[0], self._labels)
        return makers

    @cached_property
    def _predictions(self) -> dict[str, Prediction]:
        """By the name of the figure."""
        found: dict[str, Prediction] = {}
        for prediction in self._uncertainty.findings.predictions:
            plain = f"prediction.{slug(prediction.name)}"
            name, number = plain, 2
            while name in found:
                name, number = f"{plain}-{number}", number + 1
            found[name] = prediction
        return found

    @cached_property
    def _curves(self) -> list[SeriesCurve]:
        best = self._record.best
        if best is None:
            return []
        curves = series_curves(self._problem, best.responses, best.parameters, initial_values(self._problem))
        return [curve.thinned() for curve in curves]

    @cached_property
    def _compression(self) -> tuple[CompressionCurve, ...]:
        best, statistics = self._record.best, self._statistics
        found = None if statistics is None or statistics.fit.caution else statistics.linearisation
        return () if best is None else compression_curves(self._problem, best.parameters, found)

    def _matrix(self, statistics: Statistics, samples: Samples) -> MatrixData:
        return MatrixData(
            samples,
            statistics.filtered,
            statistics.projections,
            statistics.pearson,
            statistics.spearman,
            self._labels,
            self._unit,
        )

    def _intervals(self, statistics: Statistics, samples: Samples) -> list[IntervalRow]:
        rows = []
        linearisation = statistics.linearisation
        for index, (name, projection) in enumerate(zip(samples.names, statistics.projections, strict=True)):
            verdict = statistics.verdict(name)
            sampled = verdict.evidence.basis == "sampling" and projection.lower is not None
            good = (projection.lower or 0.0, projection.upper or 0.0) if sampled else None
            rows.append(
                IntervalRow(
                    self._labels[name],
                    float(samples.lower[index]),
                    float(samples.upper[index]),
                    samples.scales[index] == "log",
                    projection.best,
                    statistics.at_minimum,
                    good,
                    None if linearisation is None else linearisation.interval(name),
                    0.95 if linearisation is None else linearisation.level,
                    verdict.words,
                )
            )
        return rows


def _prediction(prediction: Prediction) -> tuple[Callable[[], Figure], Callable[[], Rows]]:
    doubt = " (the model does not describe the data)" if prediction.alarm else ""
    return lambda: prediction_figure(f"{prediction.name}{doubt}", prediction), lambda: prediction_rows(prediction)


def _design(design: Design, labels: dict[str, ParameterLabel]) -> tuple[Callable[[], Figure], Callable[[], Rows]]:
    doubt = " (the model does not describe the data)" if design.alarm else ""
    return lambda: design_figure(f"{design.name}{doubt}", design, labels), lambda: design_rows(design)


def _stages(title: str, curve: SeriesCurve) -> tuple[Callable[[], Figure], Callable[[], Rows]]:
    return lambda: stages_figure(f"{title}: {curve.series} by stage", curve), lambda: fit_rows([curve])


def _sketch(title: str, name: str, sketch: DrawnSketch) -> tuple[Callable[[], Figure], Callable[[], Rows]]:
    part = name.partition(".")[2]
    heading = f"{title}: {part or sketch.sketch.test}"
    return lambda: sketch_figure(heading, sketch), lambda: sketch_rows(sketch.sketch)


def _diagram(title: str, curve: DiagramCurve) -> tuple[Callable[[], Figure], Callable[[], Rows]]:
    heading = f"{title}: {curve.diagram.heading.lower()}{f' ({curve.part})' if curve.part else ''}"
    return lambda: diagram_figure(heading, curve), lambda: diagram_rows(curve)


def _compression(title: str, curve: CompressionCurve) -> tuple[Callable[[], Figure], Callable[[], Rows]]:
    heading = f"{title}: compression{f' ({curve.part})' if curve.part else ''}"
    return lambda: compression_figure(heading, curve), lambda: compression_rows(curve)


def _trace_rows(samples: Samples) -> Rows:
    header = ["generation", "particle", "objective", *(f"parameter.{name}" for name in samples.names)]
    columns = (samples.generations.tolist(), samples.particles.tolist(), samples.objectives.tolist())
    return header, [[*place, *x] for *place, x in zip(*columns, samples.parameters.tolist(), strict=True)]


def slug(name: str) -> str:
    """Return the letters, digits and signs of a name that every file system takes.

    >>> slug("later stage, 40 mm")
    'later-stage-40-mm'
    """
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name)[:_LONGEST].strip("-") or "unnamed"
