"""Quick updates of soft soil creep and Mohr-Coulomb: against the general update, and by Taylor tests."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from geoswarm.solver.constitutive.mohr_coulomb.step import planar_mohr_coulomb
from geoswarm.solver.constitutive.soft_soil_creep.general_update import creep_update
from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.laws.soft_soil_creep import SoftSoilCreepLaw

SOIL = soft_soil_creep(0.1, 0.02, 0.005, 5.0, 25.0, 3.0)
SEEDS = st.integers(0, 2**32 - 1)


@given(
    SEEDS,
    st.sampled_from([4, 6]),
    st.sampled_from([-math.inf, -5.0, 0.0, 3.0]),
    st.floats(-5.0, -1.8),
    st.floats(0.8, 1.5),
)
@settings(max_examples=200, deadline=None)
def test_two_unknowns_give_the_general_update(seed: int, n: int, log_time: float, size: float, ratio: float) -> None:
    random = np.random.default_rng(seed)
    stress = np.array([100.0, 120.0, 90.0, 0.0, 0.0, 0.0]) + random.standard_normal(6) * ([10.0] * 3 + [15.0] * 3)
    strain = random.standard_normal(6) * 10.0**size
    stress[n:], strain[n:] = 0.0, 0.0
    before = np.array([math.log(130.0 * ratio)])
    new, after, tangent, active = SoftSoilCreepLaw.update(strain[:n], log_time, stress[:n], before, np.array(SOIL))
    general = creep_update(stress, strain, log_time, math.log(130.0 * ratio), SOIL)
    # Two unknowns are found where five or more sometimes are not; never the other way round.
    assert active == general[3] or general[3] < 0
    if general[3] >= 0:
        assert new == pytest.approx(general[0][:n], abs=1.0e-8)
        assert after[0] == pytest.approx(general[2], abs=1.0e-10)
        assert tangent == pytest.approx(general[1][:n, :n], abs=1.0e-8 * np.abs(general[1]).max())


@given(
    SEEDS,
    st.sampled_from([0.0, 25.0]),
    st.sampled_from([0.0, 10.0, 25.0]),
    st.sampled_from([0.0, 5.0, math.inf]),
    st.floats(-4.0, -1.7),
)
@settings(max_examples=300, deadline=None)
@pytest.mark.slow
def test_mohr_coulomb_returns_to_the_limit_with_its_derivative(
    seed: int, phi: float, psi: float, tension: float, size: float
) -> None:
    random = np.random.default_rng(seed)
    c, bulk, shear = 10.0, 1.0e4, 5.0e3
    friction, dilatancy = math.radians(phi), math.radians(min(psi, phi))
    constants = (bulk, shear, c, math.sin(friction), math.cos(friction), math.sin(dilatancy), tension)
    stress = np.array([10.0, 12.0, 9.0, 0.0]) + 2.0 * random.standard_normal(4)
    strain = random.standard_normal(4) * 10.0**size
    new, tangent = np.zeros(4), np.zeros((4, 4))
    limit = planar_mohr_coulomb(stress, strain, *constants, new, tangent)
    assert limit in (0, 1)
    centre, radius = 0.5 * (new[0] + new[1]), math.hypot(0.5 * (new[0] - new[1]), new[3])
    principal = sorted([centre - radius, new[2], centre + radius])
    scale = abs(principal[0]) + abs(principal[2]) + c
    excess = (principal[2] - principal[0]) - (principal[2] + principal[0]) * math.sin(friction)
    assert excess - 2.0 * c * math.cos(friction) <= 1.0e-8 * scale
    assert -principal[0] <= tension + 1.0e-8 * scale
    # Central differences; next to a kink neither side's tangent is the difference, so one of them may serve.
    way = random.standard_normal(4)
    sides = []
    other, spare = np.zeros(4), np.zeros((4, 4))
    for sign in (1.0, -1.0):
        planar_mohr_coulomb(stress, strain + sign * 1.0e-9 * way, *constants, other, spare)
        sides.append(sign * (other - new) / 1.0e-9)
    errors = [np.abs(side - tangent @ way).max() for side in sides]
    assert min(errors) <= 2.0e-4 * shear * (1.0 + np.abs(way).max())


def test_elastic_strain_leaves_no_trace() -> None:
    new, tangent = np.zeros(4), np.zeros((4, 4))
    stress, strain = np.array([20.0, 30.0, 20.0, 1.0]), np.array([1.0e-4, 2.0e-4, 0.0, 1.0e-4])
    assert planar_mohr_coulomb(stress, strain, 1.0e4, 5.0e3, 10.0, 0.4, 0.9, 0.0, 0.0, new, tangent) == 0
    assert new == pytest.approx(stress + tangent @ strain, abs=1.0e-12)


def test_beyond_the_apex_everything_ends_at_the_apex() -> None:
    new, tangent = np.zeros(4), np.zeros((4, 4))
    phi = math.radians(30.0)
    constants = (1.0e4, 5.0e3, 10.0, math.sin(phi), math.cos(phi), 0.0, math.inf)
    assert planar_mohr_coulomb(np.zeros(4), np.array([-0.01, -0.02, -0.01, 0.003]), *constants, new, tangent) == 1
    assert new[:3] == pytest.approx(-10.0 / math.tan(phi), rel=1.0e-10)
    assert new[3] == pytest.approx(0.0, abs=1.0e-10)
