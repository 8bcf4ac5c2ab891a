"""Intervals under dependent noise, against the same formulas written out with full matrices."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.linalg import null_space, toeplitz
from scipy.optimize import brentq
from scipy.stats import t

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import from_evaluations
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.identifiability.residuals.dependence import (
    Dependence,
    allowed_deviations,
    dependence_in_words,
    dependence_of,
)
from geoswarm.solver.problem import parse_problem
from tests.solver.identifiability.cases import WHITE, free, linearised, problem_of

COUNT = 30
X = np.linspace(0.0, 2.0, COUNT)
JACOBIAN = np.stack([np.ones(COUNT), X], axis=1)
BASIS = np.linalg.qr(JACOBIAN)[0]
INVERSE = np.linalg.pinv(JACOBIAN)
QUANTILE = float(t.ppf(0.975, COUNT - 2))


def correlated_residuals(rho: float) -> FloatArray:
    random = np.random.default_rng(4)
    noise = random.normal(0.0, 1.0, COUNT)
    for i in range(1, COUNT):
        noise[i] = rho * noise[i - 1] + np.sqrt(1.0 - rho**2) * noise[i]
    return np.asarray(noise - BASIS @ (BASIS.T @ noise))


def prior(grid: FloatArray) -> FloatArray:
    """Half for independent noise, half even in arctanh rho."""
    shares = 1.0 / (1.0 - grid**2)
    shares[0] = shares[1:].sum()
    return shares


def half_widths(residuals: FloatArray, found: Dependence) -> FloatArray:
    deviations = np.full(COUNT, np.sqrt(residuals @ residuals / (COUNT - 2)))
    places = np.arange(COUNT)
    return QUANTILE * allowed_deviations(INVERSE, deviations, residuals, BASIS, [(found, places)], X, 0.95, QUANTILE)


def test_the_interval_of_correlated_noise_is_the_mixture_over_rho() -> None:
    residuals = correlated_residuals(0.7)
    found = dependence_of("y", residuals, BASIS, X, correlated=True)
    assert found is not None
    outside = null_space(JACOBIAN.T)  # the residuals' own coordinates
    own = outside.T @ residuals
    grid = np.linspace(0.0, 0.98, 50)
    logarithms, spreads = [], []
    for rho in grid:
        matrix = toeplitz(rho ** np.arange(COUNT))
        inside = outside.T @ matrix @ outside
        squares = float(own @ np.linalg.solve(inside, own))
        logarithms.append(-0.5 * np.linalg.slogdet(inside)[1] - 0.5 * (COUNT - 2) * np.log(squares))
        spreads.append(np.sqrt(squares / (COUNT - 2) * np.diag(INVERSE @ matrix @ INVERSE.T)))
    shares = np.exp(np.array(logarithms) - max(logarithms)) * prior(grid)
    shares /= shares.sum()
    assert found.rho == pytest.approx(grid[np.argmax(logarithms)])

    def missing(half: float, index: int) -> float:
        return float(shares @ [2.0 * t.sf(half / s[index], COUNT - 2) for s in spreads]) - 0.05

    expected = [brentq(missing, 1e-6, 100.0, args=(index,)) for index in range(2)]
    np.testing.assert_allclose(half_widths(residuals, found), expected, rtol=1e-4)


def test_the_interval_of_uneven_noise_is_that_of_hc3() -> None:
    noise = np.random.default_rng(2).normal(0.0, 1.0, COUNT) * X**2
    residuals = noise - BASIS @ (BASIS.T @ noise)
    found = dependence_of("y", residuals, BASIS, X, correlated=False)
    assert found is not None
    assert found.kind == "uneven"
    leverage = np.diag(BASIS @ BASIS.T)
    shares = INVERSE**2 * (residuals / (1.0 - leverage)) ** 2
    degrees = 3.0 * shares.sum(axis=1) ** 2 / (shares**2).sum(axis=1) - 2.0
    expected = t.ppf(0.975, np.maximum(degrees, 2.0)) * np.sqrt(shares.sum(axis=1))
    np.testing.assert_allclose(half_widths(residuals, found), expected, rtol=1e-9)


@pytest.mark.parametrize(("count", "least", "most"), [(5, 1.3, 4.0), (15, 1.1, 1.8), (49, 1.0, 1.1), (50, 1.0, 1.0)])
def test_few_readings_cannot_exclude_a_correlation(count: int, least: float, most: float) -> None:
    """Even and independent residuals; 50 show that they are."""
    x = np.linspace(0.0, 2.0, count)
    y = 3.0 + 0.1 * np.cos(1.7 * np.arange(count))
    given = {name: free(-9.0, 9.0) for name in "ab"}
    white, unknown, correlated = (
        linearised(problem_of("a + b * x", given, y, x, **changes), np.polyfit(x, y, 1)[::-1].tolist())
        for changes in ({"noise": WHITE}, {}, {"noise": {"kind": "correlated"}})
    )
    assert white.bases == ("linearised", "linearised")
    assert not white.dependence
    assert correlated.bases[0] == "stated"
    ratio = np.diff(unknown.intervals, axis=1) / np.diff(white.intervals, axis=1)
    assert least <= ratio.min()
    assert ratio.max() <= most
    assert (np.diff(correlated.intervals, axis=1)[0] > np.diff(unknown.intervals, axis=1)[0]).all()
    if count < 50:
        words = f"widened by a factor of {ratio[0, 0]:.2g} for a correlation that so few readings cannot exclude"
        assert (words in unknown.interval_in_words("a")) == (ratio[0, 0] >= 1.05)  # a factor of 1 is not said
        assert not unknown.departures
    else:
        assert not unknown.dependence


def test_noise_is_stated_for_one_series_alone() -> None:
    """Of two series, what is known of one says nothing of the other."""
    x = np.linspace(0.0, 2.0, 12)
    scatter = 0.1 * np.cos(1.7 * np.arange(12))
    model = {"kind": "formula", "series": {"u": "a + b * x", "v": "a - b * x"}}
    points = [{"series": name, "points": {"x": x.tolist(), "y": (3.0 + scatter).tolist()}} for name in model["series"]]
    given = {name: free(-9.0, 9.0) for name in "ab"}
    kinds = {}
    for kind in ("white", "correlated"):
        noise = {"kind": kind, "series": ["u"]}
        document = {"forward_model": model, "parameters": given, "observations": points, "noise": noise}
        problem = parse_problem(document | {"stopping": {"max_evaluations": 30}})
        assert problem.document()["noise"] == noise
        kinds[kind] = {one.series: one.kind for one in linearised(problem, [3.0, 0.0]).dependence}
    assert kinds == {"white": {"v": "possible"}, "correlated": {"u": "stated", "v": "possible"}}


def test_standard_errors_do_not_allow_for_dependence_and_intervals_are_never_narrower() -> None:
    problem = problem_of("a + b * x", {"a": free(-9.0, 9.0), "b": free(-9.0, 9.0)}, 1.0 + correlated_residuals(0.9), X)
    calibration = Calibration(problem, 1)
    best = polish(calibration, np.array([1.0, 0.0]))
    found = from_evaluations(calibration, *evaluate_differences(calibration, best.parameters))
    assert found.dependence
    assert found.bases == ("correlated", "correlated")
    squares = best.objective * COUNT
    classical = np.sqrt(squares / (COUNT - 2) * np.diag(np.linalg.inv(JACOBIAN.T @ JACOBIAN)))
    np.testing.assert_allclose(found.standard_errors, classical, rtol=1e-6)
    assert (np.diff(found.intervals, axis=1)[:, 0] > 2.0 * QUANTILE * classical).all()
    assert "for correlated residuals" in found.interval_in_words("b")
    # an error that is stated and larger than the residuals is not undercut by them
    stated = from_evaluations(calibration, *evaluate_differences(calibration, best.parameters), noise=5.0)
    usual = 1.959964 * 5.0 * np.sqrt(np.diag(np.linalg.inv(JACOBIAN.T @ JACOBIAN)))
    np.testing.assert_allclose(np.diff(stated.intervals, axis=1)[:, 0], 2.0 * usual, rtol=1e-5)


def test_the_interval_of_uneven_readings_weighs_order_against_distance() -> None:
    """The mixture over both ways, written out with full matrices."""
    x = np.sort(np.random.default_rng(3).uniform(0.0, 2.0, COUNT))
    jacobian = np.stack([np.ones(COUNT), x], axis=1)
    basis, inverse = np.linalg.qr(jacobian)[0], np.linalg.pinv(jacobian)
    steps = np.clip(np.diff(x) / np.median(np.diff(x)), 0.05, 1e3)
    places = np.append(0.0, np.cumsum(steps))
    random = np.random.default_rng(9)
    noise = np.linalg.cholesky(0.7 ** np.abs(places[:, None] - places)) @ random.normal(size=COUNT)
    residuals = noise - basis @ (basis.T @ noise)
    found = dependence_of("y", residuals, basis, x, correlated=True)
    assert found is not None
    outside = null_space(jacobian.T)
    own = outside.T @ residuals
    logarithms, spreads, worth = [], [], []
    for way in (np.arange(COUNT, dtype=np.float64), places):
        for rho in np.linspace(0.0, 0.98, 50):
            matrix = rho ** np.abs(way[:, None] - way)
            inside = outside.T @ matrix @ outside
            squares = float(own @ np.linalg.solve(inside, own))
            logarithms.append(-0.5 * np.linalg.slogdet(inside)[1] - 0.5 * (COUNT - 2) * np.log(squares))
            spreads.append(np.sqrt(squares / (COUNT - 2) * np.diag(inverse @ matrix @ inverse.T)))
            worth.append(COUNT**2 / matrix.sum())
    best = int(np.argmax(logarithms))
    assert found.by_x == (best >= 50)
    assert found.effective == pytest.approx(max(worth[best], 1.0))
    shares = np.exp(np.array(logarithms) - max(logarithms)) * np.tile(prior(np.linspace(0.0, 0.98, 50)), 2)
    shares /= shares.sum()

    def missing(half: float, index: int) -> float:
        return float(shares @ [2.0 * t.sf(half / s[index], COUNT - 2) for s in spreads]) - 0.05

    expected = [brentq(missing, 1e-6, 100.0, args=(index,)) for index in range(2)]
    deviations = np.full(COUNT, np.sqrt(residuals @ residuals / (COUNT - 2)))
    allowed = allowed_deviations(inverse, deviations, residuals, basis, [(found, np.arange(COUNT))], x, 0.95, QUANTILE)
    np.testing.assert_allclose(QUANTILE * allowed, expected, rtol=1e-4)


def test_many_series_have_one_sentence() -> None:
    found = [Dependence(f"t{place}.q", "correlated", 0.9 + 0.01 * place, 100, 5.0) for place in range(4)]
    assert dependence_in_words(found) == [
        "4 series: neighbouring residuals are correlated (0.90 to 0.93), so 400 readings are equivalent to 20 "
        "independent ones; intervals allow for that, standard errors do not."
    ]
    uneven = [Dependence("u", "uneven", 0.0, 100, 100.0)]
    assert dependence_in_words([*found[:2], *uneven]) == [one.sentence for one in (*found[:2], *uneven)]
