"""Hardening soil with small-strain stiffness against closed forms, hardening soil and its integrated rate equations.

Benz (2007); Gs/G0 = 1/(1 + a gamma/gamma_07), a = 0.385 (Santos & Correia 2001); Masing's loop of that hyperbola.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.tensors import rotation_matrix
from geoswarm.solver.element_test.material_point import History, PointState, follow, point_under
from geoswarm.solver.element_test.setups import (
    constant_rate_oedometer,
    drained_triaxial,
    isotropic_load,
    undrained_triaxial,
)
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.registry import find_spec
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.registry import find_law
from geoswarm.verification.exact.hardening_soil import DECAY, masing_damping
from geoswarm.verification.exact.hardening_soil import backbone as hardin_drnevich
from geoswarm.verification.specimens.laboratory import consolidation, crs_oedometer, run, simple_shear, triaxial

E50, EUR, NU, PREF, RF = 2.5e4, 8.0e4, 0.2, 100.0, 0.9
G0, THRESHOLD = 2.0e5, 2.0e-4
INITIAL, GUR = 2.0 * E50 / (2.0 - RF), EUR / 2.4
SAND: dict[str, Any] = {"E50_ref": E50, "Eoed_ref": 2.2e4, "Eur_ref": EUR, "m": 0.5, "c": 0.0, "phi": 34.0}
CUT = THRESHOLD / DECAY * (math.sqrt(G0 / GUR) - 1.0)
HELD = 1.0
"""gamma of a specimen that has been sheared close to its strength: small shear is elastic."""


def sand(**changes: Any) -> Soil:
    """Medium dense sand with a cap far away."""
    given = {**SAND, "G0_ref": G0, "gamma_07": THRESHOLD, "OCR": 50.0, **changes}
    return find_law("hardening_soil_small").soil(given)


def plain(**changes: Any) -> Soil:
    """The same without small-strain stiffness."""
    return find_law("hardening_soil").soil({**SAND, "OCR": 50.0, **changes})


def placed(p: float, soil: Soil, held: float = 0.0) -> PointState:
    """Under all-round pressure; ``held``: the plastic shear strain of its past."""
    point = point_under([p, p, p, 0.0, 0.0, 0.0], soil)
    point.internal[0] = held
    return point


def sheared(soil: Soil, point: PointState, steps: list[FloatArray]) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Stresses, states and the last tangent of strain increments."""
    stress, state, tangent = point.stress, point.internal, np.empty((6, 6))
    stresses, states = [stress], [state]
    for step in steps:
        stress, state, tangent, status = soil.law.update(step, -math.inf, stress, state, soil.constants)
        assert status >= 0
        stresses.append(stress)
        states.append(state)
    return np.array(stresses), np.array(states), tangent


def in_steps(shear: float, count: int) -> list[FloatArray]:
    """Simple shear by an engineering strain."""
    return [np.array([0.0, 0.0, 0.0, shear / count, 0.0, 0.0])] * count


def backbone(gamma: FloatArray | float) -> FloatArray:
    """Shear stress of first loading up to the cut-off at p_ref, over 3/2 eps_q."""
    return hardin_drnevich(gamma, G0, THRESHOLD)


@pytest.mark.parametrize(
    ("m", "cell", "drained"),
    [(0.0, 100.0, True), (0.5, 50.0, True), (0.5, 100.0, True), (1.0, 300.0, True), (0.0, 100.0, False)],
)
def test_the_triaxial_test_has_the_reduction_curve_of_hardin_and_drnevich(m: float, cell: float, drained: bool) -> None:
    """At constant cell pressure G0 stays; undrained it does where m is 0."""
    soil = sand(m=m, c=20.0 if m == 0.0 else 0.0)
    a = 20.0 / math.tan(math.radians(34.0)) if m == 0.0 else 0.0
    stiff = G0 * ((cell + a) / (PREF + a)) ** m
    axial = 4.0e-4
    stage = drained_triaxial(axial, cell, 1.0) if drained else undrained_triaxial(axial, 1.0)
    times = np.geomspace(1.0e-3, 1.0, 30)
    history = follow(soil, placed(cell, soil, HELD), [stage], [times], tolerance=1.0e-9)
    gamma = history.strain[:, 2] - history.strain[:, 0]
    assert gamma[-1] < CUT
    # The tolerance is one of strain: times the modulus it is one of stress.
    q = 2.0 * stiff * gamma / (1.0 + DECAY * gamma / THRESHOLD)
    assert history.q == pytest.approx(q, rel=1.0e-6, abs=1.0e-8 * stiff)
    assert history.internal[:, 8] == pytest.approx(gamma, rel=1.0e-9)


