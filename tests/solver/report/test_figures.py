"""Figures say what they show: units, scales, counts; they stay small, quick, and the same to the byte."""

from __future__ import annotations

import csv
import io
import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from geoswarm.solver.identifiability import Samples, correlate, filter_samples, project
from geoswarm.solver.identifiability.prediction.bands import BasinOutcome, PredictedSeries, Prediction
from geoswarm.solver.identifiability.stored.findings import Findings
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.report.compared import compared_with
from geoswarm.solver.report.curves import SeriesCurve
from geoswarm.solver.report.figures.figure_set import FigureSet
from geoswarm.solver.report.figures.fit_plot import fit_figure
from geoswarm.solver.report.figures.labels import ParameterLabel, parameter_labels
from geoswarm.solver.report.figures.matrix_plot import MatrixData, matrix_figure
from geoswarm.solver.report.figures.progress_plots import convergence_figure
from geoswarm.solver.report.figures.style import figures_available, inline_svg, png_of, svg_of, tick_text
from geoswarm.solver.report.record import RunRecord
from geoswarm.solver.report.uncertainty import Uncertainty
from tests.solver.report.conftest import Run, oedometer


def texts(svg: bytes) -> str:
    return " ".join("".join(e.itertext()) for e in ElementTree.fromstring(svg).iter() if e.tag.endswith("text"))


def test_every_axis_has_a_unit(swarm: Run, sampling: Run) -> None:
    assert figures_available()
    for run in (swarm, sampling):
        for name in run.report.figures.names:
            figure = run.report.figures.draw(name)
            labels = [label for axes in figure.axes for label in (axes.get_xlabel(), axes.get_ylabel()) if label]
            labels += [figure.get_supxlabel(), figure.get_supylabel()] if name.startswith("stages") else []
            labels += [axes.get_title(loc="left") for axes in figure.axes] if name == "intervals" else []
            if name == "sketch":
                written = [text.get_text() for axes in figure.axes for text in axes.texts]
                labels += [text for text in written if text.startswith(("σ′v", "time")) and text != "σ′v"]
            assert labels, name
            assert all(re.search(r"\[[^\]]+\]", label) for label in labels), (name, labels)


def settlement_axes(figure: Figure) -> list[Axes]:
    """The axes that have settlements upwards or downwards; the residuals of a settlement are below it."""
    if "settlement" in figure.get_supylabel():
        return figure.axes
    shown = [axes for axes in figure.axes if "settlement" in axes.get_ylabel()]
    return shown + [axes for axes in figure.axes if shown and axes.get_ylabel().startswith("residual")]


def test_settlements_point_downwards_in_every_figure(swarm: Run) -> None:
    document = oedometer()
    (observed,) = document["observations"]
    several = parse_problem(
        document
        | {
            "forward_model": {"kind": "combined", "parts": dict.fromkeys("ab", document["forward_model"])},
            "observations": [observed | {"series": f"{test}.settlement"} for test in "ab"],
        }
    )
    best = compared_with(several, "best", swarm.result.parameters or {}).fit
    record = RunRecord(None, "finished", (), None, 1, 0, 1, {}, 1.0, 1, best, ())
    x = np.array([1.0, 2.0, 3.0])
    band = PredictedSeries(
        "settlement",
        "time",
        "settlement",
        "min",
        "mm",
        x,
        x,
        x,
        x,
        None,
        None,
        x[None],
        x[None],
        x[None],
        x,
        1,
        0,
        None,
    )
    basin = BasinOutcome(1.0, {}, 20)
    later = Prediction("later", 0.9, "covariance", 20, 0, (basin,), (), (band,), None, (), swarm.problem, {})
    found = Uncertainty(Findings(predictions=(later,)))
    drawn: dict[str, list[Axes]] = {}
    for figures in (swarm.report.figures, FigureSet(several, record, None, None, found)):
        drawn |= {name: settlement_axes(figures.draw(name)) for name in figures.names}
    shown = {name for name, axes in drawn.items() if axes}
    assert shown == {
        "fit",
        "tests",
        "prediction.later",
        "stages.settlement",
        "stages.a.settlement",
        "stages.b.settlement",
    }
    assert {name for name in shown if not all(axes.yaxis_inverted() for axes in drawn[name])} == set()


