"""Sobol and Morris indices of functions whose indices are known."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import InfeasibleSpaceError
from geoswarm.solver.identifiability import StatisticsError
from geoswarm.solver.identifiability.stored.global_sensitivity import analyse_design, outputs_of
from geoswarm.solver.methods.global_designs import MorrisMethod, SobolMethod
from tests.solver.identifiability.cases import X, free, problem_of


def test_first_order_and_total_indices_of_a_sum_and_a_product() -> None:
    # y = a + 2 b + 0 c over the unit cube: variances 1/12, 4/12
    parameters = {name: free(0.0, 1.0) for name in "abc"}
    calibration = Calibration(problem_of("a + 2 * b + 0 * c", parameters, X), 1)
    plan = SobolMethod(samples=512).points(calibration.space, 1)
    assert len(plan.positions) == 512 * 5
    evaluations = [calibration.evaluate(x) for x in plan.positions]
    found = analyse_design(calibration, plan, outputs_of(calibration, evaluations, "y"), output="y")
    np.testing.assert_allclose([i.main for i in found.indices], [0.2, 0.8, 0.0], atol=0.02)
    np.testing.assert_allclose([i.total for i in found.indices], [0.2, 0.8, 0.0], atol=0.02)
    assert (found.blocks, found.dropped) == (512, 0)


def test_elementary_effects_of_a_linear_function() -> None:
    calibration = Calibration(problem_of("a + 2 * b + 3", {"a": free(0.0, 1.0), "b": free(0.0, 1.0)}, X), 1)
    plan = MorrisMethod(samples=20).points(calibration.space, 0)
    evaluations = [calibration.evaluate(x) for x in plan.positions]
    found = analyse_design(calibration, plan, outputs_of(calibration, evaluations, "y"), output="y")
    np.testing.assert_allclose([i.main for i in found.indices], [1.0, 2.0], rtol=1e-9)
    np.testing.assert_allclose([i.total for i in found.indices], 0.0, atol=1e-9)


def test_designs_keep_to_the_constraints_and_drop_what_failed() -> None:
    parameters = {"a": free(0.0, 1.0), "b": free(0.0, 1.0)}
    calibration = Calibration(problem_of("a + b", parameters, X, constraints=["a + b < 1.2"]), 1)
    plan = SobolMethod(samples=128).points(calibration.space, 0)
    assert len(plan.positions) == 128 * 4
    assert (plan.positions.sum(axis=1) < 1.2).all()
    outputs = outputs_of(calibration, [calibration.evaluate(x) for x in plan.positions], "objective")
    outputs[[5, 6, 40]] = np.nan
    found = analyse_design(calibration, plan, outputs)
    assert (found.blocks, found.dropped) == (126, 2)
    outputs[:] = np.nan
    with pytest.raises(StatisticsError, match="only 0 of 128 blocks"):
        analyse_design(calibration, plan, outputs)
    morris = MorrisMethod(samples=16).points(calibration.space, 0)
    assert len(morris.positions) == 16 * 3
    assert (morris.positions.sum(axis=1) < 1.2).all()


@pytest.mark.slow
def test_a_design_without_feasible_blocks_is_refused() -> None:
    parameters = {"a": free(0.0, 1.0), "b": free(0.0, 1.0)}
    narrow = problem_of("a + b", parameters, X, constraints=["a - b < 1e-3", "b - a < 1e-3"])
    plan = MorrisMethod(samples=10).points(Calibration(narrow, 1).space, 0)
    with pytest.raises(InfeasibleSpaceError, match="of the morris design satisfy the constraints"):
        _ = plan.positions


def test_wrong_requests_are_refused() -> None:
    calibration = Calibration(problem_of("a * x", {"a": free()}, X), 1)
    plan = SobolMethod(samples=8).points(calibration.space, 0)
    with pytest.raises(StatisticsError, match="known: objective, y"):
        outputs_of(calibration, [], "z")
    with pytest.raises(StatisticsError, match="1 outputs are given"):
        analyse_design(calibration, plan, np.ones(1))
    constant = analyse_design(calibration, plan, np.ones(len(plan.positions)))
    assert constant.indices[0].total == 0.0