def test_at_the_threshold_the_secant_is_0_722_of_G0() -> None:
    lateral = -0.5 * THRESHOLD / 1.5
    one = np.array([lateral, -2.0 * lateral, lateral, 0.0, 0.0, 0.0])  # e1 - e3 is the threshold
    soil = sand(m=0.0)
    stress, states, _ = sheared(soil, placed(100.0, soil, HELD), [one])
    assert 0.5 * (stress[-1, 1] - stress[-1, 0]) / THRESHOLD == pytest.approx(0.722 * G0, rel=5.0e-4)
    assert states[-1, 8] == pytest.approx(THRESHOLD, rel=1.0e-12)


@pytest.mark.parametrize("count", [1, 7])
def test_simple_shear_has_it_over_its_own_measure(count: int) -> None:
    """3/2 eps_q is sqrt(3)/2 of the engineering shear strain; any number of steps gives the same."""
    soil, shear = sand(m=0.0), 3.0e-4
    stress, _, tangent = sheared(soil, placed(100.0, soil, HELD), in_steps(shear, count))
    measure = 0.5 * math.sqrt(3.0) * shear
    assert stress[-1, 3] == pytest.approx(G0 * shear / (1.0 + DECAY * measure / THRESHOLD), rel=1.0e-12)
    if count == 1:
        assert tangent[3, 3] == pytest.approx(G0 / (1.0 + DECAY * measure / THRESHOLD) ** 2, rel=1.0e-9)


def test_beyond_the_cut_off_increments_are_those_of_hardening_soil() -> None:
    """gamma_c = gamma_07/0.385 (sqrt(G0/Gur) - 1): there the tangent is Gur."""
    soil = sand(m=0.0, c=60.0)
    to = 2.0 / math.sqrt(3.0) * CUT
    stress, states, _ = sheared(soil, placed(100.0, soil, HELD), [*in_steps(to, 50), *in_steps(0.5 * to, 3)])
    top = float(backbone(CUT)) * 2.0 / math.sqrt(3.0)
    assert stress[[50, -1], 3] == pytest.approx([top, top + 0.5 * GUR * to], rel=1.0e-9)
    assert states[-1, 10] == 1.0
    more, step = sand(), np.array([-3.0e-4, 9.0e-4, -2.0e-4, 1.0e-4, 0.0, 3.0e-4])
    for held in (0.0, HELD):
        stress, states, _ = sheared(more, placed(100.0, more, held), [step] * 10)
        assert states[-1, 10] == 1.0
        for way in (step, 2.0 * step):
            small = more.law.update(way, -math.inf, stress[-1], states[-1], more.constants)
            one = plain().law.update(way, -math.inf, stress[-1], states[-1, :2], plain().constants)
            assert small[0] == pytest.approx(one[0], rel=1.0e-12)
            assert small[1][:2] == pytest.approx(one[1], rel=1.0e-12)
            assert small[2] == pytest.approx(one[2], rel=1.0e-9, abs=1.0e-4)


@pytest.mark.parametrize("amplitude", [3.0e-5, 1.0e-4, 4.0e-4])
def test_a_loop_is_that_of_masing(amplitude: float) -> None:
    """Stiffness G0 after the turn, twice the first curve, closed; damping as integrated from it."""
    soil, shear, count = sand(m=0.0), 2.0 / math.sqrt(3.0) * amplitude, 2000
    first = in_steps(shear, count)
    loop = [*in_steps(-2.0 * shear, 2 * count), *in_steps(2.0 * shear, 2 * count)]
    stress, states, _ = sheared(soil, placed(100.0, soil, HELD), [*first, *loop])
    tau = stress[:, 3]
    top = float(backbone(amplitude)) * 2.0 / math.sqrt(3.0)
    assert tau[count] == pytest.approx(top, rel=1.0e-9)
    assert tau[3 * count] == pytest.approx(-top, rel=1.0e-9)
    assert tau[-1] == pytest.approx(top, rel=1.0e-9)
    assert states[-1, 9] == pytest.approx(amplitude, rel=1.0e-9)
    turned = -shear / count
    decay = DECAY * 0.25 * math.sqrt(3.0) * shear / count / THRESHOLD
    assert (tau[count + 1] - tau[count]) / turned == pytest.approx(G0 / (1.0 + decay), rel=1.0e-6)
    gamma = np.concatenate([[0.0], np.cumsum([step[3] for step in (*first, *loop)])])
    around = slice(count, None)
    area = float(np.trapezoid(tau[around], gamma[around]))
    damping = float(masing_damping(amplitude, THRESHOLD))
    assert area / (2.0 * math.pi * top * shear) == pytest.approx(damping, rel=1.0e-4)


