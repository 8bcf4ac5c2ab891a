"""Stages of soils that hardly creep, against an integration over the creep strain in place of time.

With a creep index of 1e-5 the rate of creep falls through thousands of logarithms of time within a stage. Over the
creep strain nothing is stiff: the stress path does not depend on mu* at all, and the time at which a strain is reached
is an integral over the path. Equations: Vermeer & Neher (1999), translated by c cot(phi).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from geoswarm.solver.constitutive.soft_soil_creep.physics import friction_constant, soft_soil_creep
from geoswarm.solver.element_test.constant_load import FINISHED, constant_load_history
from tests.variants import variants

NU, DURATION = 0.15, 1.0


@dataclass(frozen=True)
class Case:
    """A soil and one stage on a normally consolidated specimen; kPa, degree."""

    stiffness: float
    swelling: float
    cohesion: float
    phi: float
    before: float
    load: float


CASES = {"clay": Case(0.1, 0.02, 1.0, 30.0, 50.0, 75.0), "published": Case(0.082, 0.051, 25.0, 20.0, 200.0, 400.0)}


def strain_by_creep(case: Case, mu: float) -> float:
    """Axial strain at the end of the stage."""
    sine = math.sin(math.radians(case.phi))
    shift, K0 = case.cohesion / math.tan(math.radians(case.phi)), 1.0 - sine
    M = friction_constant(K0, NU, case.stiffness / case.swelling)
    shear = 1.5 * (1.0 - 2.0 * NU) / (1.0 + NU)

    def pressures(axial: float, lateral: float) -> tuple[float, float, float]:
        mean, q = (axial + 2.0 * lateral) / 3.0 + shift, axial - lateral
        return mean, q, mean + q * q / (M * M * mean)

    mean_before, _, past = pressures(case.before, K0 * case.before)
    lateral = K0 * case.before + NU / (1.0 - NU) * (case.load - case.before)

    def stress_rate(_creep: float, state: np.ndarray) -> list[float]:
        mean, q, _ = pressures(case.load, float(state[0]))
        stiffness = mean / case.swelling
        flow = 2.0 * q / (M * M * mean) / (1.0 - q * q / (M * M * mean * mean))
        return [(0.5 * flow - 1.0 / 3.0) / (2.0 / 9.0 / stiffness + 1.0 / (6.0 * shear * stiffness))]

    path = solve_ivp(
        stress_rate, (0.0, 0.08), [lateral], method="DOP853", rtol=1e-12, atol=1e-12, dense_output=True
    ).sol

    def log_rate(creep: np.ndarray) -> np.ndarray:
        """ln of the creep rate over mu*/tau."""
        equivalent = np.array([pressures(case.load, float(path(e)[0]))[2] for e in creep])
        return (case.stiffness - case.swelling) / mu * np.log(equivalent / past) - creep / mu

    nodes, weights = np.polynomial.legendre.leggauss(12)

    def log_time(creep: float) -> float:
        """ln of the time [day] until a creep strain; what is more than 60 mu* before it took no time."""
        edges = np.linspace(max(0.0, creep - 60.0 * mu), creep, 121)
        half = 0.5 * np.diff(edges)[:, None]
        points = edges[:-1, None] + half * (1.0 + nodes)
        last = float(log_rate(np.array([creep]))[0])
        slower = np.exp(last - log_rate(points.ravel()).reshape(points.shape))
        return float(np.log(np.sum(half * weights * slower) / mu)) - last

    creep = brentq(lambda e: log_time(e) - math.log(DURATION), 1e-4, 0.079, xtol=1e-13)
    return case.swelling * math.log(pressures(case.load, float(path(creep)[0]))[0] / mean_before) + creep


@pytest.mark.parametrize("name", CASES)
@pytest.mark.parametrize("mu", [1.0e-3, 1.0e-5, 1.0e-6])
@pytest.mark.parametrize("tolerance", variants([1.0e-5, 1.0e-7], {1.0e-7}))
def test_the_strain_after_a_stage_meets_the_tolerance(name: str, mu: float, tolerance: float) -> None:
    case = CASES[name]
    soil = soft_soil_creep(case.stiffness, case.swelling, mu, case.cohesion, case.phi, nu_ur=NU)
    lateral = soil.K0nc * case.before
    mean, q = (case.before + 2.0 * lateral) / 3.0 + soil.attraction, case.before - lateral
    past = math.log(mean + q * q / (soil.M * soil.M * mean))
    stage = np.array([case.load]), np.array([DURATION])
    nothing = np.empty((0, 2))
    status, _, _, _, ends = constant_load_history(
        soil,
        *stage,
        -1.0,
        case.before,
        lateral,
        past,
        tolerance,
        np.empty(0),
        np.zeros(2, dtype=np.int64),
        nothing,
        nothing,
    )
    assert status == FINISHED
    assert ends[0, 0] == pytest.approx(strain_by_creep(case, mu), abs=tolerance)
