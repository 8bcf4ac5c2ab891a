"""Loads that a body can just carry: slopes, a block that is lifted off its interface."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from geoswarm.solver.errors import DivergedError
from geoswarm.solver.fem.materials import InterfaceMaterial
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.verification.specimens.bodies import block, graded, moved, slope, stacked
from geoswarm.verification.specimens.soils import elastic, mohr_coulomb

SIDES = (Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", x=0.0, y=0.0))


def _infinite_slope(factor: float) -> bool:
    """Whether an infinite slope (10 degree, 30 m, c = 20 kPa, phi = 20 degree) stands with its strength reduced."""
    angle, depth, weight, length = math.radians(10.0), 30.0, 20.0, 60.0
    tangent = math.tan(angle)
    mesh = moved(
        block(graded(0.0, length, 6), graded(-depth, 0.0, 8)),
        lambda x: x - np.column_stack([0.0 * x[:, 0], tangent * x[:, 0]]),
    )
    # Stress grows with depth: on planes along the slope, and from the circle that touches the limit at failure.
    normal, shear = -weight * math.cos(angle) ** 2, weight * math.sin(angle) * math.cos(angle)
    strength = math.tan(math.radians(20.0)) / factor
    along = 2.0 * (normal - shear * strength) - normal
    c, s = math.cos(angle), math.sin(angle)
    sigma_x = c * c * along + s * s * normal + 2.0 * s * c * shear
    sigma_xy = -sigma_x * tangent
    ends = (
        Traction("left", x_slope=sigma_x, y_slope=sigma_xy, level=0.0),
        Traction("right", x_slope=-sigma_x, y_slope=-sigma_xy, level=-length * tangent),
    )
    friction = math.degrees(math.atan(strength))
    soil = mohr_coulomb(1.0e5, 0.3, 20.0 / factor, friction, friction, unit_weight=weight)
    phase = Phase(
        "weight",
        "gravity",
        materials={"soil": soil},
        fixities=(Fixity("bottom", x=0.0, y=0.0),),
        tractions=ends,
        load_step=0.1,
    )
    try:
        solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4, smallest_step=0.01))
    except DivergedError:
        return False
    return True


def test_an_infinite_slope_fails_at_its_factor_of_safety() -> None:
    angle, weight = math.radians(10.0), 20.0 * 30.0
    resisting = 20.0 + weight * math.cos(angle) ** 2 * math.tan(math.radians(20.0))
    safety = resisting / (weight * math.sin(angle) * math.cos(angle))
    assert _infinite_slope(0.98 * safety)
    assert not _infinite_slope(1.02 * safety)


def test_a_lifted_block_leaves_its_interface_without_tension() -> None:
    lower = block(graded(0.0, 2.0, 2), graded(-1.0, 0.0, 1), name="base")
    upper = block(graded(0.0, 2.0, 2), graded(0.0, 1.0, 1), name="block")
    mesh = stacked(lower, upper)
    soil = elastic(1.0e6, 0.0)
    lift = Phase(
        "lift",
        materials={"base": soil, "block": replace(soil), "joint": InterfaceMaterial(1.0e5, 1.0e5, 0.0, 30.0)},
        fixities=(Fixity("lower bottom", x=0.0, y=0.0), Fixity("top", x=0.0, y=0.01)),
    )
    result = solve_phases(mesh, [lift])[0]
    assert np.abs(result.interface_tractions).max() < 1.0e-9
    assert np.abs(result.stress).max() < 1.0e-6


def test_the_slope_of_the_comparison_moves_as_in_other_programs() -> None:
    """2:1, 10 m high, 10 m of ground below its toe, 20 m of crest and of toe; about 1070 triangles.

    Four other programs: 0.0304354 m elastic on one mesh of 1068 triangles, two of them 0.032925 m with Mohr-Coulomb in
    20 steps, one 0.032977 m.
    """
    mesh = slope(20.0, 20.0, 10.0, (13, 13, 12), 14)
    weight = Phase("weight", "gravity", materials={"soil": elastic(1.0e5, 0.3, 20.0)}, fixities=SIDES, load_step=1.0)
    largest = np.hypot(*solve_phases(mesh, [weight])[0].displacements.T).max()
    assert largest == pytest.approx(0.0304354, abs=2.0e-7)
    soil = mohr_coulomb(1.0e5, 0.3, 10.0, 20.0, tension_cutoff=None, unit_weight=20.0)
    plastic = replace(weight, materials={"soil": soil}, load_step=0.05, largest_load_step=0.05)
    largest = np.hypot(*solve_phases(mesh, [plastic])[0].displacements.T).max()
    assert largest == pytest.approx(0.032925, abs=5.0e-6)
