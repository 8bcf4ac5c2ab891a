"""Certified standard deviations without a step from anybody, and certified parameters by a polished search alone."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, analyse, from_evaluations
from geoswarm.solver.identifiability.differences import evaluate_differences
from geoswarm.solver.local import CalibrationResult, calibrate
from geoswarm.solver.problem import parse_problem
from tests.verification.nist.archive import NAMES, ArchiveSet, archive_set

WITHIN = 1.01
SEEDS = range(1, 6)


def search(case: ArchiveSet, seed: int) -> tuple[CalibrationResult, float]:
    """A polished search, and its sum of squares over the certified one."""
    result = calibrate(parse_problem(case.document()), seed=seed)
    assert result.objective is not None
    assert result.evaluations <= 1000
    return result, result.objective * len(case.x) / case.residual_sum_of_squares


@pytest.mark.parametrize("name", NAMES)
def test_certified_standard_deviations_and_no_false_word(name: str) -> None:
    case = archive_set(name)
    problem = parse_problem(case.document())
    calibration = Calibration(problem, 1)
    plan, evaluations = evaluate_differences(calibration, case.certified)
    found = from_evaluations(calibration, plan, evaluations)
    np.testing.assert_allclose(found.standard_errors, case.deviations, rtol=1e-3)
    assert found.without_influence == found.unclear == found.held == ()
    assert found.at_optimum
    best = evaluations[0].objective
    assert best is not None
    samples = Samples.from_arrays(problem, case.certified[None], np.array([best]))
    verdicts = analyse(calibration, samples, linearisation=found).verdicts
    assert not any("influence" in v.sentence or "in combination" in v.sentence for v in verdicts)


@pytest.mark.parametrize("name", ["Eckerle4", "MGH10", "Rat43"])
def test_a_polished_search_ends_at_the_certified_values(name: str) -> None:
    case = archive_set(name)
    result, ratio = search(case, 1)
    assert result.stop_reasons == ("polished",)
    assert ratio == pytest.approx(1.0, rel=1e-6)
    assert result.best is not None
    assert case.digits(result.best.parameters) >= 6.0


@pytest.mark.slow
def test_thirteen_of_sixteen_sets_within_a_thousand_runs() -> None:
    """Measured: 13 sets in all five seeds, Gauss1, Gauss3 and ENSO in none (docs/statistics.md)."""
    reached = {}
    for name in NAMES:
        case = archive_set(name)
        ends = [search(case, seed) for seed in SEEDS]
        reached[name] = sum(ratio < WITHIN for _, ratio in ends)
        for result, ratio in ends:
            assert result.best is not None
            if result.stop_reasons == ("polished",) and ratio < WITHIN:
                assert case.digits(result.best.parameters) >= 6.0, name
    assert sum(count == len(SEEDS) for count in reached.values()) >= 13, reached
