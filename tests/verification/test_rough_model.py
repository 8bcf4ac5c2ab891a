"""A forward model with kinks: parameters keep their intervals where the derivative to one of them is uncertain."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from scipy.optimize import least_squares

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.identifiability import Samples, analyse, from_evaluations
from geoswarm.solver.identifiability.optimum.bending import likelihood_intervals
from geoswarm.solver.identifiability.optimum.differences import evaluate_differences
from geoswarm.solver.problem import Problem, parse_problem

TRUTH = {"E50_ref": 30e3, "Eoed_ref": 30e3, "Eur_ref": 90e3, "m": 0.6, "c": 5.0, "phi": 34.0, "psi": 4.0}
FREE: dict[str, dict[str, Any]] = {
    "E50_ref": {"lower": 5e3, "upper": 1e5, "scale": "log"},
    "Eoed_ref": {"lower": 5e3, "upper": 1e5, "scale": "log"},
    "Eur_ref": {"lower": 2e4, "upper": 4e5, "scale": "log"},
    "m": {"lower": 0.2, "upper": 1.0},
    "c": {"lower": 0.1, "upper": 30.0},
    "phi": {"lower": 20.0, "upper": 45.0},
    "psi": {"lower": 0.0, "upper": 15.0},
}
FIXED = {"nu_ur": {"value": 0.2}, "K0nc": {"value": 0.44}, "p_ref": {"value": 100}, "R_f": {"value": 0.9}}
ERRORS = {"q": 3.0, "volumetric_strain": 5e-4}  # kPa; -
CELLS = (100, 200, 400)  # kPa
STRAIN = np.linspace(0.002, 0.12, 30)


def triaxial_tests(readings: dict[str, FloatArray]) -> Problem:
    """Three drained triaxial tests on one hardening soil: 180 readings, seven free parameters."""
    loading = [{"kind": "monotonic", "axial_strain": 0.13}]
    part = {"kind": "triaxial", "material": "hardening_soil", "shearing": loading}
    observations = [
        {"series": name, "points": {"x": STRAIN.tolist(), "y": y.tolist()}, "error": ERRORS[name.split(".")[1]]}
        for name, y in readings.items()
    ]
    return parse_problem(
        {
            "forward_model": {
                "kind": "combined",
                "parts": {f"cell_{stress}": part | {"initial_stress": stress} for stress in CELLS},
            },
            "parameters": FREE | FIXED,
            "weighting": "by_error",
            "observations": observations,
            "stopping": {"max_evaluations": 1000},
            "seed": 1,
        }
    )


@pytest.mark.slow
def test_triaxial_tests_give_their_parameters_intervals() -> None:
    random = np.random.default_rng(1)
    names = [f"cell_{stress}.{quantity}" for stress in CELLS for quantity in ERRORS]
    errors = {name: ERRORS[name.split(".")[1]] for name in names}
    exact = Calibration(triaxial_tests({name: np.ones(30) for name in names}), 1).evaluate(np.array([*TRUTH.values()]))
    readings = {name: exact.responses[name] + errors[name] * random.standard_normal(30) for name in names}
    problem = triaxial_tests(readings)
    calibration = Calibration(problem, 1)

    def residuals(relative: FloatArray) -> FloatArray:
        responses = calibration.evaluate(relative * np.array([*TRUTH.values()])).responses
        return np.concatenate([(responses[name] - readings[name]) / errors[name] for name in names])

    # least squares and its standard errors from central differences of one percent, independently
    fitted = least_squares(residuals, np.ones(7), jac="3-point", diff_step=0.01)
    deviations = np.sqrt(np.diag(np.linalg.inv(fitted.jac.T @ fitted.jac)))
    optimum = fitted.x * np.array([*TRUTH.values()])
    found = likelihood_intervals(
        calibration, from_evaluations(calibration, *evaluate_differences(calibration, optimum))
    )
    assert found.unclear == ()
    relative_errors = found.standard_errors / optimum * fitted.x
    clear = [name != "Eur_ref" for name in found.names]  # there is no unloading
    np.testing.assert_allclose(relative_errors[clear], deviations[clear], rtol=0.1)
    # the two moduli of loading have the same bounds: a run with swapped values shows that they are not the same
    runs = [(place, calibration.evaluate(place).objective) for place in (optimum, optimum[[1, 0, 2, 3, 4, 5, 6]])]
    samples = Samples.from_arrays(problem, optimum[None], np.array([runs[0][1]]))
    verdicts = analyse(calibration, samples, linearisation=found, elsewhere=runs[1:]).verdicts
    assert {verdict.kind for verdict in verdicts if verdict.parameter != "Eur_ref"} == {"identified"}
    for name, truth in TRUTH.items():
        low, high = found.interval(name) or (-np.inf, np.inf)
        assert low - 0.5 * (high - low) < truth < high + 0.5 * (high - low)
