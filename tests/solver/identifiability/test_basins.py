"""Two basins that fit alike are never called identified, and a bound is where a minimum may lie."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, analyse, linearise
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.identifiability.optimum.polish import polish
from geoswarm.solver.identifiability.optimum.sensitivity import from_evaluations
from geoswarm.solver.identifiability.stored.linearised import jacobian_from_samples
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.document.build import linearise_stored, report_of_result
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import X, free, problem_of

NOISE = 0.05 * np.random.default_rng(2).standard_normal(X.size)
TRUE = 1.69


def two_basins() -> Problem:
    """(a - 3)^2 enters alone: a and 6 - a fit alike, to the last digit but for rounding.

    The range of b has little in common with that of a: else whether both can be exchanged is asked of the stored runs,
    which hardly tell, and a run more or less decides on b.
    """
    y = 4.0 * np.exp(-0.5 * X) + (TRUE - 3.0) ** 2 * X + NOISE
    return problem_of(
        "b * exp(-0.5 * x) + (a - 3)**2 * x",
        {"a": free(0.1, 5.9), "b": free(1.0, 30.0)},
        y,
        method={"kind": "particle_swarm", "particles": 20},
        stopping={"max_evaluations": 300},
    )


@pytest.mark.parametrize("seed", range(3))
def test_stored_runs_of_a_second_basin_are_seen_before_a_word_is_said(seed: int) -> None:
    problem = two_basins()
    result = calibrate(problem, seed=seed)
    samples = Samples.from_result(problem, result)
    best = samples.parameters[samples.best]
    mirror = np.array([6.0 - best[0], best[1]])
    # the runs as a search leaves them that has been in both basins
    calibration = Calibration(problem, seed)
    other = calibration.evaluate(mirror)
    assert other.objective == pytest.approx(float(samples.objectives.min()), rel=1e-8)
    both = Samples.merge(
        [
            samples,
            Samples.from_arrays(
                problem,
                mirror[None],
                np.array([other.objective]),
                misfits={"y": np.array([other.misfits["y"]])},
                responses={"y": other.responses["y"][None]},
            ),
        ]
    )
    found = from_evaluations(calibration, *evaluate_differences(calibration, best))
    statistics = analyse(calibration, both, linearisation=found)
    verdict = statistics.verdict("a")
    assert verdict.kind == "not_identified"
    assert "more than one solution" in verdict.sentence
    assert verdict.evidence.unimodal is False
    assert any("fits as well" in warning for warning in statistics.warnings)
    b = statistics.verdict("b")
    assert b.kind == "identified", b.sentence
    # from stored runs alone
    stored = linearise(calibration, jacobian_from_samples(calibration, samples))
    assert analyse(calibration, both, linearisation=stored).verdict("a").kind == "not_identified"


def test_the_report_looks_into_the_other_basin() -> None:
    problem = two_basins()
    report = report_of_result(problem, calibrate(problem, seed=1))
    assert report.statistics is not None
    assert report.statistics.verdict("a").kind == "not_identified"
    assert report.statistics.verdict("b").kind == "identified"


def test_one_basin_stays_identified() -> None:
    y = 4.0 * np.exp(-0.5 * X) + NOISE
    problem = problem_of("b * exp(-a * x)", {"a": free(0.05, 5.0), "b": free()}, y)
    for seed in range(3):
        report = report_of_result(problem, calibrate(problem, seed=seed))
        assert report.statistics is not None
        assert {verdict.kind for verdict in report.statistics.verdicts} == {"identified"}
        assert not any("fits as well" in warning for warning in report.statistics.warnings)


def test_a_minimum_on_a_bound_is_a_minimum() -> None:
    y = 6.0 * X + 1.0 + NOISE
    problem = problem_of("a * x + b", {"a": free(0.1, 5.5), "b": free()}, y)
    calibration = Calibration(problem, 1)
    polished = polish(calibration, np.array([4.0, 2.0]))
    found = from_evaluations(calibration, *evaluate_differences(calibration, polished.parameters))
    assert found.held == (("a", "upper"),)
    assert found.at_optimum
    assert found.far == pytest.approx(0.0, abs=1e-3)
    samples = Samples.from_arrays(problem, polished.parameters[None], np.array([polished.objective]))
    statistics = analyse(calibration, samples, linearisation=found)
    warnings = " ".join(statistics.warnings)
    assert "not the minimum yet" not in warnings
    assert "upper bound of a" in warnings
    widen = statistics.verdict("a").proposals[0]
    assert widen.sentence.startswith("Widen the upper bound of a to 8.2 if that is physically possible")
    assert widen.changes["parameters"]["a"]["lower"] == 0.1
    assert not any(one.kind == "widen" for one in statistics.verdict("b").proposals)
    # off the conditional minimum the other parameter is far away still
    place = polished.parameters + np.array([0.0, 1.0])
    beside = from_evaluations(calibration, *evaluate_differences(calibration, place))
    assert not beside.at_optimum


def test_inside_of_a_bound_the_pull_inwards_counts() -> None:
    y = 6.0 * X + 1.0 + NOISE
    problem = problem_of("a * x + b", {"a": free(0.1, 8.0), "b": free()}, y)
    calibration = Calibration(problem, 1)
    found = from_evaluations(calibration, *evaluate_differences(calibration, np.array([8.0, 1.0])))
    assert found.held == ()
    assert not found.at_optimum


def test_without_any_distance_nothing_is_said_to_be_an_optimum() -> None:
    problem = problem_of("a * b * x", {"a": free(), "b": free()}, 6.0 * X + NOISE)
    calibration = Calibration(problem, 1)
    found = from_evaluations(calibration, *evaluate_differences(calibration, np.array([2.0, 2.0])))
    assert np.isnan(found.distance).all()
    assert not found.at_optimum
    samples = Samples.from_arrays(problem, np.array([[2.0, 2.0]]), np.array([5.0]))
    assert any("is a minimum is unknown" in w for w in analyse(calibration, samples, linearisation=found).warnings)


@pytest.mark.slow
def test_twenty_searches_of_each_kind_say_no_false_word() -> None:
    """Measured: 0 of 20 call the parameter of two basins identified, 0 of 20 the one of one basin not."""
    one = problem_of("b * exp(-a * x)", {"a": free(0.05, 5.0), "b": free()}, 4.0 * np.exp(-0.5 * X) + NOISE)
    for seed in range(20):
        problem = two_basins()
        result = calibrate(problem, seed=seed)
        report = report_of_result(problem, result)
        assert report.statistics is not None
        assert report.statistics.verdict("a").kind == "not_identified", seed
        samples = Samples.from_result(problem, result)
        stored = linearise_stored(problem, samples, seed)
        unaided = analyse(Calibration(problem, seed), samples, linearisation=stored).verdict("a")
        assert unaided.kind != "identified", seed
        alone = report_of_result(one, calibrate(one, seed=seed)).statistics
        assert alone is not None
        assert {verdict.kind for verdict in alone.verdicts} == {"identified"}, seed
