"""Profiles: exact for a line, open where the data leave a parameter open, the same after a restart."""

from __future__ import annotations

import json

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.identifiability.optimum.profiles import Profile, profile_settings, profiles_of
from geoswarm.solver.problem import Problem
from geoswarm.solver.search.descent.planned import ProfileSearch
from tests.solver.identifiability.cases import X, free, linearised, problem_of

Y = 6.0 * X + 1.0 + np.random.default_rng(1).normal(0.0, 0.1, X.size)


def profiled(
    problem: Problem, start: list[float], *, restart: bool = False, optimum: bool = False
) -> tuple[ProfileSearch, tuple[Profile, ...]]:
    """Profiles from a start, which is polished unless it is an optimum."""
    calibration = Calibration(problem, 1)
    found = start if optimum else polish(calibration, np.array(start)).parameters.tolist()
    settings = profile_settings(calibration, linearised(problem, found))
    search = ProfileSearch(calibration.space, settings)
    failed = np.full(sum(o.x.size for o in problem.observations), np.nan)
    while (positions := search.ask()) is not None:
        if restart:
            search = ProfileSearch(calibration.space, settings, json.loads(json.dumps(search.snapshot())))
            np.testing.assert_array_equal(search.ask(), positions)
        runs = [calibration.evaluate(x) for x in positions]
        search.take(
            np.array([failed if e.reason else calibration.objective.weighted_residuals(e.responses) for e in runs])
        )
        assert search.generation < 300
    return search, profiles_of(search)


def test_the_profile_of_a_line_gives_students_interval() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, Y)
    _, profiles = profiled(problem, [5.0, 2.0])
    slope, intercept = np.polyfit(X, Y, 1)
    found = linearised(problem, [slope, intercept])
    for profile in profiles:
        np.testing.assert_allclose(profile.interval, found.interval(profile.parameter), rtol=1e-3)
        assert (np.diff(profile.values) > 0).all()
        assert profile.better is None


def test_other_parameters_follow() -> None:
    _, (profile, _) = profiled(problem_of("a * x + b", {"a": free(), "b": free()}, Y), [5.0, 2.0])
    for a, others in zip(profile.values, profile.others, strict=True):
        assert others[0] == a
        np.testing.assert_allclose(others[1], np.mean(Y - a * X), rtol=1e-3)


def test_a_restart_changes_nothing() -> None:
    problem = problem_of(
        "a * (1 - exp(-b * x))", {"a": free(), "b": free(0.05, 5.0, "log")}, 5 * (1 - np.exp(-X)) + 0.1 * np.sin(5 * X)
    )
    straight, _ = profiled(problem, [4.0, 1.0])
    resumed, _ = profiled(problem, [4.0, 1.0], restart=True)
    assert straight.snapshot() == resumed.snapshot()


def test_a_product_stays_open() -> None:
    _, profiles = profiled(
        problem_of("a * b * x", {"a": free(), "b": free()}, 6.0 * X + 0.01 * np.sin(9 * X)), [2.0, 3.0]
    )
    for profile in profiles:
        assert profile.interval is None
        # flat over everything that the other parameter's bounds allow
        assert profile.values[0] <= 0.7
        assert profile.values[-1] >= 9.9
        inner = (profile.values > 0.7) & (profile.values < 9.9)
        assert (profile.objectives[inner] <= profile.limit).all()


def test_an_end_that_a_bound_of_another_parameter_sets_is_found() -> None:
    # a b = 6 with b at most 10: the profile of a is flat down to 0.6 and rises steeply below
    y = 6.0 * X + 0.01 * np.sin(9 * X)
    slope = float(X @ y / (X @ X))  # a b of the line through the origin that fits best
    problem = problem_of("a * b * x", {"a": free(), "b": free()}, y)
    _, profiles = profiled(problem, [6.4, slope / 6.4], optimum=True)
    for profile in profiles:
        assert profile.lower == pytest.approx(0.6, abs=0.01)
        assert profile.upper is None


def test_noise_is_needed_and_names_are_checked() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, np.array([2.0, 3.0]), np.array([1.0, 2.0]))
    calibration = Calibration(problem, 1)
    with pytest.raises(StatisticsError, match="needs the noise"):
        profile_settings(calibration, linearised(problem, [1.0, 1.0]))
    known = linearised(problem, [1.0, 1.0], noise=0.1)
    with pytest.raises(StatisticsError, match="unknown parameter z; free: a, b"):
        profile_settings(calibration, known, parameters=["z"])
    search = ProfileSearch(calibration.space, profile_settings(calibration, known, parameters=["a"]))
    assert {path.index for path in search.paths if not path.finished} == {0}
    assert profiles_of(search) == ()
    with pytest.raises(ValueError, match="needs the runs"):
        search.tell(np.ones(3))


def test_an_optimum_that_fails_ends_the_profiles() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, Y)
    calibration = Calibration(problem, 1)
    search = ProfileSearch(calibration.space, profile_settings(calibration, linearised(problem, [5.0, 1.5])))
    positions = search.ask()
    assert positions is not None
    search.take(np.full((len(positions), X.size), np.nan))
    assert search.ask() is None
    assert profiles_of(search) == ()
