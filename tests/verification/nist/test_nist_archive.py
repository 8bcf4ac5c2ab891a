"""Certified standard deviations without a step from anybody, and certified parameters by a polished search alone."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, Samples, analyse, from_evaluations
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.runs.local import calibrate
from tests.verification.nist.archive import NAMES, ArchiveSet, archive_set

WITHIN = 1.01
SEEDS = range(1, 6)


def search(case: ArchiveSet, seed: int) -> tuple[CalibrationResult, float]:
    """A polished search, and its sum of squares over the certified one."""
    result = calibrate(parse_problem(case.document()), seed=seed)
    assert result.objective is not None
    assert result.evaluations <= 1000
    return result, result.objective * len(case.x) / case.residual_sum_of_squares


def at_certified(name: str) -> tuple[Calibration, Linearisation, Samples]:
    case = archive_set(name)
    problem = parse_problem(case.document())
    calibration = Calibration(problem, 1)
    plan, evaluations = evaluate_differences(calibration, case.certified)
    best = evaluations[0].objective
    assert best is not None
    samples = Samples.from_arrays(problem, case.certified[None], np.array([best]))
    return calibration, from_evaluations(calibration, plan, evaluations), samples


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.usefixtures("independent_noise")
def test_certified_standard_deviations_of_independent_noise(name: str) -> None:
    _, found, _ = at_certified(name)
    np.testing.assert_allclose(found.standard_errors, archive_set(name).deviations, rtol=2e-4)


@pytest.mark.parametrize("name", NAMES)
def test_no_false_word_at_the_certified_values(name: str) -> None:
    calibration, found, samples = at_certified(name)
    assert found.without_influence == found.unclear == found.held == ()
    assert found.at_optimum
    assert (found.standard_errors > 0.999 * archive_set(name).deviations).all()  # correlated residuals widen them
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


@pytest.mark.parametrize(("name", "start"), [("MGH10", 1), ("MGH10", 2), ("Lanczos3", 1), ("Hahn1", 2)])
def test_bounds_four_decades_apart_keep_no_search_from_the_minimum(name: str, start: int) -> None:
    """On a log scale nothing was found to enter linearly, and the search followed its valley until all runs were used.

    Bounds are the start values over and times 100, or 1000 where the certified values lie beyond.
    """
    case = archive_set(name)
    factor = 1000.0 if (name, start) == ("MGH10", 1) else 100.0
    document = case.document(start, factor, "log", answer={"max_evaluations": "off"})
    result = calibrate(parse_problem(document), seed=2)
    assert result.stop_reasons == ("polished",)
    assert result.objective is not None
    assert result.objective * len(case.x) == pytest.approx(case.residual_sum_of_squares, rel=1e-6)


def improvable(case: ArchiveSet, result: CalibrationResult) -> float:
    """By which share SciPy's least squares lower the sum of squares from the best set, inside the bounds."""
    calibration = Calibration(parse_problem(case.document()), 1)
    space = calibration.space
    assert result.best is not None

    def residuals(unit: FloatArray) -> FloatArray:
        responses = calibration.evaluate(space.from_unit(np.clip(unit, 0.0, 1.0))).responses
        return responses["y"] - case.y

    place = np.clip(space.to_unit(result.best.parameters), 1e-12, 1.0 - 1e-12)
    lower = least_squares(residuals, place, jac="3-point", bounds=(0.0, 1.0), x_scale="jac", xtol=1e-14, ftol=1e-14)
    assert result.objective is not None
    return 1.0 - 2.0 * float(lower.cost) / (result.objective * len(case.x))


@pytest.mark.slow
def test_thirteen_of_sixteen_sets_within_a_thousand_runs() -> None:
    """Measured: 13 sets in all five seeds, Gauss1, Gauss3 and ENSO in none (docs/statistics.md).

    Where another minimum is called polished, it is one: SciPy finds nothing lower beside it, and the model is said
    not to describe the data there. The best run is the result.
    """
    reached = {}
    for name in NAMES:
        case = archive_set(name)
        ends = [search(case, seed) for seed in SEEDS]
        reached[name] = sum(ratio < WITHIN for _, ratio in ends)
        for result, ratio in ends:
            assert result.best is not None
            objectives = [record.evaluation.objective for record in result.history]
            assert result.objective == min(f for f in objectives if f is not None)
            assert result.stop_reasons in (("polished",), ("max_evaluations",), ("polish_unfinished",)), name
            if result.stop_reasons == ("polished",):
                assert improvable(case, result) < 1e-6, name
                if ratio < WITHIN:
                    assert case.digits(result.best.parameters) >= 6.0, name
                else:
                    calibration = Calibration(parse_problem(case.document()), 1)
                    plan, evaluations = evaluate_differences(calibration, result.best.parameters)
                    assert from_evaluations(calibration, plan, evaluations).fit.kind == "lack_of_fit", name
    assert sum(count == len(SEEDS) for count in reached.values()) >= 13, reached
