"""Cc, Cs, C_alpha and the preconsolidation stress: against slopes of calculated tests, closed forms and sampling."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.report.compression import compression_curves
from geoswarm.solver.report.document.build import Report, report_of_result
from geoswarm.solver.report.figures.compression_plot import compression_figure, compression_rows
from geoswarm.solver.report.folder.tables import write_result
from geoswarm.solver.report.laboratory import LaboratoryValue, laboratory_values, preconsolidation_stress
from geoswarm.solver.runs.local import calibrate
from tests.solver.report.conftest import EXAMPLE, Run, oedometer

E0 = 1.2
SOIL = {"lambda_star": 0.1, "kappa_star": 0.02, "mu_star": 0.004, "c": 0.0, "phi": 30.0}


def problem_of(kind: str, stages: list[tuple[float, float]], **more: Any) -> Problem:
    """A test with fixed geometry (small strain), of which nothing is searched for but c."""
    size = {"diameter": 0.05, "height": 0.1} if kind == "isotropic_compression" else {"height": 0.02}
    model = {
        "kind": kind,
        "initial_stress": 10.0,
        "geometry": "fixed",
        "tolerance": 1e-6,
        "stages": [{"stress": stress, "duration": duration} for stress, duration in stages],
        **size,
        **more.pop("model", {}),
    }
    parameters = {name: {"value": value} for name, value in (SOIL | more).items()}
    parameters["psi"] = {"lower": 0.0, "upper": 5.0}
    series = "stage_axial_strain" if kind == "oedometer" else "stage_volumetric_strain"
    return parse_problem(
        {
            "forward_model": model,
            "parameters": parameters,
            "observations": [{"series": series, "points": {"x": [1], "y": [0.05]}}],
            "stopping": {"max_evaluations": 10},
        }
    )


def values_of(problem: Problem) -> dict[str, LaboratoryValue]:
    return {v.symbol: v for v in laboratory_values(problem, problem.values([0.0]), None)}


def void_ratios(problem: Problem) -> np.ndarray:
    """Void ratio at the ends of the stages."""
    assert problem.forward_model.initial_void_ratio == E0  # type: ignore[attr-defined]
    stages = np.arange(1.0, len(problem.forward_model.stages) + 1.0)  # type: ignore[attr-defined]
    return problem.model.prepare({"stage_void_ratio": stages})(problem.values([0.0]))["stage_void_ratio"]


@pytest.mark.parametrize("kind", ["oedometer", "isotropic_compression"])
def test_the_indices_are_the_slopes_of_the_curve(kind: str) -> None:
    """Virgin loads 400 to 1600 kPa; 1600 kPa held from 1 to 100 days; one unloading to half."""
    stages = [(100.0, 1.0), (400.0, 1.0), (1600.0, 1.0), (1600.0, 9.0), (1600.0, 90.0), (800.0, 1e-6)]
    problem = problem_of(kind, stages, model={"initial_void_ratio": E0})
    e, found = void_ratios(problem), values_of(problem)
    assert (e[1] - e[2]) / math.log10(4.0) == pytest.approx(found["Cc"].value, rel=0.01)
    assert e[3] - e[4] == pytest.approx(found["Cα"].value, rel=0.02)
    swelling = (e[5] - e[4]) / math.log10(2.0)
    if kind == "isotropic_compression":
        assert swelling == pytest.approx(found["Cs"].value, rel=1e-3)
    else:
        # The stress ratio rises from K0nc = 0.5 as it unloads: elasticity lies between K = 0.5 and K = 1.
        steepest = math.log(10.0) * (1.0 + E0) * SOIL["kappa_star"] * 1.15 / (0.85 * (1.0 + 2.0 * 0.5))
        assert found["Cs"].value < swelling < steepest
        assert found["Cs"].value == pytest.approx(2.303 * (1.0 + E0) * SOIL["kappa_star"] / 2.0, rel=0.1)


def test_without_a_void_ratio_the_ratios_are_given() -> None:
    found = values_of(problem_of("oedometer", [(100.0, 1.0)]))
    assert list(found) == ["Cc/(1 + e₀)", "Cs/(1 + e₀)", "Cα/(1 + e₀)", "σ′p"]
    assert found["Cc/(1 + e₀)"].value == pytest.approx(0.2302585, rel=1e-6)
    assert found["Cc/(1 + e₀)"].relation == "2.303 λ*"


@pytest.mark.parametrize("formulation", ["translated", "untranslated"])
@pytest.mark.parametrize("cohesion", [0.0, 15.0])
def test_POP_is_added_to_the_initial_stress(formulation: str, cohesion: float) -> None:
    model = {"formulation": formulation}
    problem = problem_of("oedometer", [(100.0, 1.0)], model=model, POP=45.0, c=cohesion)
    assert values_of(problem)["σ′p"].value == pytest.approx(55.0, rel=1e-9)
    assert values_of(problem)["σ′p"].relation == "σ′₀ + POP"


def test_OCR_multiplies_the_initial_stress_without_cohesion() -> None:
    found = values_of(problem_of("oedometer", [(100.0, 1.0)], OCR=3.5))["σ′p"]
    assert found.value == pytest.approx(35.0, rel=1e-9)
    assert found.relation == "OCR σ′₀"


def test_OCR_with_cohesion_is_a_ratio_of_translated_pressures() -> None:
    """Under an all-round stress p = a = 20 kPa, OCR = 2 means 2 (20 + 20) - 20 = 60 kPa."""
    spec = {"kind": "isotropic_compression", "height": 0.1, "diameter": 0.05, "initial_stress": 20.0}
    model = parse_spec({**spec, "stages": [{"stress": 100, "duration": 1}]}).build()
    cohesion = 20.0 * math.tan(math.radians(30.0))
    found = preconsolidation_stress(model, SOIL | {"c": cohesion, "OCR": 2.0})  # type: ignore[arg-type]
    assert found == pytest.approx(60.0, rel=1e-9)


def calibrated(**changes: Any) -> tuple[Problem, Report]:
    """The published test with exact readings of its own model, so that every interval holds."""
    document = oedometer(method={"kind": "particle_swarm", "particles": 8}, stopping={"max_evaluations": 160})
    document["forward_model"] |= {"initial_void_ratio": 1.13, "initial_stress": 5.0}
    document["parameters"] |= changes
    truth = {
        "lambda_star": 0.09,
        "kappa_star": 0.02,
        "mu_star": 1.46e-3,
        "c": 10.0,
        "phi": 20.0,
        "psi": 0.0,
        "OCR": 4.0,
    }
    problem = parse_problem(document)
    observation = problem.observations[0]
    exact = problem.model.prepare({"settlement": observation.x})(truth)["settlement"]
    noisy = exact + np.random.default_rng(3).normal(0.0, 3e-5, exact.size)
    document["observations"] = [
        {"series": "settlement", "points": {"x": observation.x.tolist(), "y": noisy.tolist()}, "error": 3e-5}
    ]
    problem = parse_problem(document)
    return problem, report_of_result(problem, calibrate(problem))


def test_intervals_are_those_of_the_parameters() -> None:
    """sigma_p follows from c, OCR and (through M) lambda* and kappa*: its interval against a sampled one."""
    problem, report = calibrated(c={"lower": 1, "upper": 50}, OCR={"lower": 1, "upper": 20, "scale": "log"})
    assert report.statistics is not None
    found = report.statistics.linearisation
    assert found is not None
    values = problem.values(found.optimum.tolist())
    known = {v.symbol: v for v in laboratory_values(problem, values, found)}
    low, high = found.interval("lambda_star") or (math.nan, math.nan)
    factor = math.log(10.0) * 2.13
    assert known["Cc"].interval == pytest.approx((factor * low, factor * high), rel=1e-9)
    assert known["Cα"].interval is None  # mu* is fixed
    assert found.covariance is not None
    centre = np.where([s == "log" for s in found.scales], np.log(found.optimum), found.optimum)
    drawn = np.random.default_rng(1).multivariate_normal(centre, found.covariance, size=4000)
    natural = np.where([s == "log" for s in found.scales], np.exp(drawn), drawn)
    model = problem.model
    sampled = [preconsolidation_stress(model, problem.values(row.tolist())) for row in natural]  # type: ignore[arg-type]
    ends = np.quantile(sampled, [0.025, 0.975])
    assert known["σ′p"].interval == pytest.approx(ends, rel=0.03)
    assert known["σ′p"].interval[0] < known["σ′p"].value < known["σ′p"].interval[1]  # type: ignore[index]


def test_an_interval_of_POP_is_moved_by_the_initial_stress() -> None:
    """lambda*, kappa* and c act on p_p and, as much, on the stress that reaches it: they leave the interval alone."""
    problem, report = calibrated(c={"lower": 1, "upper": 50}, POP={"lower": 1, "upper": 60})
    assert report.statistics is not None
    found = report.statistics.linearisation
    assert found is not None
    low, high = found.interval("POP") or (math.nan, math.nan)
    (known,) = [
        v for v in laboratory_values(problem, problem.values(found.optimum.tolist()), found) if v.symbol == "σ′p"
    ]
    assert known.interval == pytest.approx((5.0 + low, 5.0 + high), rel=1e-9)


def test_the_report_of_a_test_has_table_figure_and_json(swarm: Run, tmp_path: Path) -> None:
    page = swarm.page
    (table,) = [t for t in swarm.report.content.tables if t.heading == "In the laboratory's terms"]
    symbols = ["Cc/(1 + e₀)", "Cs/(1 + e₀)", "Cα/(1 + e₀)", "σ′p"]
    assert [row[0] for row in table.rows] == [*symbols, "c_v", "k"]  # c_v and k of the readings alone
    assert "Give initial_void_ratio in the forward model" in table.note
    assert "Give initial_void_ratio" in page
    assert 'id="figure-compression"' in page
    header, rows = swarm.report.figures.rows("compression")
    assert header == ["stage", "stress_kPa", "quantity", "unit", "measured", "calculated"]
    assert rows[0] == [0, 0.2, "axial strain", "%", None, 0.0]
    assert len(rows) == 17
    observation = swarm.problem.observations[0]
    assert rows[16][4] == pytest.approx(100.0 * observation.y[-1] / 0.02021, rel=1e-12)
    assert swarm.result.best is not None
    last = float(swarm.result.best.responses["settlement"][-1])
    assert rows[16][5] == pytest.approx(100.0 * last / 0.02021, rel=1e-3)
    write_result(tmp_path / "result.json", swarm.problem, swarm.result, swarm.report.statistics)
    written = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))["laboratory"]
    assert [row["symbol"] for row in written] == symbols
    assert swarm.result.parameters is not None
    assert written[0]["value"] == pytest.approx(math.log(10.0) * swarm.result.parameters["lambda_star"], rel=1e-12)
    assert written[0]["interval"] is not None


@pytest.mark.slow  # tests/verification/test_primary_consolidation.py reads the same sentence of the result
def test_a_report_says_that_primary_consolidation_is_not_modelled(swarm: Run, sampling: Run, failed: Run) -> None:
    words = "Primary consolidation is not modelled"
    for run in (swarm, sampling):
        (note,) = [note for note in run.report.content.notes if words in note]
        assert "0 of 226 of settlement" in note
        assert words in run.page
    assert words not in failed.page


def test_readings_from_a_later_zero_keep_their_void_ratio() -> None:
    """Strain counts from stage 3; the void ratio goes on from what the model has there."""
    whole = problem_of("oedometer", [(20.0, 1.0), (40.0, 1.0), (100.0, 1.0)], model={"initial_void_ratio": E0})
    later = problem_of(
        "oedometer", [(20.0, 1.0), (40.0, 1.0), (100.0, 1.0)], model={"initial_void_ratio": E0, "zero_at_stage": 3}
    )
    (all_of_it,) = compression_curves(whole, whole.values([0.0]), None)
    (rest,) = compression_curves(later, later.values([0.0]), None)
    assert rest.calculated == pytest.approx(all_of_it.calculated, abs=1e-9)
    assert rest.calculated[0] == pytest.approx(E0, abs=1e-12)


def test_gross_errors_are_crosses_in_the_compression_curve() -> None:
    """Stage 2 is read wrongly: its strain is drawn as a cross at its stress, and counts nowhere."""
    stages = [(20.0, 1.0), (40.0, 1.0), (100.0, 1.0)]
    document = problem_of("oedometer", stages).document()
    points = {"x": [1, 2, 3], "y": [0.03, 0.5, 0.09]}
    document["observations"] = [{"series": "stage_axial_strain", "points": points, "gross_errors": [2]}]
    problem = parse_problem(document)
    (curve,) = compression_curves(problem, problem.values([0.0]), None)
    assert curve.measured_stages.tolist() == [1, 3]
    assert (curve.gross_stages.tolist(), curve.gross_stress.tolist()) == ([2], [40])
    assert curve.gross == pytest.approx([50.0], rel=1e-12)
    (axes,) = compression_figure("clay", curve).axes
    (crosses,) = [line for line in axes.get_lines() if line.get_label() == "gross error"]
    assert (crosses.get_marker(), crosses.get_xydata().tolist()) == ("x", [[40.0, 50.0]])
    legend = axes.get_legend()
    assert legend is not None
    assert "gross error" in [text.get_text() for text in legend.get_texts()]
    header, rows = compression_rows(curve)
    assert header[-1] == "gross error"
    assert [row[-1] for row in rows] == [None, None, pytest.approx(50.0, rel=1e-12), None]


def test_a_gross_error_of_one_gauge_is_one_of_the_volume() -> None:
    stages = [(20.0, 1.0), (40.0, 1.0)]
    document = problem_of("isotropic_compression", stages).document()
    axial, radial = [0.001, 0.002], [0.0001, 0.02]
    document["observations"] = [
        {"series": "stage_axial_displacement", "points": {"x": [1, 2], "y": axial}},
        {"series": "stage_radial_displacement", "points": {"x": [1, 2], "y": radial}, "gross_errors": [2]},
    ]
    problem = parse_problem(document)
    (curve,) = compression_curves(problem, problem.values([0.0]), None)
    assert (curve.measured_stages.tolist(), curve.gross_stages.tolist()) == ([1], [2])
    whole = 1.0 - (1.0 - 0.002 / 0.1) * (1.0 - 0.02 / 0.025) ** 2
    assert curve.gross == pytest.approx([100.0 * whole], rel=1e-12)


def test_each_test_of_a_combined_model_has_its_own() -> None:
    problem = load_problem(EXAMPLE.parents[1] / "combined" / "problem.yaml")
    values = problem.values([0.08, 0.04, 25.0, 2e-3])
    found = laboratory_values(problem, values, None)
    assert {v.part for v in found} == {"oedometer", "isotropic"}
    creep = {v.part: v.value for v in found if v.symbol.startswith("Cα")}
    assert creep["isotropic"] / creep["oedometer"] == pytest.approx(
        values["isotropic.mu_star"] / values["oedometer.mu_star"], rel=1e-12
    )
    confined, isotropic = compression_curves(problem, values, None)
    assert (confined.part, isotropic.part) == ("oedometer", "isotropic")
    assert isotropic.measured_stages.tolist() == [1, 2, 3]
    assert confined.measured.size == 8


def test_a_formula_has_none(failed: Run) -> None:
    assert laboratory_values(failed.problem, {"a": 1.0}, None) == ()
    assert not any(name.startswith("compression") for name in failed.report.figures.names)
