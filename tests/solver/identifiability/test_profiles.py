"""Profiles: exact for a line, open where the data leave a parameter open, the same after a restart."""

from __future__ import annotations

import json

import numpy as np
import pytest

from solver.calibration import Calibration
from solver.identifiability import StatisticsError
from solver.identifiability.polish import polish
from solver.identifiability.profiles import Profile, Profiles, start_profiles
from solver.problem import Problem
from tests.solver.identifiability.cases import X, free, linearised, problem_of

Y = 6.0 * X + 1.0 + np.random.default_rng(1).normal(0.0, 0.1, X.size)


def profiled(problem: Problem, start: list[float], *, restart: bool = False) -> tuple[Profiles, tuple[Profile, ...]]:
    calibration = Calibration(problem, 1)
    found = polish(calibration, np.array(start))
    state = start_profiles(calibration, linearised(problem, found.parameters.tolist()), found.objective)
    while not state.finished:
        if restart:
            state = Profiles.from_json(json.loads(json.dumps(state.to_json())))
        state = state.advance(calibration, [calibration.evaluate(x) for x in state.positions(calibration)])
        assert state.generation < 300
    return state, state.results(calibration)


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
    assert straight.to_json() == resumed.to_json()


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


def test_noise_is_needed_and_names_are_checked() -> None:
    problem = problem_of("a * x + b", {"a": free(), "b": free()}, np.array([2.0, 3.0]), np.array([1.0, 2.0]))
    calibration = Calibration(problem, 1)
    with pytest.raises(StatisticsError, match="needs the noise"):
        start_profiles(calibration, linearised(problem, [1.0, 1.0]), 0.0)
    known = linearised(problem, [1.0, 1.0], noise=0.1)
    with pytest.raises(StatisticsError, match="unknown parameter z; free: a, b"):
        start_profiles(calibration, known, 0.0, parameters=["z"])
    state = start_profiles(calibration, known, 0.0, parameters=["a"])
    assert {chain.index for chain in state.chains if not chain.finished} == {0}
    with pytest.raises(StatisticsError, match="are due"):
        state.advance(calibration, [])
