"""Hypoplasticity of clay against closed forms of its paper, its asymptotic states, and an independent integration."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.material_point import follow, point_under
from geoswarm.solver.element_test.setups import drained_triaxial, undrained_triaxial
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.exact.hypoplastic_rates import State, clay_rates, matrix, strained, triaxial, vector
from geoswarm.verification.exact.hypoplasticity import DORTMUND

SMALL_STRAINS = {"R": 1.0e-4, "m_R": 4.5, "m_T": 3.0, "beta_r": 0.5, "chi": 1.5}

ALL_ROUND = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
SINE = math.sin(math.radians(DORTMUND["phi_c"]))
SOFT, STIFF, N = DORTMUND["lambda_star"], DORTMUND["kappa_star"], DORTMUND["N"]


def clay(**changes: float) -> Soil:
    """Dortmund clay with other values."""
    return find_law("hypoplastic_clay").soil({**DORTMUND, **changes})


def stepped(soil: Soil, stress: FloatArray, state: FloatArray, strain: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Stress and state after a straight path of strain."""
    new, new_state, _, status = soil.law.update(strain, -math.inf, stress, state, soil.constants)
    assert status >= 0
    return new, new_state


def placed(soil: Soil, stress: FloatArray) -> FloatArray:
    """State variables where the soil is placed."""
    return soil.law.initial_state(stress, soil.constants)


def equivalent(e: float) -> float:
    """Mean stress of isotropic normal compression at a void ratio, kPa."""
    return math.exp((N - math.log(1.0 + e)) / SOFT)


@pytest.mark.parametrize("factor", [1.1, 4.0, 20.0])
def test_isotropic_normal_compression_is_a_line(factor: float) -> None:
    soil, stress = clay(), 50.0 * ALL_ROUND
    state = placed(soil, stress)
    assert equivalent(state[0]) == pytest.approx(50.0, rel=1.0e-12)
    new, after = stepped(soil, stress, state, SOFT * math.log(factor) / 3.0 * ALL_ROUND)
    assert new == pytest.approx(50.0 * factor * ALL_ROUND, rel=1.0e-7, abs=1.0e-9)
    assert equivalent(after[0]) == pytest.approx(50.0 * factor, rel=1.0e-10)


@pytest.mark.parametrize(("OCR", "volume"), [(1.0, -0.01), (3.0, 0.01), (3.0, -0.01)])
def test_isotropic_paths_follow_their_scalar_equation(OCR: float, volume: float) -> None:
    """dp/deps_v = p (S -+ (p/p_e)^alpha (S - 1/lambda*)), S = (1/lambda* + 1/kappa*)/2; first unloading: p/kappa*."""
    a = math.sqrt(3.0) * (3.0 - SINE) / (2.0 * math.sqrt(2.0) * SINE)
    alpha = math.log((SOFT - STIFF) / (SOFT + STIFF) * (3.0 + a * a) / (a * math.sqrt(3.0))) / math.log(2.0)
    mean = 0.5 * (1.0 / SOFT + 1.0 / STIFF)
    soil, stress = clay(OCR=OCR), 200.0 * ALL_ROUND
    state = placed(soil, stress)
    e0, way = state[0], math.copysign(1.0, volume)

    def change(x: float, y: FloatArray) -> list[float]:
        e = (1.0 + e0) * math.exp(-volume * x) - 1.0
        return [volume * y[0] * (mean - way * (y[0] / equivalent(e)) ** alpha * (mean - 1.0 / SOFT))]

    exact = solve_ivp(change, (0.0, 1.0), [200.0], rtol=1.0e-12, atol=1.0e-12).y[0, -1]
    new, _ = stepped(soil, stress, state, volume / 3.0 * ALL_ROUND)
    assert new == pytest.approx(exact * ALL_ROUND, rel=1.0e-7, abs=1.0e-9)
    if OCR == 1.0:
        tiny = -1.0e-7
        new, _ = stepped(soil, stress, state, tiny / 3.0 * ALL_ROUND)
        assert (new[0] - 200.0) / tiny == pytest.approx(200.0 / STIFF, rel=1.0e-4)


