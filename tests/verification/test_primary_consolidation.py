"""An oedometer test with primary consolidation under the creep law: what is said of it, and what then helps."""

from __future__ import annotations

from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.problem.checks.consolidation import find_consolidation
from geoswarm.solver.report.document.build import Report, report_of_result
from geoswarm.solver.runs.local import calibrate
from geoswarm.verification.exact.consolidation import degree

DAY = 1440.0  # min
TIMES = np.unique(np.round(np.geomspace(0.1, DAY, 24), 2))
TRUTH = {"lambda_star": 0.08, "kappa_star": 0.012, "mu_star": 0.005, "POP": 30.0}
X = np.concatenate([stage * DAY + TIMES for stage in range(6)])


def problem_of(y: FloatArray, **selection: Any) -> Problem:
    given: dict[str, Any] = {
        "forward_model": {
            "kind": "oedometer",
            "material": "soft_soil_creep",
            "discretization": "material_point",
            "height": 0.02,
            "initial_stress": 5.0,
            "stages": [{"stress": stress, "duration": 1} for stress in (12.5, 25, 50, 100, 200, 400)],
        },
        "parameters": {
            "lambda_star": {"lower": 0.01, "upper": 0.3, "scale": "log"},
            "kappa_star": {"lower": 0.002, "upper": 0.1, "scale": "log"},
            "mu_star": {"lower": 0.0003, "upper": 0.05, "scale": "log"},
            "POP": {"lower": 1, "upper": 100},
            "c": {"value": 5},
            "phi": {"value": 25},
            "psi": {"value": 0},
        },
        "constraints": ["lambda_star > kappa_star"],
        "observations": [
            {"series": "settlement", "points": {"x": X.tolist(), "y": y.tolist()}, "x_unit": "min", "y_unit": "mm"}
            | selection
        ],
        "method": {"kind": "particle_swarm", "particles": 12, "polish": True},
        "stopping": {"max_evaluations": 1200},
        "seed": 3,
    }
    return parse_problem(given)


def measured(*, primary: bool) -> FloatArray:
    """Settlement [mm]: the creep law, of each stage the consolidated part; c_v = 1e-8 m2/s, both ends drained."""
    calibration = Calibration(problem_of(np.zeros(X.size)), 1)
    y = calibration.evaluate(np.array(list(TRUTH.values()))).responses["settlement"] * 1e3
    starts = np.repeat([0.0, *y[TIMES.size - 1 : -1 : TIMES.size]], TIMES.size)
    share = degree(1e-8 * np.tile(TIMES, 6) * 60.0 / 0.01**2) if primary else 1.0
    return np.asarray(starts + (y - starts) * share + np.random.default_rng(5).normal(0.0, 0.004, X.size))


def report_of(problem: Problem) -> Report:
    return report_of_result(problem, calibrate(problem))


def test_primary_consolidation_is_said_first_and_leaving_it_out_helps() -> None:
    y = measured(primary=True)
    problem = problem_of(y)
    (found,) = find_consolidation(problem)
    # t90 = 0.848 H^2 / c_v with the drainage path of 10 mm: 141 min
    np.testing.assert_allclose(found.t90, 141.3, rtol=0.25)

    first = report_of(problem)
    assert first.statistics is not None
    assert first.statistics.fit.kind == "lack_of_fit"
    assert "identified" not in {verdict.kind for verdict in first.statistics.verdicts}
    page = first.html()
    assert "✓" not in page
    assert page.index("does not describe the data") < page.index("Verdicts")
    assert page.index("stage_x_from") < page.index("Verdicts")
    assert "the interval does not hold" in page

    second = report_of(problem_of(y, stage_x_from=round(found.t100)))
    assert second.statistics is not None
    assert second.statistics.fit.kind == "describes"
    assert second.statistics.linearisation is not None
    low, high = second.statistics.linearisation.interval("mu_star") or (np.nan, np.nan)
    assert low <= TRUTH["mu_star"] <= high


def test_creep_alone_is_no_consolidation() -> None:
    assert find_consolidation(problem_of(measured(primary=False))) == ()


def test_a_stated_error_that_is_not_met_is_said_everywhere() -> None:
    problem = problem_of(measured(primary=True), error=0.006)
    statistics = report_of(problem).statistics
    assert statistics is not None
    assert statistics.fit.wrong
    assert any(misfit.reason == "stated_error" for misfit in statistics.fit.misfits)
    assert "stated error is not met: the residuals of settlement" in statistics.fit.sentence
    assert statistics.linearisation is not None
    assert statistics.linearisation.to_json()["fit"]["kind"] == statistics.fit.kind
