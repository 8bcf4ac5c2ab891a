"""Hypoplasticity of sand against closed forms, properties that its papers prove, and an independent integration."""

from __future__ import annotations

import math
from collections.abc import Mapping

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.element_test.boundary_conditions import Stage
from geoswarm.solver.element_test.material_point import History, follow, point_under
from geoswarm.solver.element_test.setups import drained_triaxial, simple_shear, undrained_triaxial
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.exact.hypoplastic_rates import State, matrix, sand_rates, strained, triaxial, vector
from geoswarm.verification.exact.hypoplasticity import HOCHSTETTEN, TOYOURA
from geoswarm.verification.exact.hypoplasticity import bauer as limiting

SMALL_STRAINS = {"R": 1.0e-4, "m_R": 5.0, "m_T": 2.0, "beta_r": 0.5, "chi": 6.0}
"""Niemunis & Herle (1997)."""

ALL_ROUND = np.array([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
SINE = math.sin(math.radians(TOYOURA["phi_c"]))
A = math.sqrt(3.0) * (3.0 - SINE) / (2.0 * math.sqrt(2.0) * SINE)


def sand(**changes: float) -> Soil:
    """Toyoura sand with other values."""
    return find_law("hypoplastic_sand").soil({**TOYOURA, **changes})


def bauer(e0: float, p: FloatArray | float) -> FloatArray:
    """Bauer (1996): a limiting void ratio at mean stresses p, kPa."""
    return limiting(e0, p, TOYOURA["h_s"], TOYOURA["n"])


def stepped(soil: Soil, stress: FloatArray, state: FloatArray, strain: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Stress and state after a straight path of strain."""
    new, new_state, _, status = soil.law.update(strain, -math.inf, stress, state, soil.constants)
    assert status >= 0
    return new, new_state


def led(soil: Soil, stress: FloatArray, stage: Stage, times: list[float], tolerance: float = 1.0e-8) -> History:
    """A stage of the general driver."""
    return follow(soil, point_under(stress, soil), [stage], [times], tolerance=tolerance)


def loosest(p: float) -> Soil:
    """A soil at its largest void ratio under an all-round stress."""
    return sand(e0=float(bauer(TOYOURA["e_i0"], p)))


@pytest.mark.parametrize("target", [60.0, 400.0, 2.0e4])
def test_the_loosest_soil_compresses_by_bauers_law(target: float) -> None:
    soil, p = loosest(50.0), 50.0
    volume = math.log((1.0 + float(bauer(TOYOURA["e_i0"], p))) / (1.0 + float(bauer(TOYOURA["e_i0"], target))))
    stress = p * ALL_ROUND
    new, state = stepped(soil, stress, soil.law.initial_state(stress, soil.constants), volume / 3.0 * ALL_ROUND)
    assert new == pytest.approx(target * ALL_ROUND, rel=1.0e-7, abs=1.0e-7)
    assert state[0] == pytest.approx(float(bauer(TOYOURA["e_i0"], target)), rel=1.0e-12)


@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("e0", [0.65, 0.9])
def test_isotropic_paths_follow_their_scalar_equation(e0: float, way: float) -> None:
    """dp = f_s/3 (3 + a^2 -+ sqrt(3) a f_d) deps_v for loading and unloading."""
    h_s, n, alpha, beta = (TOYOURA[name] for name in ("h_s", "n", "alpha", "beta"))
    ed0, ec0, ei0 = (TOYOURA[name] for name in ("e_d0", "e_c0", "e_i0"))

    def stiffness(p: float, e: float) -> float:
        ed, ec, ei = (float(bauer(one, p)) for one in (ed0, ec0, ei0))
        bracket = 3.0 + A**2 - math.sqrt(3.0) * A * ((ei0 - ed0) / (ec0 - ed0)) ** alpha
        f_s = h_s / n * (ei / e) ** beta * (1.0 + ei) / ei * (3.0 * p / h_s) ** (1.0 - n) / bracket
        f_d = ((e - ed) / (ec - ed)) ** alpha
        return f_s / 3.0 * (3.0 + A**2 - way * math.sqrt(3.0) * A * f_d)

    volume = way * 2.0e-3
    exact = solve_ivp(
        lambda x, y: [volume * stiffness(y[0], (1.0 + e0) * math.exp(-volume * x) - 1.0)],
        (0.0, 1.0),
        [200.0],
        rtol=1.0e-12,
        atol=1.0e-12,
    ).y[0, -1]
    soil, stress = sand(e0=e0), 200.0 * ALL_ROUND
    new, _ = stepped(soil, stress, soil.law.initial_state(stress, soil.constants), volume / 3.0 * ALL_ROUND)
    assert new == pytest.approx(exact * ALL_ROUND, rel=1.0e-7, abs=1.0e-8)


@pytest.mark.parametrize(("e0", "way"), [(0.7, 1.0), (0.9, 1.0), (0.8, -1.0)])
def test_large_shear_ends_in_the_critical_state(e0: float, way: float) -> None:
    """q/p = 6 sin(phi_c)/(3 -+ sin(phi_c)) in compression and extension, e = e_c(p), and no more changes."""
    history = led(sand(e0=e0), 100.0 * ALL_ROUND, drained_triaxial(way * 8.0, 100.0, 1.0), [0.9, 1.0])
    assert history.q / history.p == pytest.approx(6.0 * SINE / (3.0 - way * SINE), rel=1.0e-4)
    assert history.internal[:, 0] == pytest.approx(bauer(TOYOURA["e_c0"], history.p), rel=1.0e-4)
    assert history.internal[:, 7] == pytest.approx(TOYOURA["phi_c"], rel=1.0e-4)
    assert history.stress[1] == pytest.approx(history.stress[0], rel=1.0e-4, abs=1.0e-3)


def test_the_critical_state_is_one_of_no_change() -> None:
    """In the state itself the rates vanish exactly, in compression, extension and between (Matsuoka and Nakai)."""
    soil = sand()
    for lode in (0.0, 20.0, 40.0, 60.0):
        stress = critical_stress(math.radians(lode), 100.0)
        state = soil.law.initial_state(stress, soil.constants)
        state[0] = float(bauer(TOYOURA["e_c0"], 100.0))
        L, N = sand_rates(TOYOURA)(matrix(stress), float(state[0]))
        flow = -np.linalg.lstsq(L.reshape(9, 9), N.reshape(9), rcond=None)[0].reshape(3, 3)
        assert np.linalg.norm(flow) == pytest.approx(1.0, rel=1.0e-9)
        direction = vector(flow, 2.0)
        assert direction[:3].sum() == pytest.approx(0.0, abs=1.0e-12)
        new, after = stepped(soil, stress, state, 1.0e-3 * direction)
        assert new == pytest.approx(stress, rel=1.0e-9)
        assert after[0] == pytest.approx(state[0], rel=1.0e-12)
        assert after[7] == pytest.approx(TOYOURA["phi_c"], rel=1.0e-9)


def critical_stress(lode: float, p: float) -> FloatArray:
    """Principal stresses on the cone of Matsuoka and Nakai with phi_c; lode 0: compression, 60 degree: extension."""
    ratio = 9.0 + 8.0 * SINE**2 / (1.0 - SINE**2)
    low, high = 0.0, 3.0 * p
    for _ in range(200):
        radius = 0.5 * (low + high)
        s = p + 2.0 / 3.0 * radius * np.cos(lode + np.array([0.0, -2.0, 2.0]) * math.pi / 3.0)
        first, second, third = s.sum(), s[0] * s[1] + s[1] * s[2] + s[2] * s[0], s.prod()
        beyond = s.min() <= 0.0 or first * second > ratio * third
        low, high = (low, radius) if beyond else (radius, high)
    return np.array([*s, 0.0, 0.0, 0.0])


def test_simple_shear_ends_on_the_cone_of_matsuoka_and_nakai() -> None:
    history = led(sand(), np.array([50.0, 50.0, 100.0, 0.0, 0.0, 0.0]), simple_shear(20.0, 100.0, 1.0), [1.0], 1.0e-7)
    assert history.internal[-1, 7] == pytest.approx(TOYOURA["phi_c"], rel=1.0e-4)
    assert history.internal[-1, 0] == pytest.approx(float(bauer(TOYOURA["e_c0"], history.p[-1])), rel=1.0e-4)


@pytest.mark.parametrize("e0", [0.66, 0.75])
def test_the_peak_is_where_its_density_puts_it(e0: float) -> None:
    """At the peak of a drained compression the stress stands still while volume grows: |N^-1 L D| = |D|.

    With K = sigma_1/sigma_3 this gives f_d in closed form (Herle & Gudehus 1999, their equation for alpha).
    """
    times = np.linspace(0.02, 1.0, 981)
    history = led(sand(e0=e0), 100.0 * ALL_ROUND, drained_triaxial(0.12, 100.0, 1.0), times.tolist(), 1.0e-8)
    top = int(np.argmax(history.stress[:, 2]))
    assert 0 < top < times.size - 1
    K, e, p = history.stress[top, 2] / 100.0, history.internal[top, 0], history.p[top]
    part = A**2 / (2.0 + K) ** 2 * (1.0 - K * (4.0 - K) / (5.0 * K - 2.0))
    slope = 2.0 * (K - 4.0 + 5.0 * part * K**2 - 2.0 * part * K) / ((5.0 * K - 2.0) * (1.0 + 2.0 * part)) - 1.0
    f_d = (
        6.0
        * ((2.0 + K) ** 2 + A**2 * K * (K - 1.0 - slope))
        / (A * (2.0 + K) * (5.0 * K - 2.0) * math.sqrt(4.0 + 2.0 * (1.0 + slope) ** 2))
    )
    density = (e - bauer(TOYOURA["e_d0"], p)) / (bauer(TOYOURA["e_c0"], p) - bauer(TOYOURA["e_d0"], p))
    assert density ** TOYOURA["alpha"] == pytest.approx(f_d, rel=1.0e-3)
    assert math.degrees(math.asin((K - 1.0) / (K + 1.0))) > TOYOURA["phi_c"] + 2.0


@pytest.mark.parametrize(
    "direction",
    [[0.0, 0.0, 1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 1.0, 0.0, 0.0, 0.0], [-0.2, 0.3, 1.0, 0.4, 0.0, 0.0]],
    ids=["oedometer", "isotropic", "general"],
)
def test_straight_paths_of_strain_forget_where_they_began(direction: list[float]) -> None:
    """Proportional compression leads to proportional stress (Goldscheider), whatever the first stress was."""
    soil, ends = sand(), []
    for start in ([50.0, 50.0, 100.0], [100.0, 100.0, 60.0], [80.0, 80.0, 80.0]):
        stress = np.array([*start, 0.0, 0.0, 0.0])
        state = soil.law.initial_state(stress, soil.constants)
        state[0] = 0.95
        for _ in range(80):
            stress, state = stepped(soil, stress, state, 4.0e-3 * np.array(direction) / sum(direction[:3]))
        ends.append(stress / stress[:3].sum())
    assert ends[1] == pytest.approx(ends[0], abs=2.0e-4)
    assert ends[2] == pytest.approx(ends[0], abs=2.0e-4)


CYCLES = (2.0e-3, -3.0e-3, 3.0e-3)


@pytest.mark.parametrize("drained", [True, False])
@pytest.mark.parametrize("extra", [{}, SMALL_STRAINS], ids=["plain", "small strains"])
def test_triaxial_cycles_are_those_of_the_rate_equations(extra: Mapping[str, float], drained: bool) -> None:
    given = {**TOYOURA, **extra}
    largest = 0.5 * SMALL_STRAINS["R"] if extra else math.inf
    state, wanted = State(100.0 * ALL_ROUND, TOYOURA["e0"], np.zeros(6)), []
    for axial in CYCLES:
        wanted += triaxial(sand_rates(given), given, state, axial, np.array([0.3, 1.0]), drained, largest / abs(axial))
        state = wanted[-1]
    stages = [drained_triaxial(one, 100.0, 1.0) if drained else undrained_triaxial(one, 1.0) for one in CYCLES]
    soil = sand(**extra)
    found = follow(soil, point_under(100.0 * ALL_ROUND, soil), stages, [[0.3, 1.0]] * len(CYCLES), tolerance=1.0e-9)
    for row, one in enumerate(wanted):
        assert found.stress[row] == pytest.approx(one.stress, abs=1.0e-6 * np.abs(one.stress).max())
        assert found.internal[row, 0] == pytest.approx(one.e, abs=1.0e-8)
        assert found.internal[row, 1:7] == pytest.approx(one.h, abs=1.0e-6 * SMALL_STRAINS["R"])


@pytest.mark.parametrize("drained", [True, False])
def test_monotonic_triaxial_tests_are_those_of_the_rate_equations(drained: bool) -> None:
    fractions = np.array([0.001, 0.01, 0.1, 0.5, 1.0])
    start = State(100.0 * ALL_ROUND, TOYOURA["e0"], np.zeros(6))
    wanted = triaxial(sand_rates(TOYOURA), TOYOURA, start, 0.2, fractions, drained)
    stage = drained_triaxial(0.2, 100.0, 1.0) if drained else undrained_triaxial(0.2, 1.0)
    found = led(sand(), 100.0 * ALL_ROUND, stage, fractions.tolist(), 1.0e-9)
    for row, one in enumerate(wanted):
        assert found.stress[row] == pytest.approx(one.stress, rel=1.0e-6)
        assert found.internal[row, 0] == pytest.approx(one.e, abs=1.0e-8)


@pytest.mark.parametrize("beta_r", [0.1, 0.5, 2.0])
@pytest.mark.parametrize("chi", [0.9, 6.0])
def test_any_path_of_strain_is_that_of_the_rate_equations(beta_r: float, chi: float) -> None:
    given = {**TOYOURA, **SMALL_STRAINS, "beta_r": beta_r, "chi": chi}
    soil, random = sand(**SMALL_STRAINS | {"beta_r": beta_r, "chi": chi}), np.random.default_rng(3)
    stress = np.array([60.0, 100.0, 55.0, 8.0, -5.0, 3.0])
    h = random.standard_normal(6)
    h *= 0.7 * SMALL_STRAINS["R"] / math.sqrt(float((h[:3] ** 2).sum() + 0.5 * (h[3:] ** 2).sum()))
    for size in (2.0e-5, 3.0e-4, -3.0e-4):
        strain = size * random.standard_normal(6) if size > 0.0 else -3.0 * h
        state = np.array([TOYOURA["e0"], *h, 0.0])
        new, after = stepped(soil, stress, state, strain)
        (wanted,) = strained(
            sand_rates(given), given, State(stress, TOYOURA["e0"], h), strain, np.array([1.0]), largest=0.02
        )
        assert new == pytest.approx(wanted.stress, abs=1.0e-6 * 100.0)
        assert after[0] == pytest.approx(wanted.e, rel=1.0e-12)
        assert after[1:7] == pytest.approx(wanted.h, abs=2.0e-7 * SMALL_STRAINS["R"])


def test_stiffness_after_turns_of_strain() -> None:
    """m_R on a reversal, m_T on a turn by 90 degree, both of the linear part; L:D + N |D| when going on."""
    soil, e = sand(**SMALL_STRAINS), TOYOURA["e0"]
    along = np.array([-0.4, -0.4, 1.0, 0.0, 0.0, 0.0])
    across = np.array([0.5, -0.5, 0.0, 0.0, 0.0, 0.0])  # along:across = 0
    stress, state = 100.0 * ALL_ROUND, soil.law.initial_state(100.0 * ALL_ROUND, soil.constants)
    stress, state = stepped(soil, stress, state, 5.0e-3 * along)
    assert math.sqrt(float((state[1:4] ** 2).sum())) == pytest.approx(SMALL_STRAINS["R"], rel=1.0e-8)
    e = float(state[0])
    L, N = sand_rates(TOYOURA)(matrix(stress), e)
    tiny = 1.0e-4 * SMALL_STRAINS["R"]
    for strain, factor, nonlinear in ((-along, 5.0, 0.0), (across, 2.0, 0.0), (along, 1.0, 1.0)):
        D = matrix(tiny * strain, 0.5)
        wanted = vector(factor * np.einsum("ijkl,kl->ij", L, D) + nonlinear * N * np.linalg.norm(D))
        new, _ = stepped(soil, stress, state, tiny * strain)
        assert new - stress == pytest.approx(wanted, abs=2.0e-3 * np.abs(wanted).max())
    fresh = soil.law.initial_state(stress, soil.constants)
    fresh[0] = e
    new, _ = stepped(soil, stress, fresh, tiny * along)
    wanted = vector(5.0 * np.einsum("ijkl,kl->ij", L, matrix(tiny * along, 0.5)))
    assert new - stress == pytest.approx(wanted, rel=1.0e-3)


def test_long_strain_swept_out_the_memory_of_turns() -> None:
    """Far beyond R the stress rate is that without intergranular strain."""
    soil, plain = sand(**SMALL_STRAINS), sand()
    stress = 100.0 * ALL_ROUND
    stress, state = stepped(
        soil, stress, soil.law.initial_state(stress, soil.constants), np.array([-3e-3, -3e-3, 1e-2, 0.0, 0.0, 0.0])
    )
    step = np.array([-3.0e-5, -3.0e-5, 1.0e-4, 0.0, 0.0, 0.0])
    with_h = stepped(soil, stress, state, step)[0]
    without = stepped(plain, stress, state, step)[0]
    assert with_h - stress == pytest.approx(without - stress, rel=1.0e-6)


def test_the_shift_of_stress_is_one() -> None:
    shift = np.array([5.0, 5.0, 5.0, 0.0, 0.0, 0.0])
    stress = np.array([30.0, 50.0, 20.0, 4.0, 0.0, 2.0])
    step = np.array([-1.0e-3, 2.0e-3, 3.0e-4, 1.0e-3, 0.0, 5.0e-4])
    shifted, plain = sand(p_t=5.0), sand()
    state = plain.law.initial_state(stress + shift, plain.constants)
    assert shifted.law.initial_state(stress, shifted.constants) == pytest.approx(state, rel=1.0e-14)
    here, there = stepped(shifted, stress, state, step), stepped(plain, stress + shift, state, step)
    assert here[0] + shift == pytest.approx(there[0], rel=1.0e-12)
    assert here[1] == pytest.approx(there[1], rel=1.0e-12)


def test_a_void_ratio_at_zero_stress_follows_bauers_law() -> None:
    soil = sand(e0=0.0, e00=0.8)
    stress = np.array([[10.0, 20.0, 10.0, 0.0], [100.0, 200.0, 100.0, 0.0]])
    found = soil.law.initial_state(stress, soil.constants)[:, 0]
    assert found == pytest.approx(bauer(0.8, stress[:, :3].mean(axis=1)), rel=1.0e-12)


PUBLISHED = {
    "stress at 0.5 %, kPa": (294.3, 0.05),
    "modulus of the last step of 0.01 %, kPa": (29080.0, 5.0),
    "modulus of the first step back, kPa": (316559.0, 30.0),
}
"""Number, and half of its last digit (moduli: what the routine's tolerance of 1e-3 may change).

Oedometer test on Hochstetten sand from 100 kPa all round, without intergranular strain, calculated with the user
routine of Tamagnini, Sellari, Masin and von Wolffersdorff (soilmodels.com) in OpenSees: documentation of OpenSees,
nDMaterial UMAT, "Worked Example: Hochstetten Sand", expected results, with parameters of Herle & Gudehus (1999) and
Niemunis & Herle (1997).
"""


@pytest.mark.parametrize("pieces", [1, 50])
def test_the_published_oedometer_test_of_the_authors_routine(pieces: int) -> None:
    soil = find_law("hypoplastic_sand").soil(HOCHSTETTEN)
    down = np.array([0.0, 1.0e-4, 0.0, 0.0, 0.0, 0.0])
    stress, state = 100.0 * ALL_ROUND, soil.law.initial_state(100.0 * ALL_ROUND, soil.constants)
    for _ in range(pieces):
        stress, state = stepped(soil, stress, state, 49.0 / pieces * down)
    before, state = stepped(soil, stress, state, np.zeros(6))
    stress, state = stepped(soil, before, state, down)
    back, _ = stepped(soil, stress, state, -down)
    found = (stress[1], (stress[1] - before[1]) / 1.0e-4, (stress[1] - back[1]) / 1.0e-4)
    for value, (number, accuracy) in zip(found, PUBLISHED.values(), strict=True):
        assert value == pytest.approx(number, abs=accuracy)
