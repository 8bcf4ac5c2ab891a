"""Verdicts and proposals on problems whose answer is known."""

from __future__ import annotations

import json

import numpy as np

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, analyse, apply_changes, fit_line
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from tests.solver.identifiability.cases import X, free, linearised, problem_of, sampled

NOISE = np.random.default_rng(4).normal(0.0, 0.05, X.size)


def test_a_clear_parameter_and_one_without_influence() -> None:
    problem, samples = sampled("a * x + 0 * b", {"a": free(), "b": free()}, 3.0 * X + NOISE)
    statistics = analyse(Calibration(problem, 1), samples, threshold=0.5)
    assert statistics.verdict("a").kind == "identified"
    assert statistics.verdict("b").kind == "not_identified"
    assert [p.kind for p in statistics.verdict("b").proposals] == ["fix", "add_test"]
    evidence = statistics.verdict("a").evidence
    assert evidence.unimodal is True
    assert evidence.open_below is False
    assert evidence.width_ratio is not None
    assert evidence.width_ratio < 0.2
    judged = analyse(
        Calibration(problem, 1), samples, threshold=0.5, linearisation=linearised(problem, [3.0, 5.0])
    ).verdict("b")
    assert judged.kind == "not_identified"
    assert "no influence" in judged.sentence


def test_a_search_that_changes_nothing_identifies_nothing() -> None:
    problem = problem_of("x + 0 * a", {"a": free()}, 3.0 * X + NOISE)
    samples = Samples.from_arrays(problem, np.linspace(1.0, 9.0, 12)[:, np.newaxis], np.full(12, 4.0))
    verdict = analyse(Calibration(problem, 1), samples).verdict("a")
    assert (verdict.kind, verdict.code) == ("not_identified", "no_influence")
    assert "all runs gave the same objective" in verdict.sentence


def test_a_product_is_named_and_linked() -> None:
    problem, samples = sampled("a * b * x", {"a": free(scale="log"), "b": free(scale="log")}, 3.0 * X + NOISE)
    statistics = analyse(Calibration(problem, 1), samples, threshold=0.5)
    for name, other in (("a", "b"), ("b", "a")):
        verdict = statistics.verdict(name)
        assert verdict.kind == "in_combination"
        assert verdict.evidence.partners[0][0] == other
    line = fit_line(statistics.filtered.samples, "a", "b")
    assert line is not None
    assert line.scale == "log"
    np.testing.assert_allclose(line.slope, -1.0, rtol=0.05)
    np.testing.assert_allclose(line.value(2.0), 1.5, rtol=0.1)
    link = next(p for p in statistics.verdict("a").proposals if p.kind == "link")
    follow_up = parse_problem(apply_changes(problem.document(), [link.changes]))
    assert follow_up.free_names == ("b",)
    np.testing.assert_allclose(follow_up.values([2.0])["a"], 1.5, rtol=0.1)


def test_linearisation_names_the_product_for_a_swarm() -> None:
    problem = problem_of("a * b * x", {"a": free(), "b": free()}, 6.0 * X + NOISE)
    result = calibrate(problem)
    assert result.best is not None
    found = linearised(problem, result.best.parameters.tolist())
    statistics = analyse(Calibration(problem, 1), Samples.from_result(problem, result), linearisation=found)
    assert statistics.verdict("a").kind == "in_combination"
    assert statistics.verdict("a").evidence.partners == (("b", None),)
    assert statistics.verdict("a").evidence.sampling_bias
    assert any("swarm" in warning for warning in statistics.warnings)


def test_nothing_is_identified_far_from_the_minimum() -> None:
    problem = problem_of("a * x", {"a": free()}, 3.0 * X + NOISE)
    swarm = Samples.from_result(problem, calibrate(problem))
    calibration = Calibration(problem, 1)
    near = analyse(calibration, swarm, linearisation=linearised(problem, [3.0])).verdict("a")
    far = analyse(calibration, swarm, linearisation=linearised(problem, [3.1])).verdict("a")
    assert near.kind == "identified"
    assert far.kind == "undecided"
    assert "not the minimum yet" in far.sentence


