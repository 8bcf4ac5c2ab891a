"""Leaving out one test at a time: against refits, and intervals where tests differ by more than their readings."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares
from scipy.stats import t as student

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability import Linearisation, Samples, Statistics, StatisticsError, analyse
from geoswarm.solver.identifiability.errors import NotExaminedError
from geoswarm.solver.identifiability.optimum.differences import residual_rows
from geoswarm.solver.identifiability.optimum.leaving_out import WithoutTests
from geoswarm.solver.identifiability.optimum.refitted import natural_moves, notes_on, with_refits
from geoswarm.solver.identifiability.stored.findings import Findings, findings_of, join_findings
from geoswarm.solver.identifiability.stored.follow_ups import jackknife_problem
from geoswarm.solver.methods.jackknife import JackknifeMethod
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.document.uncertainty_tables import left_out_table
from geoswarm.solver.report.figures.labels import parameter_labels
from geoswarm.solver.search.runs import Runs
from geoswarm.solver.search.space import SearchSpace
from tests.solver.identifiability.cases import X, free, linearised


def several(slopes: FloatArray, noise: FloatArray, expression: str = "a + b * x", **changes: Any) -> Problem:
    """Tests on one straight line, each with its own slope, in one problem."""
    names = [f"test_{number + 1}" for number in range(len(slopes))]
    curves = [2.0 + slope * X + own for slope, own in zip(slopes.tolist(), noise, strict=True)]
    document = {
        "forward_model": {
            "kind": "combined",
            "parts": {name: {"kind": "formula", "series": {"y": expression}} for name in names},
        },
        "parameters": {"a": free(-10.0, 10.0), "b": free(-8.0, 10.0)},
        "observations": [
            {"series": f"{name}.y", "points": {"x": X.tolist(), "y": y.tolist()}}
            for name, y in zip(names, curves, strict=True)
        ],
    }
    return parse_problem(document | {"stopping": {"max_evaluations": 100}} | changes)


def at_optimum(problem: Problem) -> tuple[Linearisation, FloatArray]:
    """At the least-squares line of all readings, and those without each test, shape (G, 2)."""
    y = np.array([o.y for o in problem.observations])

    def line(rows: FloatArray) -> FloatArray:
        return np.asarray(np.polyfit(np.tile(X, len(rows)), rows.ravel(), 1)[::-1])

    alone = np.array([line(np.delete(y, row, axis=0)) for row in range(len(y))])
    return linearised(problem, line(y).tolist()), alone


def test_values_without_a_test_are_those_of_a_refit() -> None:
    rng = np.random.default_rng(3)
    problem = several(np.array([2.0, 2.2, 1.7, 2.1]), 0.05 * rng.normal(size=(4, X.size)))
    found, refitted = at_optimum(problem)
    assert found.without is not None
    assert found.without.tests == ("test_1", "test_2", "test_3", "test_4")
    assert found.without.values == pytest.approx(refitted, rel=1e-6)
    assert found.without.pulling("b") == "test_3"
    deviations = np.sqrt(3.0 / 4.0 * ((refitted - refitted.mean(axis=0)) ** 2).sum(axis=0))
    assert np.ptp(found.without.intervals, axis=1) == pytest.approx(2.0 * student.ppf(0.975, 3) * deviations, rel=1e-6)


def test_intervals_of_tests_that_differ_are_those_between_the_tests() -> None:
    rng = np.random.default_rng(3)
    found, _ = at_optimum(several(np.array([2.0, 2.6, 1.3, 2.1, 2.4]), 0.05 * rng.normal(size=(5, X.size))))
    assert found.fit.kind == "lack_of_fit"
    assert found.basis("b") == "tests"
    assert found.without is not None
    assert found.intervals[1] == pytest.approx(found.without.intervals[1], rel=1e-9)
    assert " for tests that differ" in found.interval_in_words("b")
    alike, _ = at_optimum(several(np.full(5, 2.0), 0.05 * rng.normal(size=(5, X.size))))
    assert alike.fit.kind == "describes"
    assert alike.basis("b") != "tests"


def test_a_parameter_of_one_test_alone_has_no_interval_between_tests() -> None:
    problem = several(np.array([2.0, 2.6, 1.3]), np.zeros((3, X.size)))
    document = problem.document()
    document["forward_model"]["parts"]["test_1"]["series"]["y"] = "a + b * x + c * x**2"
    document["parameters"]["c"] = free(-1.0, 1.0)
    found = linearised(parse_problem(document), [2.0, 2.0, 0.0])
    assert found.without is not None
    assert np.isnan(found.without.values[0, 2])
    assert np.isfinite(found.without.values[1:]).all()
    assert np.isnan(found.without.intervals[2]).all()
    assert found.interval("c") is not None
    row = found.to_json()["without_tests"]["parameters"]["c"]
    assert row["interval"] is None
    assert row["values"]["test_1"] is None
    table = left_out_table(found.without, parameter_labels(problem) | parameter_labels(parse_problem(document)))
    assert table.rows[0] == ("all tests", "2", "2", "0")
    assert table.rows[1][3] == "–"


def test_two_tests_say_nothing_of_tests() -> None:
    assert at_optimum(several(np.array([2.0, 2.5]), np.zeros((2, X.size))))[0].without is None


def judged(problem: Problem, found: Linearisation) -> Statistics:
    """Statistics with the optimum as the best of a few evaluations."""
    positions = found.optimum + 0.01 * np.eye(len(found.names), 5, 1).T
    samples = Samples.from_arrays(problem, positions, 1.0 + np.arange(5.0))
    return analyse(Calibration(problem, 1), samples, linearisation=found)


def test_tests_that_differ_leave_the_parameters_of_this_model_identified() -> None:
    rng = np.random.default_rng(3)
    problem = several(np.array([2.0, 2.6, 1.3, 2.1, 2.4]), 0.05 * rng.normal(size=(5, X.size)))
    found, _ = at_optimum(problem)
    statistics = judged(problem, found)
    verdict = statistics.verdict("b")
    assert verdict.kind == "identified"
    assert verdict.words == "identified within one basin, for this model"  # the few evaluations leave room for others
    assert "it counts each of the 5 tests as one piece of information" in verdict.sentence
    assert statistics.fit.kind == "lack_of_fit"
    assert (statistics.fit.tests, statistics.fit.caution) == (5, "")
    assert statistics.fit.words == "the model does not describe the data"
    assert "their intervals count each of the 5 tests as one piece of information" in statistics.fit.sentence


def test_without_several_tests_a_wrong_model_identifies_nothing() -> None:
    rng = np.random.default_rng(3)
    problem = several(np.array([2.0, 2.6]), 0.05 * rng.normal(size=(2, X.size)))
    found, _ = at_optimum(problem)
    fit = judged(problem, found).fit
    assert judged(problem, found).verdict("b").kind == "lack_of_fit"
    assert (fit.tests, fit.caution) == (0, "the model does not describe the data: the interval does not hold")
    assert fit.words.endswith("so no interval holds")


def test_what_a_single_test_determines_is_not_identified_by_a_wrong_model() -> None:
    problem = several(np.array([2.0, 2.6, 1.3]), 0.05 * np.random.default_rng(3).normal(size=(3, X.size)))
    document = problem.document()
    document["forward_model"]["parts"]["test_1"]["series"]["y"] = "a + b * x + c"
    document["parameters"]["c"] = free(-9.0, 10.0)
    widened = parse_problem(document)
    rows = np.array([[1.0, x, float(g == 0)] for g in range(3) for x in X.tolist()])
    best = np.linalg.lstsq(rows, np.concatenate([o.y for o in widened.observations]))[0]
    found = linearised(widened, best.tolist())
    assert found.fit.tests == 3
    verdicts = judged(widened, found)
    assert [verdicts.verdict(name).kind for name in "bc"] == ["identified", "lack_of_fit"]


def test_how_close_is_said_by_quantity_over_all_tests() -> None:
    """Residuals, root mean square and peaks by hand: test 1 misses by 0.5 throughout, test 2 by -0.3, test 3 not."""
    problem = several(np.array([2.0, 2.0, 2.0]), np.array([[0.5], [-0.3], [0.0]]) * np.ones_like(X))
    document = problem.document()
    for part in document["forward_model"]["parts"].values():
        part["series"] = {"q": part["series"]["y"]}
    for observation in document["observations"]:
        observation["series"] = observation["series"].replace(".y", ".q")
    (close,) = linearised(parse_problem(document), [2.0, 2.0]).fit.closeness
    peak = 2.0 + 2.0 * X.max()
    assert (close.quantity, close.series, close.unit) == ("q", 3, "")
    assert close.largest == pytest.approx(0.5)
    assert close.deviation == pytest.approx(np.sqrt((0.25 + 0.09) / 3.0))
    assert close.peak == pytest.approx(0.5 / (peak + 0.5))


@pytest.mark.slow
@pytest.mark.parametrize("tests", [3, 5, 10])
def test_intervals_cover_the_mean_of_specimens_that_scatter(tests: int) -> None:
    """200 data bases: slopes of specimens scatter by 10 %, and no specimen has the curvature of the model.

    A 95 % interval covers 91 to 98.5 % of 200 with a chance of 99.7 %.
    """
    rng = np.random.default_rng(11)
    covered = []
    for _ in range(200):
        noise = 0.05 * rng.normal(size=(tests, X.size)) + 0.1 * np.sin(2.0 * X)
        found, _ = at_optimum(several(2.0 + 0.2 * rng.normal(size=tests), noise))
        low, high = found.intervals[1]
        middle = 2.0 + np.polyfit(X, 0.1 * np.sin(2.0 * X), 1)[0]  # what this model makes of the missing mechanism
        covered.append(low <= middle <= high)
    assert 0.91 <= np.mean(covered) <= 0.985


def fitted_without(problem: Problem, found: Linearisation, runs: int | None = None) -> tuple[Findings, int]:
    """What the fits without each test find, restored from their snapshot at every generation, and their runs."""
    question = jackknife_problem(problem, found, seed=1, runs=runs)
    calibration, method = Calibration(question, 1), question.method
    assert isinstance(method, JackknifeMethod)
    done: list[Evaluation] = []
    search = method.search(calibration.space, question.series_by_test)
    while (due := search.ask()) is not None:
        done += [calibration.evaluate(position) for position in due]
        rows = residual_rows(calibration, done)
        objectives = np.array([np.inf if one.objective is None else one.objective for one in done[-len(due) :]])
        search.tell(objectives, Runs.of(np.array([one.parameters for one in done]), rows))
        search = method.search(calibration.space, question.series_by_test, json.loads(json.dumps(search.snapshot())))
    assert len(done) <= method.runs
    return findings_of(question, 1, done), len(done)


def test_fits_without_each_test_are_exact_for_a_linear_model() -> None:
    rng = np.random.default_rng(3)
    problem = several(np.array([2.0, 2.2, 1.7, 2.1]), 0.05 * rng.normal(size=(4, X.size)))
    found, refitted = at_optimum(problem)
    findings, runs = fitted_without(problem, found)
    assert findings.jackknife is not None
    assert findings.jackknife.values == pytest.approx(refitted, rel=1e-6)
    assert (findings.jackknife.pulling("b"), findings.notes) == ("test_3", ())
    assert runs == 3 + 4  # the optimum, a move of each parameter, one run of each fit


def curves(values: FloatArray, noise: FloatArray) -> Problem:
    """Tests on saturating curves, each with its own (a, b)."""
    flat = several(np.ones(len(values)), np.zeros((len(values), X.size)), "a * (1 - exp(-b * x))").document()
    for observation, own, off in zip(flat["observations"], values, noise, strict=True):
        observation["points"]["y"] = (curve(own) + off).tolist()
    flat["parameters"] = {"a": free(0.1, 20.0), "b": free(0.01, 10.0) | {"scale": "log"}}
    return parse_problem(flat)


def curve(values: FloatArray) -> FloatArray:
    return np.asarray(values[0] * (1.0 - np.exp(-values[1] * X)))


def fit(problem: Problem, without: int | None = None) -> FloatArray:
    """Least squares by SciPy, without one of the tests."""
    bounds = ([p.lower for p in problem.free], [p.upper for p in problem.free])
    return best_of(np.array([o.y for row, o in enumerate(problem.observations) if row != without]), bounds)


def best_of(readings: FloatArray, bounds: Any = (0.01, 20.0)) -> FloatArray:
    found = least_squares(lambda v: (readings - curve(v)).ravel(), [3.0, 0.8], bounds=bounds, xtol=1e-12, ftol=1e-12)
    return np.asarray(found.x)


def scattered(seed: int, tests: int) -> tuple[FloatArray, FloatArray]:
    """Values of each specimen, and a mechanism that the model misses by far more than the readings scatter."""
    rng = np.random.default_rng(seed)
    values = np.array([3.0, 0.8]) + np.array([0.3, 0.12]) * rng.normal(size=(tests, 2))
    missed = 0.3 * np.sin(2.0 * X) * rng.normal(size=(tests, 1))
    return values, missed + 0.02 * rng.normal(size=(tests, X.size))


@pytest.mark.parametrize(("seed", "tests"), [(1, 4), (5, 3)])
def test_fits_without_each_test_follow_a_nonlinear_model(seed: int, tests: int) -> None:
    problem = curves(*scattered(seed, tests))
    findings, _ = fitted_without(problem, linearised(problem, fit(problem).tolist()))
    found = findings.jackknife
    assert found is not None
    refitted = np.array([fit(problem, row) for row in range(tests)])
    assert np.abs((found.values - refitted) / np.ptp(found.intervals, axis=1)).max() < 0.01
    assert findings.notes == ()


def test_the_same_question_twice_is_the_same_search() -> None:
    problem = curves(*scattered(1, 4))
    known = linearised(problem, fit(problem).tolist())
    found = fitted_without(problem, known)[0].jackknife
    assert found is not None
    first, again = (jackknife_problem(problem, one, seed=1) for one in (known, with_refits(known, found)))
    assert again == first


def test_trials_of_a_rough_model_that_are_no_better_end_its_fits() -> None:
    problem = curves(*scattered(1, 4))
    question = jackknife_problem(problem, linearised(problem, fit(problem).tolist()), seed=1, runs=200)
    calibration, method = Calibration(question, 1), question.method
    assert isinstance(method, JackknifeMethod)
    search = method.search(calibration.space, question.series_by_test)
    done: list[Evaluation] = []
    while (due := search.ask()) is not None:
        done += [calibration.evaluate(position) for position in due]
        rows = residual_rows(calibration, done)
        rows[1:] += 0.02 * np.random.default_rng(1).normal(size=rows[1:].shape)
        search.tell(np.zeros(len(due)), Runs.of(np.array([one.parameters for one in done]), rows))
    assert len(done) < method.runs
    (note,) = notes_on(search, calibration.space)
    assert note.startswith("the fit without test_")
    assert note.endswith("has not settled as its last trials were no better: the forward model is rough there")


def test_a_fit_ends_at_a_bound_and_says_so() -> None:
    values, noise = scattered(1, 4)
    document = curves(values, noise).document()
    document["parameters"]["b"]["upper"] = 0.86
    problem = parse_problem(document)
    findings, _ = fitted_without(problem, linearised(problem, fit(problem).tolist()))
    assert findings.jackknife is not None
    assert findings.jackknife.values[1] == pytest.approx(fit(problem, 1), abs=2e-3)
    assert findings.notes == ("without test_2, the best fit lies on the upper bound of b",)


def test_too_few_runs_are_said() -> None:
    problem = curves(*scattered(1, 4))
    findings, runs = fitted_without(problem, linearised(problem, fit(problem).tolist()), runs=5)
    assert runs == 5
    assert findings.notes[0].startswith("the fit without test_1, ")
    assert findings.notes[0].endswith("has not settled within 5 runs; give more than 5")


def test_what_the_other_tests_do_not_determine_has_no_value_without_it() -> None:
    document = several(np.array([2.0, 2.6, 1.3]), np.zeros((3, X.size))).document()
    document["forward_model"]["parts"]["test_1"]["series"]["y"] = "a + b * x + c * x**2"
    document["parameters"]["c"] = free(-1.0, 1.0)
    problem = parse_problem(document)
    rows = np.array([[1.0, x, x**2 * (g == 0)] for g in range(3) for x in X.tolist()])
    best = np.linalg.lstsq(rows, np.concatenate([o.y for o in problem.observations]))[0]
    found = fitted_without(problem, linearised(problem, best.tolist()))[0].jackknife
    assert found is not None
    assert np.isnan(found.values).tolist() == [[False, False, True], [False] * 3, [False] * 3]
    without_first = np.polyfit(np.tile(X, 2), np.concatenate([o.y for o in problem.observations[1:]]), 1)[::-1]
    assert found.values[0, :2] == pytest.approx(without_first, rel=1e-6)


def test_fits_take_the_place_of_the_estimate_in_the_intervals() -> None:
    problem = curves(*scattered(1, 4))
    linear = linearised(problem, fit(problem).tolist())
    findings, _ = fitted_without(problem, linear)
    joined = join_findings([findings, Findings(linear)]).linearisation
    assert joined is not None
    assert findings.jackknife is not None
    assert joined.between_tests == ("a", "b")
    assert joined.intervals == pytest.approx(findings.jackknife.intervals, rel=1e-12)
    assert joined.without is not None
    assert joined.without.fitted
    assert left_out_table(joined.without, parameter_labels(problem)).note.startswith("Fitted again without each test.")
    assert joined.widening == pytest.approx(linear.widening * joined.unit_widths / linear.unit_widths)


def test_two_tests_are_too_few_to_leave_one_out() -> None:
    problem = curves(*scattered(1, 2))
    found = linearised(problem, fit(problem).tolist())
    with pytest.raises(StatisticsError, match="at least 3 tests with readings, got test_1, test_2"):
        jackknife_problem(problem, found, seed=1)


def test_a_point_far_from_the_minimum_is_no_start() -> None:
    problem = curves(*scattered(1, 3))
    found = linearised(problem, [5.0, 0.3])
    assert found.misplaced
    with pytest.raises(NotExaminedError, match="standard errors from the minimum"):
        jackknife_problem(problem, found, seed=1)


@pytest.mark.slow
def test_intervals_of_fits_cover_the_mean_of_specimens_of_a_nonlinear_model() -> None:
    """200 data bases of ten tests: specimens scatter, and no specimen has what the model misses.

    A 95 % interval covers 91 to 98.5 % of 200 with a chance of 99.7 %.
    """
    rng, missed, spread = np.random.default_rng(5), 0.3 * np.sin(2.0 * X), np.array([0.3, 0.12])
    specimens = np.array([3.0, 0.8]) + spread * np.random.default_rng(1).normal(size=(4000, 2))
    middle = best_of(np.array([curve(own) for own in specimens]) + missed)  # what this model makes of all specimens
    covered = []
    for _ in range(200):
        values = np.array([3.0, 0.8]) + spread * rng.normal(size=(10, 2))
        problem = curves(values, missed + 0.02 * rng.normal(size=(10, X.size)))
        found = fitted_without(problem, linearised(problem, fit(problem).tolist()))[0].jackknife
        assert found is not None
        covered.append((found.intervals[:, 0] <= middle) & (middle <= found.intervals[:, 1]))
    share = np.mean(covered, axis=0)
    assert ((share >= 0.91) & (share <= 0.985)).all()


def test_an_interval_without_an_end_is_none() -> None:
    """On a log scale, of a test that the model misses by far: such a job had no statistics."""
    space = SearchSpace(("E",), np.array([2e3]), np.array([2e5]), np.array([True]), lambda _: True)
    moves = np.array([[0.0], [0.1], [500.0]])
    found = WithoutTests.of(("E",), ("a", "b", "c"), moves, 0.95, lambda by: natural_moves(space, np.array([2e4]), by))
    told = found.to_json()["parameters"]["E"]
    assert (told["interval"], told["values"]["a"], told["values"]["c"]) == (None, pytest.approx(2e4), None)