def test_beyond_the_largest_strain_it_goes_on_along_the_first_curve() -> None:
    soil, to = sand(m=0.0), 2.0 / math.sqrt(3.0)
    ways = [1.0e-4, -2.0e-4, 4.0e-4]  # ends at 3e-4
    steps = [step for way in ways for step in in_steps(to * way, 40)]
    stress = sheared(soil, placed(100.0, soil, HELD), steps)[0]
    assert stress[-1, 3] == pytest.approx(to * float(backbone(3.0e-4)), rel=1.0e-9)
    twice = sand(m=0.0, doubled_threshold="always")
    stress = sheared(twice, placed(100.0, twice, HELD), steps[:40])[0]
    assert stress[-1, 3] == pytest.approx(to * 2.0 * float(backbone(0.5e-4)), rel=1.0e-9)


def test_a_turn_about_the_right_angle_keeps_a_part_of_the_history() -> None:
    """Compression, then shear at 45 degrees to it: |H de|/|de| is that of what did not turn back."""
    soil = sand(m=0.0)
    compression = np.array([-0.5e-4, 1.0e-4, -0.5e-4, 0.0, 0.0, 0.0])
    states = sheared(soil, placed(100.0, soil, HELD), [compression, *in_steps(1.0e-9, 1)])[1]
    # On the axes of shearing in the plane xy H has 0.25e-4 twice and 0.75e-4 off the diagonal; one of the two turns.
    left = math.sqrt(3.0) * math.sqrt((0.25**2 + 2.0 * 0.75**2) / 2.0) * 1.0e-4
    assert states[-1, 8] == pytest.approx(left, rel=1.0e-4)


def test_rounding_is_no_turn() -> None:
    """All-round compression whose deviator is rounding, of any sign, before shearing."""
    soil = sand()
    noise = np.random.default_rng(3).normal(size=(30, 6)) * 1.0e-20
    steps = [np.array([1.0e-5, 1.0e-5, 1.0e-5, 0.0, 0.0, 0.0]) + one for one in noise]
    clean = [np.array([1.0e-5, 1.0e-5, 1.0e-5, 0.0, 0.0, 0.0])] * 30
    after = in_steps(2.0e-4, 5)
    dirty = [one + 1.0e-19 * noise[i % 30] for i, one in enumerate(after)]
    first = sheared(soil, placed(100.0, soil, HELD), [*clean, *after])
    other = sheared(soil, placed(100.0, soil, HELD), [*steps, *dirty])
    assert other[0][-1] == pytest.approx(first[0][-1], rel=1.0e-9, abs=1.0e-9)
    assert other[1][-1, 8:] == pytest.approx(first[1][-1, 8:], rel=1.0e-9)


@pytest.mark.parametrize("doubled", ["reversal", "always"])
def test_with_G0_of_unloading_it_is_hardening_soil(doubled: str) -> None:
    same = {"G0_ref": GUR * (1.0 + 1.0e-14), "doubled_threshold": doubled, "OCR": 1.0}
    for stages in (
        [drained_triaxial(0.03, 100.0, 1.0), drained_triaxial(-0.002, 100.0, 1.0)],
        [undrained_triaxial(0.01, 1.0)],
        [constant_rate_oedometer(0.02, 1.0)],
        [isotropic_load(300.0, 1.0)],
    ):
        found: list[History] = [
            follow(soil, placed(100.0, soil), stages, [[0.3, 1.0]] * len(stages), tolerance=1.0e-8)
            for soil in (sand(**same), plain(OCR=1.0))
        ]
        assert found[0].stress == pytest.approx(found[1].stress, rel=1.0e-6)
        assert found[0].strain == pytest.approx(found[1].strain, rel=1.0e-6, abs=1.0e-9)


class FirstLoading:
    """Drained compression from an isotropic stress, as rate equations: y = q, e3, gamma over the axial strain."""

    def __init__(self, doubled: bool) -> None:
        sine = math.sin(math.radians(34.0))
        self.strength = 2.0 * sine / (1.0 - sine) * 100.0
        self.scale = 0.5 if doubled else 1.0

    def __call__(self, axial: float, y: FloatArray) -> list[float]:
        """Rates, no dilatancy."""
        g = self.scale * (axial - float(y[1]))
        k = max(G0 / GUR / (1.0 + DECAY * g / THRESHOLD) ** 2, 1.0)
        h = k ** (1.0 + EUR / (2.0 * INITIAL))
        slope = 2.0 / (INITIAL * (1.0 - float(y[0]) * RF / self.strength) ** 2) - 2.0 / EUR
        rate = 1.0 / (1.0 / (k * EUR) + 0.5 * slope / h)
        return [rate, -NU * rate / (k * EUR) - 0.25 * slope / h * rate, slope * rate]