def asymptotic(stress: FloatArray) -> FloatArray:
    """Direction of strain (6,), of any length, that the paper gives to a stress, from the printed tensor form."""
    T = matrix(stress)
    T_dev = T / np.trace(T) - np.eye(3) / 3.0
    I1, I2, I3 = np.trace(T), 0.5 * ((T * T).sum() - np.trace(T) ** 2), np.linalg.det(T)
    F = (9.0 * I3 + I1 * I2) / (I3 + I1 * I2)
    norm = math.sqrt(float((T_dev * T_dev).sum()))
    cosine = -math.sqrt(6.0) * float(np.trace(T_dev @ T_dev @ T_dev)) / norm**3
    xi = 1.7 + 3.9 * SINE**2
    part = (2.0 / 3.0 - (cosine + 1.0) / 4.0 * F**0.25) * (F ** (xi / 2.0) - SINE**xi) / (1.0 - SINE**xi)
    return vector(-T_dev + part * np.eye(3), 2.0)


@pytest.mark.parametrize(
    "start",
    [[60.0, 60.0, 100.0, 0.0, 0.0, 0.0], [100.0, 100.0, 55.0, 0.0, 0.0, 0.0], [70.0, 100.0, 60.0, 10.0, -5.0, 3.0]],
    ids=["compression", "extension", "general"],
)
def test_asymptotic_states_stay_ones(start: list[float]) -> None:
    """From the state boundary along its direction: the stress ratio stays, ln(1 + e) falls by lambda* over ln(p)."""
    soil, stress = clay(), np.array(start)
    state = placed(soil, stress)
    direction = asymptotic(stress)
    volume = 0.03
    new, after = stepped(soil, stress, state, volume / direction[:3].sum() * direction)
    assert new == pytest.approx(stress * math.exp(volume / SOFT), rel=1.0e-6, abs=1.0e-6)
    assert after[7] == pytest.approx(state[7], rel=1.0e-6)
    assert after == pytest.approx([placed(soil, new)[0], *np.zeros(6), after[7]], rel=1.0e-6)


def test_normal_one_dimensional_compression_keeps_K0() -> None:
    """The exponent xi of the paper is such that K0 is about 1 - sin(phi_c)."""
    for phi in (20.0, 25.0, 30.0, 35.0):
        soil = clay(phi_c=phi)
        K0 = soil.law.K0(soil.constants)
        assert soil.law.K0(soil.constants) == pytest.approx(1.0 - math.sin(math.radians(phi)), rel=0.01)
        stress = np.array([100.0 * K0, 100.0 * K0, 100.0, 0.0, 0.0, 0.0])
        new, _ = stepped(soil, stress, placed(soil, stress), np.array([0.0, 0.0, 0.05, 0.0, 0.0, 0.0]))
        assert new == pytest.approx(stress * math.exp(0.05 / SOFT), rel=1.0e-6, abs=1.0e-9)


