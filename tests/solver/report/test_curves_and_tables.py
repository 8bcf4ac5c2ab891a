"""Curves in the user's units, shares and files."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.weighting import series_shares
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.report.curves import objective_unit, series_curves
from geoswarm.solver.report.document.readings import gross_error_table, reading_notes
from geoswarm.solver.report.figures.fit_plot import fit_figure, fit_rows
from geoswarm.solver.report.folder.tables import write_evaluations, write_result
from geoswarm.solver.runs.local import calibrate
from tests.solver.problems import decay_document


@pytest.fixture(scope="module")
def problem() -> Problem:
    """Two straight lines, one measured in mm over minutes, its points not in order of x."""
    return parse_problem(
        {
            "name": "lines",
            "forward_model": {
                "kind": "formula",
                "series": {
                    "settlement": {
                        "expression": "rate * x",
                        "x_unit": "day",
                        "y_unit": "m",
                        "x_lower": 0.0,
                        "x_upper": 10.0,
                    },
                    "heave": {"expression": "-0.5 * rate * x", "x_unit": "day", "y_unit": "m"},
                },
            },
            "parameters": {"rate": {"lower": 1e-4, "upper": 1.0, "scale": "log"}},
            "observations": [
                {
                    "series": "settlement",
                    "points": {"x": [0.0, 1440.0, 2880.0], "y": [0.0, 5.0, 11.0]},
                    "x_unit": "min",
                    "y_unit": "mm",
                },
                {"series": "heave", "points": {"x": [1.0, 2.0], "y": [-0.003, -0.005]}, "weight": 3.0},
            ],
            "stopping": {"max_evaluations": 200},
            "seed": 3,
        }
    )


@pytest.fixture(scope="module")
def result(problem: Problem) -> CalibrationResult:
    """A short calibration."""
    return calibrate(problem)


def test_curves_are_in_the_users_units_and_end_at_the_last_point(problem: Problem) -> None:
    responses = {"settlement": np.array([0.0, 0.005, 0.010]), "heave": np.array([-0.0025, -0.005])}
    settlement, heave = series_curves(problem, responses, {"rate": 0.005})
    assert (settlement.x_unit, settlement.y_unit) == ("min", "mm")
    assert settlement.measured_x.tolist() == [0.0, 1440.0, 2880.0]
    assert settlement.at_points.tolist() == pytest.approx([0.0, 5.0, 10.0], rel=1e-12)
    assert settlement.x[-1] == 2880.0
    assert settlement.x.size > 20
    assert np.allclose(settlement.y, settlement.x / 288.0, rtol=1e-9, atol=1e-12)
    assert heave.x.tolist() == [1.0, 2.0]
    assert heave.y.tolist() == pytest.approx([-0.0025, -0.005], rel=1e-12)


def test_shares_add_up_to_the_objective(problem: Problem) -> None:
    shares = series_shares(problem, {"settlement": 2.0, "heave": 1.0})
    assert [(s.series, s.weight, s.misfit) for s in shares] == [("settlement", 1.0, 2.0), ("heave", 3.0, 1.0)]
    assert [s.share for s in shares] == pytest.approx([0.4, 0.6], rel=1e-12)
    assert shares[0].unit == "mm"
    assert shares[0].root_mean_square == pytest.approx(1000.0 * 2.0**0.5, rel=1e-12)  # misfits are in m²
    assert [s.share for s in series_shares(problem, {"settlement": 0.0, "heave": 0.0})] == [0.0, 0.0]


def test_unit_of_the_objective(problem: Problem) -> None:
    assert objective_unit(problem) == "m²"
    document = problem.document()
    document["forward_model"]["series"]["heave"]["y_unit"] = "kPa"
    document["observations"][1] |= {"y_unit": "kPa"}
    assert objective_unit(parse_problem(document)) == ""


def test_result_file_reproduces_the_objective(problem: Problem, result: CalibrationResult, tmp_path: Path) -> None:
    write_result(tmp_path / "result.json", problem, result)
    document = json.loads((tmp_path / "result.json").read_text(encoding="utf-8"))
    best = document["best"]
    again = 0.0
    for o in problem.observations:
        again += o.weight * float(np.mean((np.array(best["responses"][o.series]["y"]) - o.y) ** 2))
    assert document["objective"] == pytest.approx(again, rel=1e-12)


def test_evaluations_keep_every_digit(problem: Problem, result: CalibrationResult, tmp_path: Path) -> None:
    write_evaluations(tmp_path / "evaluations.csv", problem, result)
    header, *lines = (tmp_path / "evaluations.csv").read_text(encoding="utf-8").splitlines()
    place = header.split(",").index("rate")
    rates = [float(line.split(",")[place]) for line in lines]
    assert rates == [float(record.evaluation.parameters[0]) for record in result.history]


def test_gross_errors_stay_visible() -> None:
    points = {"x": [1.0, 2.0, 3.0], "y": [2.0, 90.0, 1.0]}
    note = "borehole 7"
    observed = [{"series": "y", "points": points, "gross_errors": [2], "notes": [note]}]
    problem = parse_problem(decay_document(observations=observed))
    values = problem.values([1.0 for _ in problem.free_names])
    responses = problem.model.prepare({o.series: o.x for o in problem.observations})(values)
    (curve,) = series_curves(problem, responses, values)
    assert (curve.gross_x.tolist(), curve.gross_y.tolist()) == ([2], [90])
    assert curve.measured_x.tolist() == [1, 3]
    assert fit_rows([curve])[1][-1][:5] == ["y", 2.0, curve.x_unit, 90.0, "gross error"]
    axes = fit_figure("fit", [curve]).axes[0]
    crosses = [line for line in axes.get_lines() if line.get_label() == "gross error"]
    assert [line.get_xydata().tolist() for line in crosses] == [[[2.0, 90.0]]]
    table = gross_error_table(problem)
    assert table is not None
    assert [row[1:] for row in table.rows] == [("2", "90")]
    assert list(reading_notes(problem)) == [f"Readings of y: {note}."]
