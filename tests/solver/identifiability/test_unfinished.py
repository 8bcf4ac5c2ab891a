"""Runs that point to another basin, and pairs that nobody has swapped, leave a parameter undecided."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, Samples, analyse
from geoswarm.solver.identifiability.optimum.basins import exchangeable
from geoswarm.solver.identifiability.stored.exploring import explore_problem
from geoswarm.solver.problem import Problem
from tests.solver.identifiability.cases import X, free, linearised, problem_of

NOISE = 0.05 * np.random.default_rng(2).standard_normal(X.size)
BEST = [1.7, 4.0]
SIGN = np.array([4.1, 4.0])  # in the other basin, which ends at 4.3


def samples_at(problem: Problem, places: FloatArray) -> Samples:
    calibration = Calibration(problem, 1)
    return Samples.from_arrays(problem, places, np.array([calibration.evaluate(place).objective for place in places]))


def two_basins(*further: FloatArray) -> tuple[Problem, Samples, Linearisation]:
    """a = 1.7 and a = 4.3 fit alike; stored runs lie below 3, but for those given."""
    y = 4.0 * np.exp(-0.5 * X) + 1.3**2 * X + NOISE
    problem = problem_of("b * exp(-0.5 * x) + (a - 3)**2 * x", {"a": free(0.1, 5.9), "b": free()}, y)
    places = np.random.default_rng(0).uniform([0.1, 0.1], [3.0, 10.0], (80, 2))
    return problem, samples_at(problem, np.array([BEST, *places, *further])), linearised(problem, BEST)


def test_a_run_that_points_to_another_basin_is_told_until_somebody_has_gone_there() -> None:
    problem, samples, found = two_basins(SIGN)
    calibration = Calibration(problem, 1)
    told = analyse(calibration, samples, linearisation=found)
    assert [other.parameters.tolist() for other in told.basins.unfinished] == [SIGN.tolist()]
    assert told.verdict("a").kind == "undecided"
    assert "around a = 4.1, which the search did not explore" in told.verdict("a").sentence
    assert told.verdict("b").kind == "identified"  # it has the same value there
    assert told.to_json()["basins"]["unfinished"][0]["differs"] == ["a"]
    points = explore_problem(problem, samples, found, seed=1, runs=20).document()["method"]["points"]
    assert SIGN.tolist() in np.column_stack([points["a"], points["b"]]).tolist()
    # the end of the descent is a fit as good
    bottom = np.array([4.3, 4.0])
    objective = calibration.evaluate(bottom).objective
    assert objective is not None
    named = analyse(calibration, samples, linearisation=found, elsewhere=[(bottom, objective)])
    assert named.verdict("a").kind == "not_identified"


def test_runs_around_that_are_no_better_say_that_a_sign_leads_nowhere() -> None:
    """The objectives are made up here: SIGN is the bottom of a basin that ends higher."""
    problem, samples, found = two_basins(SIGN)
    angles = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    around = SIGN + 0.002 * np.column_stack([np.cos(angles), np.sin(angles)])
    sign = float(samples.objectives[-1])
    places, objectives = np.concatenate([samples.parameters, around]), [*samples.objectives, *[1.01 * sign] * 12]
    whole = Samples.from_arrays(problem, places, np.array(objectives))
    assert len(analyse(Calibration(problem, 1), samples, linearisation=found).basins.unfinished) == 1
    assert analyse(Calibration(problem, 1), whole, linearisation=found).basins.unfinished == ()


def test_no_sign_where_no_run_is_in_the_other_basin() -> None:
    problem, samples, found = two_basins()
    assert analyse(Calibration(problem, 1), samples, linearisation=found).basins.unfinished == ()


def test_a_pair_that_may_be_exchanged_is_undecided_until_it_was_tried() -> None:
    y = np.exp(-0.3 * X) + np.exp(-2.0 * X) + 0.2 * NOISE
    rates = problem_of("exp(-a * x) + exp(-b * x)", {"a": free(0.05, 5.0), "b": free(0.02, 5.0)}, y)
    places = np.random.default_rng(1).uniform(0.05, 5.0, (150, 2))
    places = np.array([*places[places[:, 0] < places[:, 1] + 1.0], [0.3, 2.0]])
    samples, found = samples_at(rates, places), linearised(rates, [0.3, 2.0])
    calibration = Calibration(rates, 1)
    told = analyse(calibration, samples, linearisation=found)
    assert told.basins.untried == (("a", "b"),)
    assert told.to_json()["basins"]["untried"] == [["a", "b"]]
    assert {verdict.kind for verdict in told.verdicts} == {"undecided"}
    ((_, _, swapped),) = exchangeable(calibration, found.optimum)
    objective = calibration.evaluate(swapped).objective
    assert objective is not None
    tried = analyse(calibration, samples, linearisation=found, elsewhere=[(swapped, objective)])
    assert tried.basins.untried == ()
    assert {verdict.kind for verdict in tried.verdicts} == {"not_identified"}


def test_a_line_cannot_be_exchanged_as_its_runs_show() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, 2.0 * X + 5.0 + NOISE)
    places = np.random.default_rng(1).uniform(0.1, 10.0, (150, 2))
    told = analyse(Calibration(problem, 1), samples_at(problem, places), linearisation=linearised(problem, [2.0, 5.0]))
    assert told.basins.untried == ()
    assert {verdict.kind for verdict in told.verdicts} == {"identified"}


def test_ranges_that_hardly_overlap_are_not_tried() -> None:
    for upper, pairs in ((8.0, 1), (20.0, 0)):
        problem = problem_of("a * x + b", {"a": free(0.1, 5.0), "b": free(0.1, upper)}, X)
        assert len(exchangeable(Calibration(problem, 1), np.array([1.0, 2.0]))) == pairs
    problem = problem_of("a * x + b", {"a": free(0.1, 5.0), "b": free(0.1, 8.0)}, X)
    assert exchangeable(Calibration(problem, 1), np.array([1.0, 7.0])) == ()  # a would leave its range