@pytest.mark.parametrize("doubled", [False, True])
def test_first_loading_is_the_integrated_rates(doubled: bool) -> None:
    soil = sand(doubled_threshold="always" if doubled else "reversal")
    strain, times = 0.004, np.array([0.01, 0.03, 0.1, 0.3, 1.0])
    history = follow(soil, placed(100.0, soil), [drained_triaxial(strain, 100.0, 1.0)], [times], tolerance=1.0e-8)
    start = [0.0, 0.0, 0.0]
    result = solve_ivp(FirstLoading(doubled), (0.0, strain), start, "Radau", times * strain, rtol=1e-10, atol=1e-13)
    q, radial, gamma = result.y
    assert history.q == pytest.approx(q, rel=2.0e-4)
    assert history.strain[:, 0] == pytest.approx(radial, rel=5.0e-4)
    assert history.internal[:, 0] == pytest.approx(gamma, rel=5.0e-4)


def test_after_small_strains_first_loading_is_that_of_hardening_soil_to_the_strength() -> None:
    """E50 of the drained test: the curves differ by the strain that stiffness saved at the beginning, no more."""
    cell, sine = 100.0, math.sin(math.radians(34.0))
    strength = 2.0 * sine / (1.0 - sine) * cell
    strains = []
    for soil in (sand(G0_ref=9.0e4, gamma_07=1.5e-4), plain()):
        history = follow(
            soil, placed(cell, soil), [drained_triaxial(0.2, cell, 1.0)], [np.linspace(0.005, 1.0, 400)], tolerance=1e-8
        )
        assert history.q[-1] == pytest.approx(strength, rel=1.0e-9)
        q = np.array([0.5, 0.6, 0.7])
        strains.append(np.interp(q, history.q / strength, history.strain[:, 2]))
    apart = strains[1] - strains[0]
    assert apart == pytest.approx(apart[0], rel=0.02)
    assert 0.0 < apart[0] < 0.1 * strains[1][0]
    modulus = 0.5 * strength / strains[0][0]
    assert E50 < modulus < 1.1 * E50


WAYS = {
    "on": np.array([-4.0e-5, 9.0e-5, -3.0e-5, 8.0e-5, 5.0e-5, -2.0e-5]),
    "back": np.array([5.0e-5, -8.0e-5, 2.0e-5, -7.0e-5, -6.0e-5, 3.0e-5]),
    "aside": np.array([9.0e-5, -2.0e-5, -5.0e-5, 2.0e-5, -8.0e-5, 6.0e-5]),
}
PAST = [
    np.array([-3.0e-5, 1.0e-4, -5.0e-5, 9.0e-5, 2.0e-5, -4.0e-5]),
    np.array([3.0e-5, 2.0e-5, -6.0e-5, 0.0, 7e-5, 0.0]),
]


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("held", [0.0, HELD])
def test_with_a_history_the_tangent_leaves_a_rest_of_second_order(way: str, held: float) -> None:
    """Onwards, back and aside of a past that turned; with an active surface and without."""
    soil, strain = sand(c=10.0), WAYS[way]
    stresses, states, _ = sheared(soil, placed(100.0, soil, held), PAST)
    now = (stresses[-1], states[-1], soil.constants)
    here = soil.law.update(strain, -math.inf, *now)
    for other in np.random.default_rng(2).uniform(-1.0, 1.0, (5, 6)):
        rests = []
        for length in (4.0e-7, 2.0e-7, 1.0e-7):
            there = soil.law.update(strain + length * other, -math.inf, *now)
            rests.append(float(np.abs(there[0] - here[0] - length * here[2] @ other).max()))
        assert rests[0] > 3.3 * rests[1] > 3.3**2 * rests[2]


