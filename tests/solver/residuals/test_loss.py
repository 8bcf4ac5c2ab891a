"""Robust losses against SciPy's least squares with the same loss."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.identifiability import Linearisation, from_evaluations
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import Polished, polish
from geoswarm.solver.identifiability.residuals.independence import examine_residuals
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.curves import series_curves
from geoswarm.solver.residuals import TUNING, Loss, LossKind
from tests.solver.identifiability.cases import free, problem_of

KINDS: tuple[LossKind, ...] = ("soft_l1", "huber", "cauchy")
X = np.linspace(0.0, 2.0, 30)
FAR = [3, 11, 20]


def measured() -> FloatArray:
    y = 1.0 + 2.0 * np.exp(-1.5 * X) + np.random.default_rng(1).normal(0.0, 0.1, X.size)
    y[FAR] += [2.0, -1.5, 1.0]
    return np.asarray(y)


def problem(y: FloatArray, **loss: Any) -> Problem:
    section = {"series": "y", "points": {"x": X.tolist(), "y": y.tolist()}, **loss}
    parameters = {"a": free(-9.0, 9.0), "b": free(-9.0, 9.0), "c": free(0.1, 9.0)}
    return problem_of("a + b * exp(-c * x)", parameters, y, X, observations=[section])


def fitted(given: Problem) -> tuple[Calibration, Polished, Linearisation]:
    calibration = Calibration(given, 1)
    best = polish(calibration, np.array([1.0, 1.5, 1.0]))
    return calibration, best, from_evaluations(calibration, *evaluate_differences(calibration, best.parameters))


@pytest.mark.parametrize("kind", KINDS)
def test_the_optimum_is_that_of_scipy(kind: LossKind) -> None:
    y = measured()
    _, best, found = fitted(problem(y, loss=kind, loss_scale=0.15))
    reference = least_squares(
        lambda p: p[0] + p[1] * np.exp(-p[2] * X) - y, [1.0, 1.5, 1.0], loss=kind, f_scale=0.15, xtol=1e-12, gtol=1e-12
    )
    np.testing.assert_allclose(best.parameters, reference.x, rtol=1e-5)
    assert best.objective == pytest.approx(2.0 * reference.cost / X.size, rel=1e-9)
    assert found.at_optimum
    # the outliers carry it no more: three standard errors of the readings without them hold the truth
    assert (np.abs(best.parameters - [1.0, 2.0, 1.5]) <= 3.0 * found.standard_errors).all()


@pytest.mark.parametrize("kind", KINDS)
def test_derivatives_are_those_of_differences(kind: LossKind) -> None:
    loss = Loss(kind, 1.0)
    z = np.array([-30.0, -2.0, -0.4, 0.3, 0.9, 1.7, 50.0])
    h = 1e-6
    np.testing.assert_allclose(loss.weight(z), (loss.rho(z + h) - loss.rho(z - h)) / (4.0 * h * z), rtol=1e-6)
    psi = [(z + d) * loss.weight(z + d) for d in (h, -h)]
    np.testing.assert_allclose(loss.slope(z), (psi[0] - psi[1]) / (2.0 * h), rtol=1e-4, atol=1e-8)
    np.testing.assert_allclose(loss.root_slope(z), (loss.root(z + h) - loss.root(z - h)) / (2.0 * h), rtol=1e-5)
    np.testing.assert_allclose(loss.root(z) ** 2, loss.rho(z), rtol=1e-12)
    assert loss.root_slope(np.zeros(1)) == pytest.approx(1.0)
    assert np.isfinite(loss.rho(np.array([1e200]))).all()


@pytest.mark.parametrize("kind", KINDS)
def test_the_scale_gives_95_percent_of_the_precision(kind: LossKind) -> None:
    z = np.linspace(-12.0, 12.0, 240_001)
    density = np.exp(-0.5 * z * z) / np.sqrt(2.0 * np.pi)
    loss, scaled = Loss(kind, 1.0), z / TUNING[kind]
    slope = np.trapezoid(loss.slope(scaled) * density, z)
    square = np.trapezoid((TUNING[kind] * scaled * loss.weight(scaled)) ** 2 * density, z)
    assert slope**2 / square == pytest.approx(0.95, abs=2e-3)


@pytest.mark.parametrize("kind", KINDS)
def test_the_covariance_is_the_sandwich_of_huber(kind: LossKind) -> None:
    _, best, found = fitted(problem(measured(), loss=kind, loss_scale=0.3))
    a, b, c = best.parameters
    decay = np.exp(-c * X)
    jacobian = np.stack([np.ones_like(X), decay, -b * X * decay], axis=1)
    z = (a + b * decay - measured()) / 0.3
    loss = Loss(kind, 0.3)
    psi, slope = 0.3 * z * loss.weight(z), loss.slope(z)
    factor = 1.0 + 3.0 / X.size * slope.var() / slope.mean() ** 2
    variance = factor**2 * np.sum(psi**2) / (X.size - 3) / slope.mean() ** 2
    expected = np.sqrt(variance * np.diag(np.linalg.inv(jacobian.T @ jacobian)))
    np.testing.assert_allclose(found.standard_errors, expected, rtol=1e-4)


def test_a_wide_scale_is_least_squares() -> None:
    _, plain, usual = fitted(problem(measured()))
    _, wide, found = fitted(problem(measured(), loss="soft_l1", loss_scale=1e4))
    np.testing.assert_allclose(wide.parameters, plain.parameters, rtol=1e-4)
    np.testing.assert_allclose(found.intervals, usual.intervals, rtol=1e-4)


def test_outliers_are_marked() -> None:
    given = problem(measured(), loss="cauchy", error=0.1)
    assert parse_problem(given.document()) == given
    calibration, best, _ = fitted(given)
    residuals = examine_residuals(calibration, best.evaluation.responses)[0]
    assert residuals.outliers == 3
    assert residuals.to_json()["outliers"] == 3
    curve = series_curves(given, best.evaluation.responses, given.values(best.parameters.tolist()))[0]
    assert np.flatnonzero(curve.outliers).tolist() == FAR


def test_the_scale_is_in_the_unit_of_the_readings() -> None:
    loss = problem(measured(), loss="huber", error=0.2).observations[0].loss
    assert loss == Loss("huber", 1.345 * 0.2)


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({"loss": "huber"}, "needs a scale; give loss_scale, or the error"),
        ({"loss_scale": 0.1}, "give loss as well"),
        ({"loss": "huber", "loss_scale": 0.0}, "loss_scale"),
        ({"loss": "huber", "loss_scale": 1e-200}, "must be from 1e-150"),
        ({"loss": "tukey", "loss_scale": 1.0}, "soft_l1"),
    ],
)
def test_what_makes_no_sense_is_refused(section: dict[str, Any], words: str) -> None:
    with pytest.raises(ProblemError, match=words):
        problem(measured(), **section)
