"""Tractions of an interface: friction, dilatancy, no tension, and their derivative."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.fem.interface import interface_update
from geoswarm.solver.fem.materials import InterfaceMaterial

REACH = st.floats(-2.0e-2, 2.0e-2)


def _law(c: float = 5.0, phi: float = 30.0, psi: float = 0.0, tension: float | None = 0.0) -> InterfaceMaterial:
    return InterfaceMaterial(1.0e4, 5.0e3, c, phi, psi, tension)


def test_elastic_below_the_limit() -> None:
    D = np.zeros((2, 2))
    assert interface_update(-50.0, 0.0, 0.0, -1.0e-3, 2.0e-3, _law().constants(), D) == pytest.approx(
        (-60.0, 10.0, 0.0)
    )
    assert np.allclose(D, np.diag([1.0e4, 5.0e3]), rtol=1.0e-9, atol=1.0e-9)


def test_friction_limits_the_shear() -> None:
    D = np.zeros((2, 2))
    normal, shear, _ = interface_update(-50.0, 0.0, 0.0, 0.0, -0.1, _law().constants(), D)
    assert normal == pytest.approx(-50.0)
    assert shear == pytest.approx(-(5.0 + 50.0 * math.tan(math.radians(30.0))))
    assert D[1] == pytest.approx([math.tan(math.radians(30.0)) * 1.0e4, 0.0])


def test_dilatancy_presses_the_sides_together() -> None:
    normal, *_ = interface_update(-50.0, 0.0, 0.0, 0.0, 0.02, _law(psi=10.0).constants(), np.zeros((2, 2)))
    assert normal < -60.0


def test_opening_leaves_no_traction() -> None:
    D = np.zeros((2, 2))
    assert interface_update(-50.0, 3.0, 0.0, 0.1, 0.0, _law(c=0.0).constants(), D) == pytest.approx((0.0, 0.0, 0.095))
    assert np.allclose(D, np.zeros((2, 2)), rtol=1.0e-9, atol=1.0e-9)


def test_what_has_opened_must_close_before_it_presses_again() -> None:
    constants, D = _law(c=0.0).constants(), np.zeros((2, 2))
    opened = interface_update(0.0, 0.0, 0.0, 0.03, 0.0, constants, D)
    assert opened == pytest.approx((0.0, 0.0, 0.03))
    half = interface_update(*opened, -0.02, 0.0, constants, D)
    assert half == pytest.approx((0.0, 0.0, 0.01))
    assert interface_update(*half, -0.015, 0.0, constants, D) == pytest.approx((-50.0, 0.0, 0.0))


@given(REACH, REACH, st.sampled_from([0.0, 10.0, 30.0]), st.sampled_from([0.0, 2.0, None]))
def test_the_limit_holds_and_the_derivative_is_right(
    opening: float, slip: float, psi: float, tension: float | None
) -> None:
    law = _law(psi=psi, tension=tension)
    constants, D, spare = law.constants(), np.zeros((2, 2)), np.zeros((2, 2))
    normal, shear, gap = interface_update(-20.0, 2.0, 0.0, opening, slip, constants, D)
    assert gap >= 0.0
    friction = math.tan(math.radians(30.0))
    assert abs(shear) + normal * friction <= 5.0 + 1.0e-9
    assert normal <= (5.0 / friction if tension is None else tension) + 1.0e-9
    way = np.array([1.0, 0.7])
    sides = []
    for sign in (1.0, -1.0):
        step = sign * 1.0e-8 * way
        other = interface_update(-20.0, 2.0, 0.0, opening + step[0], slip + step[1], constants, spare)[:2]
        sides.append(sign * (np.array(other) - [normal, shear]) / 1.0e-8)
    assert min(np.abs(side - D @ way).max() for side in sides) < 1.0e-2