@pytest.mark.parametrize("way", WAYS)
def test_with_a_history_the_answer_turns_with_the_axes(way: str) -> None:
    soil, point = sand(c=10.0), placed(100.0, sand(c=10.0))
    path = [*PAST, WAYS[way]]
    for axes in Rotation.random(4, rng=np.random.default_rng(4)).as_matrix():
        Q = rotation_matrix(axes)
        back = np.linalg.inv(Q).T
        here, there = sheared(soil, point, path), sheared(soil, point, [back @ one for one in path])
        assert there[0][-1] == pytest.approx(Q @ here[0][-1], rel=1.0e-9, abs=1.0e-9)
        assert there[1][-1, 2:8] == pytest.approx(back @ here[1][-1, 2:8], rel=1.0e-9, abs=1.0e-15)
        assert there[1][-1, 8:] == pytest.approx(here[1][-1, 8:], rel=1.0e-9)
        assert there[2] == pytest.approx(Q @ here[2] @ Q.T, rel=1.0e-5, abs=1.0e-5 * G0)


GIVEN = {**SAND, "m": 0.0, "G0_ref": G0, "gamma_07": THRESHOLD}


def test_small_cycles_of_a_triaxial_test_have_the_damping_of_masing() -> None:
    """First loading yields; after some cycles all is within what has been, and the loop is that of the closed form."""
    amplitude, cycles = 6.0e-5, 12
    stage = {"kind": "cyclic", "axial_strain_amplitude": amplitude, "cycles": cycles, "period": 1.0}
    spec = triaxial("hardening_soil_small", [stage], drainage="undrained", tolerance=1.0e-8)
    x = np.linspace(cycles - 1.0, cycles, 4001)
    axial, q, measure = run(spec, GIVEN | {"OCR": 50.0}, x, "time_axial_strain", "time_q", "time_gamma_hist")
    gamma = 1.5 * axial
    half = 0.5 * np.ptp(gamma)
    assert half == pytest.approx(1.5 * amplitude, rel=1.0e-6)
    assert measure.max() == pytest.approx(2.0 * half, rel=1.0e-3)
    assert np.ptp(q) / np.ptp(gamma) == pytest.approx(2.0 * float(backbone(half)) / half, rel=1.0e-3)
    area = abs(float(np.trapezoid(q, gamma)))
    damping = float(masing_damping(half, THRESHOLD))
    assert area / (math.pi * 0.5 * np.ptp(q) * np.ptp(gamma)) == pytest.approx(damping, rel=5.0e-3)


@pytest.mark.parametrize("kind", ["shear", "crs", "consolidation", "oedometer", "isotropic_compression"])
def test_every_laboratory_test_is_stiffer_than_without_small_strains(kind: str) -> None:
    """Over the same load less strain, or over the same strain more stress; both of one law with G0 = Gur."""
    answers = []
    for initial in (G0, GUR * (1.0 + 1.0e-12)):
        values = {**SAND, "G0_ref": initial, "gamma_07": THRESHOLD, "k": 1.0e-2}
        if kind == "shear":
            spec: Any = simple_shear("hardening_soil_small", [{"shear_strain": 2.0e-3}])
            answers.append(run(spec, values, [2.0e-4, 2.0e-3], "shear_stress")[0])
        elif kind == "crs":
            spec = crs_oedometer("hardening_soil_small", [{"axial_strain": 2.0e-3, "rate": 0.01}])
            answers.append(run(spec, values, [2.0e-4, 2.0e-3], "axial_stress")[0])
        elif kind == "consolidation":
            spec = consolidation("hardening_soil_small", [(110.0, 1.0), (150.0, 1.0)])
            answers.append(1.0 / run(spec, values, [1.0, 2.0], "stage_settlement")[0])
        else:
            section = {"kind": kind, "material": "hardening_soil_small", "initial_stress": 100.0}
            stages = [{"stress": 110.0, "duration": 1.0}, {"stress": 150.0, "duration": 1.0}]
            size = {"height": 0.02} if kind == "oedometer" else {"height": 0.1, "diameter": 0.05}
            spec = find_spec(kind).model_validate({**section, **size, "stages": stages})
            series = "stage_axial_strain" if kind == "oedometer" else "stage_volumetric_strain"
            answers.append(1.0 / run(spec, values, [1.0, 2.0], series)[0])
    assert (answers[0] > 1.001 * answers[1]).all()
    assert (answers[0] < 6.0 * answers[1]).all()


def test_a_G0_below_that_of_unloading_is_reported() -> None:
    with pytest.raises(InfeasibleError, match=r"G0_ref must be at least Eur_ref/.* = 33333.3 kPa .*, got 30000 kPa"):
        sand(G0_ref=3.0e4)
    with pytest.raises(InfeasibleError, match="gamma_07 must be above 0 and at most 1, got 0"):
        sand(gamma_07=0.0)
