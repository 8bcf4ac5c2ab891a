"""Constant rate of strain: the series of consolidation under a load that grows at a constant rate gives c_v back."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.parameter_estimates.constant_rate import constant_rate
from geoswarm.solver.parameter_estimates.values import NoEvaluationError

C_V, HEIGHT, RATE = 1.0e-3, 0.02, 400.0  # m²/day, m, kPa/day
STIFFNESS = 5.0e6  # kPa: no change of the height to speak of
TIME = np.linspace(0.2, 2.0, 91)  # day; T = 0.5 to 5


def pore_pressure(time: np.ndarray) -> np.ndarray:
    """u at the closed base: RATE H²/(2 c_v) (1 - sum 32 (-1)^m/(pi^3 (2 m + 1)^3) exp(-(2 m + 1)² pi² T/4))."""
    n = 2.0 * np.arange(200) + 1.0
    T = C_V * time / HEIGHT**2
    series = (
        32.0 * (-1.0) ** np.arange(200) / (math.pi * n) ** 3 * np.exp(-np.multiply.outer(T, (math.pi * n) ** 2 / 4.0))
    )
    return np.asarray(RATE * HEIGHT**2 / (2.0 * C_V) * (1.0 - series.sum(axis=-1)))


def test_the_steady_state_gives_the_coefficient_and_the_permeability() -> None:
    """Mean effective stress grows with the total one then, so the rate of strain is RATE/E, and k = c_v gamma_w/E."""
    u, sigma = pore_pressure(TIME), 50.0 + RATE * TIME
    strain = (RATE * TIME - 2.0 / 3.0 * u) / STIFFNESS
    found = constant_rate(TIME, strain, sigma, u, HEIGHT)
    np.testing.assert_allclose(found.effective, sigma - 2.0 / 3.0 * u)
    late = found.stress > 0.6 * found.stress.max()
    np.testing.assert_allclose(found.c_v[late], C_V, rtol=2e-3)
    np.testing.assert_allclose(found.k[late], C_V * 9.81 / STIFFNESS, rtol=5e-3)
    assert found.c_v[0] > 1.2 * C_V  # before the steady state the pressure is lower, and the method too high


def test_what_the_readings_do_not_allow_is_reported() -> None:
    sigma = 50.0 + RATE * TIME
    strain = 0.01 * TIME
    for arguments, message in (
        ((TIME[:2], strain[:2], sigma[:2], sigma[:2]), "2 readings"),
        ((TIME[::-1], strain, sigma, sigma), "times must increase"),
        ((TIME, strain, sigma, 1e-6 * sigma), "the test is too slow"),
    ):
        with pytest.raises(NoEvaluationError, match=message):
            constant_rate(*arguments, HEIGHT)
    with pytest.raises(NoEvaluationError, match="the height must be above 0 m, got 0"):
        constant_rate(TIME, strain, sigma, sigma, 0.0)