def test_matrix_prints_correlation_threshold_and_counts(sampling: Run) -> None:
    statistics = sampling.report.statistics
    assert statistics is not None
    figure = sampling.report.figures.draw("matrix")
    written = texts(svg_of(figure))
    assert f"f ≤ 10⁻⁷: {statistics.filtered.kept} of 2000 evaluations" in written
    pair = statistics.pearson.get("lambda_star", "c")
    assert pair.coefficient is not None
    assert f"r = {pair.coefficient:.2f}" in written
    assert f"n = {pair.count}" in written
    for label in ("λ* [-]", "κ* [-]", "c [kPa]", "μ* [-]", "φ [°]", "f [m²]", "objective f of good fits [m²]"):
        assert label in written
    panels = {axes.get_ylabel(): axes for axes in figure.axes}
    assert panels["κ* [-]"].get_yscale() == "log"
    assert panels["c [kPa]"].get_yscale() == "linear"
    low, high = panels["c [kPa]"].get_ylim()
    assert (low, high) == pytest.approx((-2.0, 102.0), abs=0.1)


def test_matrix_numbers_are_those_of_the_statistics(sampling: Run) -> None:
    statistics = sampling.report.statistics
    assert statistics is not None
    rows = list(csv.DictReader(io.StringIO(sampling.report.figures.csv("matrix"))))
    assert len(rows) == 10
    row = next(r for r in rows if (r["first"], r["second"]) == ("lambda_star", "c"))
    assert float(row["pearson"]) == statistics.pearson.get("lambda_star", "c").coefficient
    assert float(row["spearman"]) == statistics.spearman.get("lambda_star", "c").coefficient
    assert (float(row["threshold"]), int(row["samples"])) == (1e-7, statistics.filtered.kept)


def many(count: int, dimension: int) -> MatrixData:
    """Samples of a bowl of which each parameter feels less."""
    unit = np.random.default_rng(0).random((count, dimension))
    objectives = 1e-9 + 1e-6 * ((unit - 0.5) ** 2 * 5.0 / 3.0 ** np.arange(dimension)).sum(axis=1)
    log = np.arange(dimension) % 2 == 0
    names = tuple(f"p{i}" for i in range(dimension))
    samples = Samples(
        names=names,
        scales=tuple("log" if is_log else "linear" for is_log in log),
        lower=np.where(log, 1e-3, 0.0),
        upper=np.where(log, 1.0, 100.0),
        parameters=np.where(log, 1e-3 ** (1.0 - unit), 100.0 * unit),
        objectives=objectives,
        misfits={},
        responses={},
        unbiased=np.ones(count, dtype=np.bool_),
        generations=np.zeros(count, dtype=np.int64),
        particles=np.arange(count, dtype=np.int64),
    )
    filtered = filter_samples(samples, float(np.quantile(objectives, 0.1)))
    labels = {name: ParameterLabel(name, name, "kPa") for name in names}
    ranks = correlate(filtered.samples, method="spearman")
    return MatrixData(
        samples, filtered, project(samples, filtered.threshold.value), correlate(filtered.samples), ranks, labels, "m²"
    )


# test_matrix_says_when_it_draws_only_a_part has many points, too
@pytest.mark.slow
def test_matrix_of_20000_points_and_six_parameters_is_small() -> None:
    svg = svg_of(matrix_figure("many", many(20_000, 6)))
    assert len(svg) < 5e6
    assert "2000 of 20000 evaluations" in texts(svg)
    assert "points drawn" not in texts(svg)


def test_matrix_says_when_it_draws_only_a_part() -> None:
    assert "20000 points drawn" in texts(svg_of(matrix_figure("more", many(25_000, 2))))


@pytest.mark.parametrize("dimension", [1, 2])
def test_matrix_of_few_parameters_and_no_good_fit(dimension: int) -> None:
    data = many(50, dimension)
    nothing = filter_samples(data.samples, 1e-12)
    empty = MatrixData(
        data.samples, nothing, project(data.samples, 1e-12), correlate(nothing.samples), None, data.labels, "m²"
    )
    written = texts(svg_of(matrix_figure("empty", empty)))
    assert "0 of 50 evaluations" in written
    assert ("r = ?" in written) == (dimension == 2)


