"""The driver against an independent integration of the rate equations by SciPy's implicit Runge-Kutta method."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geoswarm.solver.constitutive.soft_soil_creep.physics import SoftSoilCreep, soft_soil_creep
from geoswarm.solver.element_test.boundary_conditions import Stage, strain_change
from geoswarm.solver.element_test.material_point import follow
from geoswarm.solver.element_test.setups import confined_load
from geoswarm.verification.exact.creep import cone
from geoswarm.verification.specimens.soils import creep_law, creep_point

LAMBDA, KAPPA, MU, C, PHI, NU, K0NC = 0.11, 0.03, 0.004, 30.0, 35.0, 0.2, 0.48
ATTRACTION = C / math.tan(math.radians(PHI))
M = cone(K0NC, NU, LAMBDA / KAPPA)
COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")


def soil(formulation: str) -> SoftSoilCreep:
    return soft_soil_creep(LAMBDA, KAPPA, MU, C, PHI, 0.0, NU, K0NC, formulation=formulation)  # type: ignore[arg-type]


def creep_rate(stress: np.ndarray, log_pp: float, shift: float) -> tuple[np.ndarray, float]:
    """Creep strain rate (3, 3) and volume rate from full tensors, written down from the definitions."""
    p = np.trace(stress) / 3.0
    s = stress - p * np.eye(3)
    P = p + ATTRACTION
    q2 = 1.5 * (s * s).sum()
    p_eq = p + shift + q2 / (M**2 * P)
    alpha = 1.0 - q2 / (M * P) ** 2
    volume = MU * math.exp((LAMBDA - KAPPA) / MU * (math.log(p_eq) - log_pp))
    return volume / alpha * (alpha * np.eye(3) / 3.0 + 3.0 * s / (M**2 * P)), volume


def stress_rate(stress: np.ndarray, elastic: np.ndarray, shift: float) -> np.ndarray:
    K = (np.trace(stress) / 3.0 + shift) / KAPPA
    G = 1.5 * K * (1.0 - 2.0 * NU) / (1.0 + NU)
    volume = np.trace(elastic)
    return K * volume * np.eye(3) + 2.0 * G * (elastic - volume / 3.0 * np.eye(3))


def tensor(components: np.ndarray, shear: float = 1.0) -> np.ndarray:
    xx, yy, zz, xy, yz, zx = components
    return np.array([[xx, shear * xy, shear * zx], [shear * xy, yy, shear * yz], [shear * zx, shear * yz, zz]])


def integrate(rate: Callable[[float, np.ndarray], np.ndarray], y0: np.ndarray, times: np.ndarray) -> np.ndarray:
    result = solve_ivp(
        rate, (0.0, times[-1]), y0, method="Radau", t_eval=times, rtol=1.0e-9, atol=1.0e-10, first_step=1.0e-9
    )
    assert result.success
    return np.asarray(result.y.T)


@pytest.mark.parametrize("formulation", ["translated", "untranslated"])
def test_a_general_strain_path_with_turning_axes(formulation: str) -> None:
    shift = ATTRACTION if formulation == "translated" else 0.0
    strain = np.array([0.01, -0.004, 0.03, 0.02, -0.01, 0.015])
    start = creep_point([60.0, 70.0, 100.0, 4.0, -6.0, 2.0], soil(formulation), OCR=1.2)
    times = np.array([0.2, 1.0, 2.0])

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        stress = y[:9].reshape(3, 3)
        creep, volume = creep_rate(stress, y[9], shift)
        change = stress_rate(stress, tensor(strain, 0.5) / 2.0 - creep, shift)
        return np.append(change.ravel(), volume / (LAMBDA - KAPPA))

    expected = integrate(rate, np.append(tensor(start.stress).ravel(), start.internal[0]), times)
    controls = tuple(strain_change(float(value), **{name: 1}) for value, name in zip(strain, COMPONENTS, strict=True))
    history = follow(creep_law(soil(formulation)), start, [Stage("path", 2.0, controls)], [times], tolerance=1.0e-8)
    for index in range(times.size):
        assert tensor(history.stress[index]) == pytest.approx(expected[index, :9].reshape(3, 3), rel=1e-5, abs=1e-4)
    assert history.internal[:, 0] == pytest.approx(expected[:, 9], rel=1.0e-6)


@pytest.mark.parametrize("formulation", ["translated", "untranslated"])
def test_a_confined_hold(formulation: str) -> None:
    """Constant vertical stress without lateral strain: lateral stress, strain, ln p_p as an initial value problem."""
    shift = ATTRACTION if formulation == "translated" else 0.0
    start = creep_point([60.0, 60.0, 100.0, 0.0, 0.0, 0.0], soil(formulation), OCR=1.1)
    times = np.array([1.0e-3, 0.1, 5.0])
    stages = [confined_load(160.0, 5.0)]
    loaded = follow(creep_law(soil(formulation)), start, [confined_load(160.0, 0.0)], [[0.0]], tolerance=1.0e-9).end

    def rate(_: float, y: np.ndarray) -> np.ndarray:
        stress = np.diag([y[0], y[0], 160.0])
        creep, volume = creep_rate(stress, y[2], shift)
        unit = stress_rate(stress, np.diag([0.0, 0.0, 1.0]), shift)
        relaxing = stress_rate(stress, -creep, shift)
        axial = -relaxing[2, 2] / unit[2, 2]
        return np.array([relaxing[0, 0] + axial * unit[0, 0], axial, volume / (LAMBDA - KAPPA)])

    expected = integrate(rate, np.array([loaded.stress[0], loaded.strain[2], loaded.internal[0]]), times)
    history = follow(creep_law(soil(formulation)), start, stages, [times], tolerance=1.0e-8)
    assert history.stress[:, 0] == pytest.approx(expected[:, 0], rel=1.0e-5)
    assert history.strain[:, 2] == pytest.approx(expected[:, 1], rel=1.0e-5)
    assert history.internal[:, 0] == pytest.approx(expected[:, 2], rel=1.0e-6)