def test_nothing_is_identified_where_the_fit_is_too_far_from_the_minimum_to_be_tested() -> None:
    """Parameters of a line far from x = 0 act alike: each is within a standard error, both together are not."""
    x = np.linspace(5.0, 7.0, 20)
    y = 1.0 + 2.0 * x + np.random.default_rng(7).normal(0.0, 0.1, x.size)
    problem = problem_of("a + b * x", {"a": free(-20.0, 20.0), "b": free(-20.0, 20.0)}, y, x)
    best = np.linalg.lstsq(np.stack([np.ones_like(x), x], axis=1), y, rcond=None)[0]
    at = best + 0.9 * linearised(problem, best.tolist()).standard_errors * [1.0, 0.0]
    found = linearised(problem, at.tolist())
    assert found.far is not None
    assert found.far < 1.0
    assert (found.fit.kind, found.misplaced) == ("untested", True)
    calibration = Calibration(problem, 1)
    value = calibration.evaluate(at).objective
    assert value is not None
    samples = Samples.from_arrays(problem, at[None], np.array([value]))
    verdicts = analyse(calibration, samples, linearisation=found).verdicts
    assert [verdict.kind for verdict in verdicts] == ["undecided", "undecided"]


def test_a_swarm_alone_decides_nothing() -> None:
    problem = problem_of("a * x", {"a": free()}, 3.0 * X + NOISE)
    statistics = analyse(Calibration(problem, 1), Samples.from_result(problem, calibrate(problem)))
    assert statistics.verdict("a").kind == "undecided"


def test_one_sided_parameter_gets_a_wider_bound() -> None:
    # saturates: any large b fits
    problem, samples = sampled("1 - exp(-b * x)", {"b": free(0.1, 100.0, "log")}, np.ones(X.size))
    statistics = analyse(Calibration(problem, 1), samples, threshold=1e-3)
    verdict = statistics.verdict("b")
    assert verdict.kind == "bounded_on_one_side"
    assert verdict.evidence.open_above is True
    assert verdict.evidence.open_below is False
    widen = verdict.proposals[0]
    assert widen.kind == "widen"
    wider = parse_problem(apply_changes(problem.document(), [widen.changes]))
    assert wider.free[0].upper > 1000.0
    assert wider.free[0].lower == 0.1


def test_two_solutions_are_no_identification() -> None:
    problem, samples = sampled("(a - 5) ** 2 * x", {"a": free(0.0, 10.0)}, X)
    statistics = analyse(Calibration(problem, 1), samples, threshold=0.05)
    assert statistics.projections[0].unimodal is False
    assert statistics.verdict("a").kind == "not_identified"
    assert "more than one solution" in statistics.verdict("a").sentence


def test_too_few_good_fits_are_undecided() -> None:
    problem, samples = sampled("a * x ** b", {"a": free(), "b": free()}, 3.0 * X, 30)
    best = float(np.sort(samples.objectives)[2])
    statistics = analyse(Calibration(problem, 1), samples, threshold=best)
    assert statistics.filtered.kept == 3
    assert {v.kind for v in statistics.verdicts} == {"undecided"}


def test_the_envelope_is_the_binned_minimum() -> None:
    problem, samples = sampled("a * x", {"a": free()}, 3.0 * X, 500)
    projection = analyse(Calibration(problem, 1), samples, threshold=1.0, bins=10).projections[0]
    edges = np.linspace(0.1, 10.0, 11)
    np.testing.assert_allclose(projection.edges, edges, rtol=1e-12)
    for index in range(10):
        inside = (samples.parameters[:, 0] >= edges[index]) & (samples.parameters[:, 0] < edges[index + 1])
        assert projection.counts[index] == inside.sum()
        np.testing.assert_allclose(projection.envelope[index], samples.objectives[inside].min(), rtol=0)
    assert projection.counts.sum() == 500


def test_everything_is_json() -> None:
    problem, samples = sampled("a * x ** b", {"a": free(), "b": free()}, 3.0 * X, 200)
    found = linearised(problem, [3.0, 1.0], noise=0.1)
    data = analyse(Calibration(problem, 1), samples, linearisation=found).to_json()
    restored = json.loads(json.dumps(data, allow_nan=False))
    assert set(restored) >= {"verdicts", "correlations", "projections", "threshold", "linearisation", "weights"}


def test_fewer_measurements_than_parameters_are_warned_of() -> None:
    problem = problem_of("a + b * x", {"a": free(), "b": free()}, np.array([3.0]), np.array([1.0]))
    samples = Samples.from_result(problem, calibrate(problem))
    found = analyse(Calibration(problem, 1), samples)
    assert found.warnings[1].startswith("Too few measurements: 1 of them cannot determine 2 free parameters")
    assert found.linearisation is None
    assert "identified" not in {verdict.kind for verdict in found.verdicts}
