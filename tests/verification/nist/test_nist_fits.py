"""Certified parameters to six digits after polishing, certified standard deviations to 1 %."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Linearisation, design, from_evaluations
from geoswarm.solver.identifiability.optimum.polish import Polished, polish
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.verification.exact.nist import BOXBOD, MGH09, PROBLEMS, THURBER, Certified

pytestmark = pytest.mark.usefixtures("independent_noise")


def fit(case: Certified) -> tuple[Polished, Linearisation]:
    changes: dict[str, Any] = {"answer": {"max_evaluations": "off"}}  # what follows the search is done here
    if case in QUICK:
        changes["stopping"] = {"max_evaluations": 200}
    problem = parse_problem(case.document(**changes))
    calibration = Calibration(problem, 1)
    best = calibrate(problem).best
    assert best is not None
    polished = polish(calibration, best.parameters)
    plan = design(calibration, polished.parameters)
    return polished, from_evaluations(calibration, plan, [calibration.evaluate(x) for x in plan.positions])


QUICK = (BOXBOD,)


@pytest.mark.parametrize(
    "case",
    [pytest.param(case, marks=() if case in QUICK else pytest.mark.slow, id=case.name) for case in PROBLEMS],
)
def test_swarm_and_polishing_reach_the_certified_values(case: Certified) -> None:
    polished, linearisation = fit(case)
    certified = np.array([row[0] for row in case.parameters.values()])
    deviations = np.array([row[1] for row in case.parameters.values()])
    assert polished.converged
    np.testing.assert_allclose(polished.parameters, certified, rtol=5e-7)
    np.testing.assert_allclose(polished.objective * len(case.x), case.residual_sum_of_squares, rtol=1e-9)
    np.testing.assert_allclose(linearisation.standard_errors, deviations, rtol=1e-2)
    assert linearisation.at_optimum
    assert linearisation.degrees_of_freedom == len(case.x) - len(certified)
    assert linearisation.noise is not None
    expected = np.sqrt(case.residual_sum_of_squares / linearisation.degrees_of_freedom)
    np.testing.assert_allclose(linearisation.noise.deviations["y"], expected, rtol=1e-6)


@pytest.mark.parametrize("case", [THURBER, MGH09], ids=lambda case: case.name)
def test_standard_deviations_do_not_hang_on_the_step(case: Certified) -> None:
    problem = parse_problem(case.document())
    calibration = Calibration(problem, 1)
    certified = np.array([row[0] for row in case.parameters.values()])
    deviations = np.array([row[1] for row in case.parameters.values()])
    for step in (1e-3, 5e-3, 1e-2):
        plan = design(calibration, certified, step=step)
        evaluations = [calibration.evaluate(x) for x in plan.positions]
        errors = from_evaluations(calibration, plan, evaluations).standard_errors
        np.testing.assert_allclose(errors, deviations, rtol=1e-2)