def test_fit_shows_measured_initial_identified_and_residuals(swarm: Run) -> None:
    upper, lower = swarm.report.figures.draw("fit").axes
    observation = swarm.problem.observations[0]
    lines = {line.get_label(): line for line in upper.get_lines() if not line.get_label().startswith("_")}
    assert set(lines) == {"initial", "identified", "measured"}
    assert np.allclose(lines["measured"].get_ydata(), 1e3 * observation.y, rtol=1e-12, atol=0)
    assert np.asarray(lines["initial"].get_ydata())[-1] == pytest.approx(2.77, abs=0.02)
    best = swarm.result.best
    assert best is not None
    residuals = lower.get_lines()[1].get_ydata()
    assert np.allclose(residuals, 1e3 * (best.responses["settlement"] - observation.y), rtol=0, atol=1e-9)
    assert (upper.get_ylabel(), lower.get_ylabel()) == ("settlement [mm]", "residual [mm]")
    assert upper.yaxis_inverted()
    assert lower.yaxis_inverted()


def test_stages_are_counted_in_whole_numbers() -> None:
    x = np.arange(1.0, 8.0)
    y = 1.0 / x
    curve = SeriesCurve("stage_void_ratio", "stage", "void ratio", "", "", x, y, x, y, y, 0.0 * y, x_integer=True)
    figure = fit_figure("clay", [curve])
    figure.draw_without_rendering()
    labels = [label.get_text() for label in figure.axes[1].get_xticklabels()]
    assert labels
    assert all(label == "" or label.isdigit() for label in labels)


def test_stages_run_over_the_logarithm_of_time(swarm: Run) -> None:
    figure = swarm.report.figures.draw("stages.settlement")
    assert len(figure.axes) == 16
    assert {axes.get_xscale() for axes in figure.axes} == {"log"}
    assert all(axes.yaxis_inverted() for axes in figure.axes)
    assert figure.axes[0].get_title(loc="left") == "stage 1"
    assert figure.get_supxlabel() == "time since the load [min]"


def test_convergence_is_logarithmic_and_shows_the_target(swarm: Run) -> None:
    (axes,) = swarm.report.figures.draw("convergence").axes
    assert axes.get_yscale() == "log"
    assert axes.get_ylabel() == "objective f [m²]"
    assert [line.get_label() for line in axes.get_lines()] == ["best of a generation", "best so far", "target"]
    assert np.all(np.diff(axes.get_lines()[1].get_ydata()) <= 0.0)


def test_convergence_without_success_says_so(failed: Run) -> None:
    figure = convergence_figure("nothing", failed.result.generation_records, "")
    assert [text.get_text() for text in figure.axes[0].texts] == ["no evaluation has succeeded"]
    assert png_of(figure).startswith(b"\x89PNG")


def test_the_same_figure_has_the_same_bytes_and_inline_ids_are_its_own(swarm: Run) -> None:
    figures = swarm.report.figures
    assert svg_of(figures.draw("fit")) == svg_of(figures.draw("fit"))
    inline = inline_svg(figures.draw("fit"), "one")
    assert inline.startswith("<svg ")
    assert set(re.findall(r'\bid="([^-"]+)-', inline)) == {"one"}
    assert "currentColor" in inline
    assert not re.search(r"https?://(?!www\.w3\.org)", inline)


def test_unknown_figure_is_an_error_that_lists_the_known(swarm: Run) -> None:
    with pytest.raises(
        KeyError, match=r"no figure 'pie'; there are: matrix, intervals, sketch, fit, stages\.settlement"
    ):
        swarm.report.figures.draw("pie")


def test_labels_have_symbols_and_units(sampling: Run) -> None:
    labels = parameter_labels(sampling.problem)
    assert [labels[name].axis for name in ("lambda_star", "c", "phi")] == ["λ* [-]", "c [kPa]", "φ [°]"]


@pytest.mark.parametrize(
    ("value", "text"), [(0.0, "0"), (0.05, "0.05"), (-3.0, "−3"), (1e-6, "10⁻⁶"), (5e-7, "5·10⁻⁷"), (20000.0, "20000")]
)
def test_tick_text(value: float, text: str) -> None:
    assert tick_text(value) == text
