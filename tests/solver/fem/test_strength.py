"""What stresses need in addition to the strength of a body, and how that fades."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.fem.body import Body, State
from geoswarm.solver.fem.materials import InterfaceMaterial, Material
from geoswarm.solver.fem.strength import associated, missing_strength, strengthened
from geoswarm.verification.specimens.soils import elastic, mohr_coulomb, soil_arrays


def _body(soil: Material, joint: InterfaceMaterial) -> Body:
    return Body(
        False,
        False,
        np.zeros((1, 6), dtype=np.int32),
        np.zeros(1, dtype=np.int64),
        *soil_arrays(soil),
        np.zeros((1, 6), dtype=np.int32),
        np.zeros(1, dtype=np.int64),
        joint.constants()[np.newaxis],
        np.empty((0, 3), dtype=np.int32),
        np.empty(0, dtype=np.int64),
        np.empty((0, 3), dtype=np.int64),
    )


def _state(stress: tuple[float, float, float, float], traction: tuple[float, float]) -> State:
    blank = np.zeros((1, 3))
    return State(
        np.tile(np.array(stress), (1, 3, 1)),
        np.zeros((1, 3, 0)),
        np.zeros((1, 3), dtype=np.bool_),
        np.tile(np.array(traction), (1, 3, 1)),
        blank.copy(),
    )


SOIL = mohr_coulomb(1.0e4, 0.3, 2.0, 30.0, 10.0, 0.0)
JOINT = InterfaceMaterial(1.0e5, 1.0e5, 1.0, 20.0)


def test_stresses_within_the_limits_need_nothing() -> None:
    assert missing_strength(_body(SOIL, JOINT), _state((-10.0, -20.0, -12.0, 0.0), (-10.0, 3.0))) is None
    assert missing_strength(_body(elastic(1.0e4, 0.3), JOINT), _state((9.0, 0.0, 0.0, 50.0), (0.0, 0.5))) is None


def test_cohesion_and_cut_off_are_missing_as_by_mohrs_circle() -> None:
    """Uniaxial compression of 100 kPa needs c = q (1 - sin phi)/(2 cos phi); shear of 10 kPa at no pressure c = 10."""
    more = missing_strength(_body(SOIL, JOINT), _state((0.0, -100.0, 0.0, 0.0), (3.0, -10.0)))
    assert more is not None
    assert more.soils[0] == pytest.approx([100.0 * 0.5 / (2.0 * math.cos(math.radians(30.0))) - 2.0, 0.0])
    assert more.interfaces[0] == pytest.approx([10.0 + 3.0 * math.tan(math.radians(20.0)) - 1.0, 3.0])
    turned = missing_strength(_body(SOIL, JOINT), _state((-50.0, -50.0, 0.0, 50.0), (0.0, 0.0)))
    assert turned is not None
    assert turned.soils[0] == pytest.approx(more.soils[0])


def test_strength_fades_to_that_of_the_body() -> None:
    body, state = _body(SOIL, JOINT), _state((1.0, -100.0, 0.0, 0.0), (3.0, -10.0))
    more = missing_strength(body, state)
    assert more is not None
    assert missing_strength(strengthened(body, more, 1.0), state) is None
    half = missing_strength(strengthened(body, more, 0.5), state)
    assert half is not None
    assert half.soils == pytest.approx(0.5 * more.soils)
    none = strengthened(body, more, 0.0)
    assert np.array_equal(none.constants, body.constants)
    assert np.array_equal(none.interface_constants, body.interface_constants)


def test_associated_flow_changes_the_dilatancy_alone() -> None:
    flowing = associated(_body(SOIL, JOINT))
    same = mohr_coulomb(1.0e4, 0.3, 2.0, 30.0, 30.0, 0.0), InterfaceMaterial(1.0e5, 1.0e5, 1.0, 20.0, 20.0)
    assert np.array_equal(flowing.constants[0], same[0].soil.constants)
    assert np.array_equal(flowing.interface_constants[0], same[1].constants())
