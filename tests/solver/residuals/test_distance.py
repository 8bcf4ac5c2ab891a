"""Distances of readings from a calculated curve: what they are, what they find, and what may be said with them."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import geoswarm as gs
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import design, from_evaluations
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.curves import series_curves
from geoswarm.solver.report.figures.fit_plot import fit_rows
from geoswarm.solver.residuals import CurveScale, residuals_of

X = np.linspace(0.0, 30.0, 121)
PLACE, HEIGHT, WIDTH = 21.0, 400.0, 1.2
WIDE = 4.0


def peak(x: FloatArray, place: float, height: float = HEIGHT, width: float = WIDTH) -> FloatArray:
    """A curve that rises to a peak and falls again."""
    return 5.0 * x + height * np.exp(-(((x - place) / width) ** 2))


def peaked(x: FloatArray = X, y: FloatArray | None = None, width: float = WIDTH, **keys: Any) -> Problem:
    y = peak(x, PLACE) if y is None else y
    return parse_problem(
        {
            "name": "peak",
            "forward_model": {
                "kind": "formula",
                "series": {
                    "q": {
                        "expression": f"5 * x + height * exp(-((x - place) / {width})**2)",
                        "x_unit": "%",
                        "y_unit": "kPa",
                    }
                },
            },
            "parameters": {
                "place": {"lower": 2, "upper": 28},
                "height": {"lower": 200, "upper": 800},
            },
            "observations": [{"series": "q", "points": {"x": x.tolist(), "y": y.tolist()}, **keys}],
            "stopping": {"max_evaluations": 200},
            "seed": 4,
        }
    )


def nearest(x: FloatArray, y: FloatArray, calculated: FloatArray, along: CurveScale) -> FloatArray:
    """Distances from all segments, one after the other."""
    curve = np.stack([x / along.x, calculated / along.y], axis=1)
    found = []
    for reading in np.stack([x / along.x, y / along.y], axis=1):
        steps = np.diff(curve, axis=0)
        share = np.clip(np.sum((reading - curve[:-1]) * steps, axis=1) / np.sum(steps**2, axis=1), 0.0, 1.0)
        found.append(np.linalg.norm(curve[:-1] + share[:, None] * steps - reading, axis=1).min())
    return np.sign(calculated - y) * np.array(found) * along.y


def test_the_distance_is_that_from_the_nearest_segment_with_the_sign_of_the_difference() -> None:
    random = np.random.default_rng(3)
    x = np.sort(random.uniform(0.0, 30.0, 60))
    y = peak(x, PLACE) + 20.0 * random.standard_normal(60)
    along = CurveScale(30.0, float(np.ptp(y)))
    curves = np.stack([peak(x, place) for place in (5.0, 20.0, 21.0)])
    expected = np.stack([nearest(x, y, curve, along) for curve in curves])
    np.testing.assert_allclose(residuals_of(x, y, curves, along), expected, rtol=1e-12, atol=1e-12)
    mixed = random.permutation(60)  # the curve runs along x, in whatever order the readings are
    np.testing.assert_allclose(residuals_of(x[mixed], y[mixed], curves[:, mixed], along), expected[:, mixed])


def test_it_is_the_difference_on_a_level_curve_and_less_on_a_steep_one() -> None:
    x, along = np.array([0.0, 1.0, 2.0, 3.0]), CurveScale(3.0, 6.0)
    level = residuals_of(x, np.zeros(4), np.full(4, 2.0), along)
    np.testing.assert_allclose(level, 2.0)
    steep = residuals_of(x, 2.0 * x, 2.0 * x + 1.0, along)  # 45 degrees in parts of the ranges
    np.testing.assert_allclose(steep[1:], 1.0 / np.sqrt(2.0))
    assert residuals_of(x, x, x, along).tolist() == [0.0] * 4


def test_a_shifted_peak_is_found_where_differences_of_y_show_no_way() -> None:
    along, across = (Calibration(peaked(**keys), 0) for keys in ({"distance": "orthogonal"}, {}))
    places = np.arange(4.0, 28.0)
    objectives = [
        np.array([one.evaluate(np.array([place, HEIGHT])).objective for place in places]) for one in (along, across)
    ]
    falling, flat = (found[places < PLACE - 2.0 * WIDTH] for found in objectives)
    assert (np.diff(falling) < 0.0).all()
    assert np.ptp(flat) < 0.05 * flat.max()
    start = np.array([6.0, 300.0])
    np.testing.assert_allclose(polish(along, start).parameters, [PLACE, HEIGHT], rtol=1e-3)
    assert polish(across, start).parameters[0] < PLACE - 5.0


def test_a_calibration_and_all_it_reports_have_the_distances() -> None:
    y = peak(X, PLACE) + 6.0 * np.random.default_rng(8).standard_normal(X.size)
    problem = peaked(y=y, distance="orthogonal")
    assert parse_problem(problem.document()).document()["observations"][0]["distance"] == "orthogonal"
    result = gs.calibrate(problem)
    assert result.parameters["place"] == pytest.approx(PLACE, abs=0.1)
    calculated = peak(X, result.parameters["place"], result.parameters["height"])
    expected = nearest(X, y, calculated, CurveScale(30.0, float(np.ptp(y))))
    np.testing.assert_allclose(result.statistics().residuals[0].residuals, expected, rtol=1e-6, atol=1e-6)
    assert result.objective == pytest.approx(np.mean(expected**2), rel=1e-6)
    curves = series_curves(problem, {"q": calculated}, result.parameters)
    header, rows = fit_rows(curves)
    np.testing.assert_allclose([row[header.index("residual")] for row in rows], expected, rtol=1e-9, atol=1e-9)
    (close,) = result.statistics().fit.closeness
    assert close.largest == pytest.approx(np.abs(expected).max(), rel=1e-6)


def scattered(width: float, size: float, seed: int) -> tuple[FloatArray, FloatArray]:
    """Readings of a peak with errors of the same part of the ranges along both axes."""
    random = np.random.default_rng(seed)
    x = X + size * 30.0 * random.standard_normal(X.size)
    y = peak(X, PLACE, width=width) + size * HEIGHT * random.standard_normal(X.size)
    return x, y


@pytest.mark.slow
def test_intervals_hold_for_errors_along_both_axes() -> None:
    truth, hits = np.array([PLACE, HEIGHT]), np.zeros(2)
    for seed in range(200):
        x, y = scattered(WIDE, 0.005, seed)
        calibration = Calibration(peaked(x, y, WIDE, distance="orthogonal", sort=True), 0)
        optimum = polish(calibration, truth).parameters
        plan = design(calibration, optimum)
        found = from_evaluations(calibration, plan, [calibration.evaluate(place) for place in plan.positions])
        hits += (found.intervals[0] <= truth) & (truth <= found.intervals[1])
    assert ((hits >= 0.92 * 200) & (hits <= 0.995 * 200)).all(), hits


@pytest.mark.parametrize(
    ("points", "message"),
    [
        ({"x": [1, 2], "y": [1, 2]}, "orthogonal needs at least 3 readings that take part, got 2; use vertical"),
        ({"x": [1, 2, 3], "y": [4, 4, 4]}, "needs readings that vary, but q is the same in all; use vertical"),
    ],
)
def test_readings_without_a_curve_are_refused(points: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        peaked(np.array(points["x"], dtype=float), np.array(points["y"], dtype=float), distance="orthogonal")
    assert str(caught.value).count("observations[0].distance") == 1
    assert message in str(caught.value)


def test_stage_numbers_are_no_curve() -> None:
    document = {
        "name": "stages",
        "forward_model": {
            "kind": "oedometer",
            "material": "soft_soil_creep",
            "height": 0.02,
            "initial_stress": 1.0,
            "stages": [{"stress": load, "duration": 1} for load in (10, 20, 40)],
        },
        "parameters": {name: {"value": value} for name, value in
                       {"kappa_star": 0.01, "mu_star": 0.001, "c": 1, "phi": 25, "psi": 0}.items()}
        | {"lambda_star": {"lower": 0.01, "upper": 0.5}},
        "observations": [
            {"series": "stage_settlement", "points": {"x": [1, 2, 3], "y": [0, 5e-4, 1e-3]}, "distance": "orthogonal"}
        ],
        "stopping": {"max_evaluations": 10},
    }  # fmt: skip
    with pytest.raises(ProblemError, match=r"orthogonal needs x along which the curve runs, but stage only counts"):
        parse_problem(document)