@pytest.mark.parametrize("OCR", [1.0, 2.0, 10.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
def test_undrained_strength_is_that_of_the_void_ratio(OCR: float, way: float) -> None:
    """p = p_e/2 and q = M p in the end, in compression and extension, whatever the overconsolidation."""
    soil = clay(OCR=OCR)
    start = point_under(100.0 * ALL_ROUND, soil)
    history = follow(soil, start, [undrained_triaxial(way * 3.0, 1.0)], [[0.9, 1.0]], tolerance=1.0e-7)
    p = 0.5 * equivalent(float(start.internal[0]))
    M = 6.0 * SINE / (3.0 - way * SINE)
    assert history.p == pytest.approx(p, rel=1.0e-4)
    assert history.q == pytest.approx(M * p, rel=1.0e-4)
    assert history.internal[:, 7] == pytest.approx(DORTMUND["phi_c"], rel=1.0e-4)


@pytest.mark.parametrize("OCR", [1.0, 4.0])
def test_drained_shear_ends_on_the_critical_state_line(OCR: float) -> None:
    soil = clay(OCR=OCR)
    start = point_under(100.0 * ALL_ROUND, soil)
    history = follow(soil, start, [drained_triaxial(4.0, 100.0, 1.0)], [[0.9, 1.0]], tolerance=1.0e-7)
    assert history.q / history.p == pytest.approx(6.0 * SINE / (3.0 - SINE), rel=1.0e-4)
    assert np.log(1.0 + history.internal[:, 0]) == pytest.approx(N - SOFT * np.log(2.0 * history.p), rel=1.0e-4)


def test_the_critical_state_is_one_of_no_change() -> None:
    for ratio in (0.3, 1.0, -0.5):
        principal = np.array([1.0 + ratio, 1.0, 0.0])
        low, high = 0.0, 1.0e3
        for _ in range(200):  # the cone of Matsuoka and Nakai
            base = 0.5 * (low + high)
            s = principal + base
            invariant = s.sum() * (s[0] * s[1] + s[1] * s[2] + s[2] * s[0]) / s.prod()
            low, high = (base, high) if invariant > 9.0 + 8.0 * SINE**2 / (1.0 - SINE**2) else (low, base)
        stress = np.array([*(100.0 * s / s.mean()), 0.0, 0.0, 0.0])
        soil = clay(e0=math.exp(N - SOFT * math.log(200.0)) - 1.0)
        state = placed(soil, stress)
        direction = asymptotic(stress)
        assert direction[:3].sum() == pytest.approx(0.0, abs=1.0e-9)
        new, after = stepped(soil, stress, state, 1.0e-3 * direction)
        assert new == pytest.approx(stress, rel=1.0e-7)
        assert after[0] == pytest.approx(state[0], rel=1.0e-9)


def test_overconsolidation_counts_along_the_stress_ratio() -> None:
    stress = np.array([60.0, 60.0, 100.0, 0.0, 0.0, 0.0])
    normal, over = clay(), clay(OCR=3.0)
    assert placed(over, stress)[0] == pytest.approx(placed(normal, 3.0 * stress)[0], rel=1.0e-12)
    given = clay(e0=float(placed(over, stress)[0]))
    assert placed(given, stress) == pytest.approx(placed(over, stress), rel=1.0e-12)


@pytest.mark.parametrize("drained", [True, False])
@pytest.mark.parametrize("extra", [{}, SMALL_STRAINS], ids=["plain", "small strains"])
def test_triaxial_cycles_are_those_of_the_rate_equations(extra: Mapping[str, float], drained: bool) -> None:
    given, soil = {**DORTMUND, **extra}, clay(OCR=1.5, **extra)
    largest = 0.5 * SMALL_STRAINS["R"] if extra else math.inf
    stress = np.array([80.0, 80.0, 100.0, 0.0, 0.0, 0.0])
    state, wanted, cycles = State(stress, float(placed(soil, stress)[0]), np.zeros(6)), [], (2.0e-3, -3.0e-3, 2.0e-3)
    for axial in cycles:
        wanted += triaxial(clay_rates(given), given, state, axial, np.array([0.3, 1.0]), drained, largest / abs(axial))
        state = wanted[-1]
    stages = [drained_triaxial(one, 80.0, 1.0) if drained else undrained_triaxial(one, 1.0) for one in cycles]
    found = follow(soil, point_under(stress, soil), stages, [[0.3, 1.0]] * len(cycles), tolerance=1.0e-9)
    for row, one in enumerate(wanted):
        assert found.stress[row] == pytest.approx(one.stress, abs=1.0e-6 * np.abs(one.stress).max())
        assert found.internal[row, 0] == pytest.approx(one.e, abs=1.0e-8)
        assert found.internal[row, 1:7] == pytest.approx(one.h, abs=1.0e-6 * SMALL_STRAINS["R"])


@pytest.mark.parametrize("OCR", [1.2, 5.0])
@pytest.mark.parametrize("drained", [True, False])
def test_monotonic_triaxial_tests_are_those_of_the_rate_equations(OCR: float, drained: bool) -> None:
    soil, stress = clay(OCR=OCR), np.array([60.0, 60.0, 80.0, 0.0, 0.0, 0.0])
    fractions = np.array([0.001, 0.01, 0.1, 0.5, 1.0])
    start = State(stress, float(placed(soil, stress)[0]), np.zeros(6))
    wanted = triaxial(clay_rates(DORTMUND), DORTMUND, start, 0.2, fractions, drained)
    stage = drained_triaxial(0.2, 60.0, 1.0) if drained else undrained_triaxial(0.2, 1.0)
    found = follow(soil, point_under(stress, soil), [stage], [fractions], tolerance=1.0e-9)
    for row, one in enumerate(wanted):
        assert found.stress[row] == pytest.approx(one.stress, rel=1.0e-6)
        assert found.internal[row, 0] == pytest.approx(one.e, abs=1.0e-8)


def test_any_path_of_strain_is_that_of_the_rate_equations() -> None:
    random = np.random.default_rng(3)
    soil = clay(OCR=2.0)
    stress = np.array([60.0, 100.0, 55.0, 8.0, -5.0, 3.0])
    state = placed(soil, stress)
    for size in (1.0e-4, 1.0e-3, 5.0e-3):
        strain = size * random.standard_normal(6)
        new, after = stepped(soil, stress, state, strain)
        (wanted,) = strained(
            clay_rates(DORTMUND), DORTMUND, State(stress, state[0], np.zeros(6)), strain, np.array([1.0])
        )
        assert new == pytest.approx(wanted.stress, abs=1.0e-6 * 100.0)
        assert after[0] == pytest.approx(wanted.e, rel=1.0e-12)
