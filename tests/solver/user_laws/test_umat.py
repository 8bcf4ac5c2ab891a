"""User routines of Abaqus behind the binary interface: signs, order, units, tangents, state, what they get."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.laws.libraries.umat_bridge import BESIDE
from geoswarm.solver.laws.registry import find_law
from tests.solver.user_laws.routines import DRUCKER_PRAGER, ELASTIC, MISBEHAVING, NORTON, soil

STRESS = np.array([60.0, 100.0, 55.0, 8.0, -5.0, 3.0])
SMALL = np.array([2.0e-4, 6.0e-4, -1.0e-4, 3.0e-4, 2.0e-4, -4.0e-4])
LARGE = np.array([-4.0e-3, 6.0e-3, -3.0e-3, 8.0e-3, 2.0e-3, -4.0e-3])
MODULI = {"E": 1.0e4, "nu": 0.3}
SOILS: dict[str, tuple[dict[str, Any], dict[str, float]]] = {
    "elastic": (ELASTIC, MODULI),
    "drucker_prager": (DRUCKER_PRAGER, {**MODULI, "c": 5.0, "phi": 25.0, "psi": 5.0}),
    "norton": (NORTON, {**MODULI, "A": 1.0e-8, "m": 3.0}),
}


def one(name: str, **changes: Any) -> Soil:
    """A soil of a well-behaved routine."""
    return soil(*SOILS[name], **changes)


def step(of: Soil, strain: np.ndarray, stress: np.ndarray, log_time: float = 0.0) -> tuple[Any, ...]:
    """One step from where the soil is placed."""
    return of.law.update(strain, log_time, stress, of.law.initial_state(stress, of.constants), of.constants)


@pytest.mark.parametrize("count", [4, 6])
def test_an_elastic_routine_gives_what_our_elasticity_gives(count: int) -> None:
    ours = find_law("elastic").soil(MODULI)
    for strain in (SMALL, LARGE, -LARGE):
        found = step(one("elastic"), strain[:count], STRESS[:count])
        expected = step(ours, strain[:count], STRESS[:count])
        assert found[0] == pytest.approx(expected[0], rel=1.0e-13)
        assert found[2] == pytest.approx(expected[2], rel=1.0e-13)
        assert found[3] == 0


@pytest.mark.parametrize(("order", "yz", "zx"), [(["xy", "xz", "yz"], 3.0, 2.0), (["xy", "yz", "xz"], 2.0, 3.0)])
def test_shear_components_stand_in_the_declared_order(order: list[str], yz: float, zx: float) -> None:
    # The routine's fifth component has twice, its sixth three times the shear modulus of the fourth.
    of = soil(ELASTIC, {**MODULI, "r13": 2.0, "r23": 3.0}, shear_order=order)
    strain = np.array([0.0, 0.0, 0.0, 1.0e-3, 2.0e-3, -1.0e-3])
    stress, _, tangent, _ = step(of, strain, np.zeros(6))
    G = 1.0e4 / 2.6
    assert stress[3:] == pytest.approx([1.0e-3 * G, 2.0e-3 * G * yz, -1.0e-3 * G * zx])
    assert np.diag(tangent)[3:] == pytest.approx([G, yz * G, zx * G])


def test_units_are_those_of_the_routine() -> None:
    plain = one("norton")
    # 1 kPa = 1e-3 MPa and 1 day = 86400 s: A has the unit 1/(MPa^3 s).
    values = {"E": 10.0, "nu": 0.3, "A": 1.0e-8 * 1.0e9 / 86400.0, "m": 3.0}
    other = soil(NORTON, values, stress_unit="MPa", time_unit="s")
    first, second = step(plain, SMALL, STRESS, math.log(0.5)), step(other, SMALL, STRESS, math.log(0.5))
    assert second[0] == pytest.approx(first[0], rel=1.0e-10)
    assert second[2] == pytest.approx(first[2], rel=1.0e-10)
    assert second[1][0] == pytest.approx(first[1][0], rel=1.0e-10)
    assert second[1][1] == pytest.approx(43200.0)
    assert other.law.elastic_moduli(other.constants, 50.0) == pytest.approx((1.0e4 / 1.2, 1.0e4 / 2.6), rel=1.0e-9)


@pytest.mark.parametrize("name", SOILS)
@pytest.mark.parametrize("strain", [SMALL, LARGE])
def test_four_components_give_what_six_give(name: str, strain: np.ndarray) -> None:
    of, whole = one(name), one(name, six_components=True)
    strain, stress = np.append(strain[:4], [0.0, 0.0]), np.append(STRESS[:4], [0.0, 0.0])
    general = step(of, strain, stress)
    for found in (step(of, strain[:4], stress[:4]), step(whole, strain[:4], stress[:4])):
        assert found[0] == pytest.approx(general[0][:4], rel=1.0e-12)
        assert found[1] == pytest.approx(general[1], rel=1.0e-12)
        assert found[2] == pytest.approx(general[2][:4, :4], rel=1.0e-12, abs=1.0e-9)
        assert found[3] == general[3]


@pytest.mark.parametrize("name", SOILS)
@pytest.mark.parametrize("strain", [SMALL, LARGE])
@pytest.mark.parametrize("tangent", ["routine", "differences"])
def test_the_tangent_is_of_second_order(name: str, strain: np.ndarray, tangent: str) -> None:
    of = one(name, tangent=tangent)
    stress, _, C, status = step(of, strain, STRESS)
    assert status == (1 if name == "drucker_prager" and strain is LARGE else 0)
    way = np.array([0.3, -0.5, 0.7, 0.2, -0.9, 0.4])
    left = []
    for length in (1.0e-4, 1.0e-5):
        moved = step(of, strain + length * way, STRESS)[0]
        left.append(float(np.abs(moved - stress - length * (C @ way)).max()))
    small = 1.0e-4 * 1.0e-5 * float(np.abs(C).max())  # of differences, and of rounding
    assert left[1] <= 0.011 * left[0] + small


def test_a_tangent_by_differences_is_that_of_the_routine() -> None:
    for name in SOILS:
        for strain in (SMALL, LARGE):
            exact, found = step(one(name), strain, STRESS), step(one(name, tangent="differences"), strain, STRESS)
            assert np.abs(found[2] - exact[2]).max() < 1.0e-4 * np.abs(exact[2]).max()
            for place in (0, 1):
                assert found[place] == pytest.approx(exact[place], rel=1.0e-14)


@pytest.mark.parametrize("name", ["drucker_prager", "norton"])
def test_turned_axes_give_the_turned_stress(name: str) -> None:
    of = one(name)
    angle, axis = 0.7, np.array([1.0, 2.0, -0.5]) / math.sqrt(5.25)
    cross = np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]])
    R = np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross

    def turned(components: np.ndarray, shear: float) -> np.ndarray:
        xx, yy, zz, xy, yz, zx = components * np.array([1, 1, 1, shear, shear, shear])
        T = R @ np.array([[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]) @ R.T
        return np.array([T[0, 0], T[1, 1], T[2, 2], T[0, 1] / shear, T[1, 2] / shear, T[2, 0] / shear])

    found = step(of, turned(LARGE, 0.5), turned(STRESS, 1.0))
    plain = step(of, LARGE, STRESS)
    assert found[0] == pytest.approx(turned(plain[0], 1.0), rel=1.0e-10)
    assert found[1][:-BESIDE] == pytest.approx(plain[1][:-BESIDE], rel=1.0e-10)


def test_the_routine_gets_time_strain_and_the_number_of_the_increment() -> None:
    of = one("norton")
    state = of.law.initial_state(STRESS, of.constants)
    for number in (1, 2, 3):
        _, state, _, status = of.law.update(SMALL, math.log(0.25), STRESS, state, of.constants)
        assert status == 0
        assert state[1] == pytest.approx(0.25 * number)
        assert state[2:] == pytest.approx([*(number * SMALL), 0.25 * number, number])
    names = [variable.name for variable in of.law.state]
    assert names[2:] == [f"strain_{one}" for one in ("xx", "yy", "zz", "xy", "yz", "zx")] + ["total_time", "increments"]


def test_a_time_of_nothing_becomes_the_least_time() -> None:
    of = one("norton", least_time=1.0e-6)
    assert step(of, SMALL, STRESS, -math.inf)[1][1] == pytest.approx(1.0e-6)
    assert step(of, SMALL, STRESS, -9000.0)[1][1] == pytest.approx(1.0e-6)


def test_the_initial_state_follows_from_parameters_and_stress() -> None:
    state = [
        {"name": "pc", "initial": "OCR * (p + q**2 / p)"},
        {"name": "sz", "initial": "sigma_zz - sigma_xy"},
        {"name": "e"},
    ]
    given = {**ELASTIC, "parameters": {**ELASTIC["parameters"], "OCR": {"default": 2}}, "state": state}
    of = soil(given, MODULI)
    p, q2 = 215.0 / 3.0, 0.5 * (40.0**2 + 45.0**2 + 5.0**2) + 3.0 * (64.0 + 25.0 + 9.0)
    found = of.law.initial_state(np.array([STRESS, 2.0 * STRESS]), of.constants)
    assert found.shape == (2, 3 + BESIDE)
    assert found[0, :3] == pytest.approx([2.0 * (p + q2 / p), 47.0, 0.0])
    assert found[1, :2] == pytest.approx(2.0 * found[0, :2])
    plane = of.law.initial_state(STRESS[:4], of.constants)
    assert plane[0] == pytest.approx(2.0 * (p + (q2 - 3.0 * 34.0) / p))


def test_moduli_K0_and_time_scale_are_declared_or_found() -> None:
    declared, found = one("drucker_prager"), one("drucker_prager", moduli=None)
    expected = (1.0e4 / 1.2, 1.0e4 / 2.6)
    assert declared.law.elastic_moduli(declared.constants, 50.0) == pytest.approx(expected)
    assert found.law.elastic_moduli(found.constants, 50.0) == pytest.approx(expected)
    assert declared.law.K0(declared.constants) == pytest.approx(1.0 - math.sin(math.radians(25.0)))
    assert one("elastic", K0=None).law.knows_K0 is False
    assert one("elastic").law.knows_K0 is True
    creeping = one("norton", time_scale="1 / (E * A * p**2)")
    scale = creeping.law.log_time_scale(STRESS, np.zeros(10), creeping.constants)
    assert scale == pytest.approx(-math.log(1.0e4 * 1.0e-8 * (215.0 / 3.0) ** 2))
    assert one("norton").law.log_time_scale(STRESS, np.zeros(10), creeping.constants) is None
    wrong = one("norton", time_scale=-1.0)
    with pytest.raises(InfeasibleError, match="time_scale must be above 0 day, got -1 day"):
        wrong.law.log_time_scale(STRESS, np.zeros(10), wrong.constants)


def test_a_step_has_no_stress_where_the_routine_gives_none() -> None:
    words = {
        1: "ended itself", 2: "ended itself", 3: "ended itself", 4: "ended itself", 5: "ended itself",
        6: "ended itself", 7: "ended itself", 12: "ended itself",
        9: "numbers that are none", 10: "numbers that are none", 11: "numbers that are none",
    }  # fmt: skip
    for mode, told in words.items():
        of = soil(MISBEHAVING, {**MODULI, "mode": mode, "stress": 120.0})
        assert step(of, SMALL[:4], STRESS[:4])[3] == 0
        for _ in range(3):  # the way back from XIT and STOP is there for each call
            assert step(of, LARGE[:4] * [-1, 1, -1, 1], STRESS[:4])[3] == -1, mode
        assert of.law.troubles().endswith(
            f"{told} (XIT, STOP) 3 times" if told == "ended itself" else f"{told} 3 times"
        )  # type: ignore[attr-defined]
        of.law.forget_troubles()  # type: ignore[attr-defined]
        assert of.law.troubles() == ""  # type: ignore[attr-defined]
        assert step(of, SMALL[:4], STRESS[:4])[3] == 0


def test_a_shorter_increment_is_asked_for_and_made() -> None:
    of = soil(MISBEHAVING, {**MODULI, "mode": 8, "stress": 0.9e-3})
    assert step(of, LARGE, STRESS)[3] == -1
    assert step(of, 0.25 * LARGE, STRESS)[3] == 0
    assert "asked for a shorter increment (PNEWDT) 1 times" in of.law.troubles()  # type: ignore[attr-defined]


def test_a_warning_of_the_utilities_does_not_end_the_step(capfd: pytest.CaptureFixture[str]) -> None:
    of = soil(MISBEHAVING, {**MODULI, "mode": 14, "stress": 0.0}, name="BLUE CLAY")
    assert step(of, SMALL, STRESS)[3] == 0
    assert "BLUE CLA WARNS" in capfd.readouterr().out
