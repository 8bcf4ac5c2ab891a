"""Loads that a body can just carry: footing, slopes, a block on an interface."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from geoswarm.solver.errors import DivergedError
from geoswarm.solver.fem.materials import InterfaceMaterial
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import solve_phases
from tests.soils import elastic, mohr_coulomb
from tests.verification.fem.bodies import block, embankment, graded, moved, slope, stacked

SIDES = (Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", x=0.0, y=0.0))


def _footing(cells: int) -> float:
    """Bearing capacity over cohesion of a smooth strip footing, half width 1, on weightless soil."""
    x = np.concatenate([graded(0.0, 1.0, cells), graded(1.0, 5.0, 2 * cells, 1.25 ** (4 / cells))[1:]])
    y = graded(-4.0, 0.0, 3 * cells, 0.8 ** (4 / cells))
    mesh = block(x, y)
    under = tuple(int(node) for node in np.unique(mesh.boundaries["top"]) if mesh.nodes[node, 0] < 1.0 + 1.0e-9)
    phase = Phase(
        "footing",
        materials={"soil": mohr_coulomb(1.0e5, 0.49, 100.0, 0.0, tension_cutoff=None)},
        fixities=(*SIDES, Fixity(under, y=-0.03)),
        load_step=0.05,
        largest_load_step=0.1,
    )
    result = solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4))[0]
    return float(-result.reactions[list(under), 1].sum()) / 100.0


def test_prandtl_footing_within_three_percent_and_converging() -> None:
    coarse, fine = _footing(4), _footing(8)
    exact = 2.0 + math.pi
    assert fine == pytest.approx(exact, rel=0.03)
    assert abs(fine - exact) < 0.75 * abs(coarse - exact)


def _stands(mesh: Mesh, factor: float) -> bool:
    """Whether the slope of Griffiths & Lane (1999), example 1, carries its weight with its strength reduced."""
    c, phi = 10.0 / factor, math.degrees(math.atan(math.tan(math.radians(20.0)) / factor))
    soil = mohr_coulomb(1.0e5, 0.3, c, phi, tension_cutoff=None, unit_weight=20.0)
    phase = Phase("weight", "gravity", materials={"soil": soil}, fixities=SIDES[::2], load_step=0.2)
    try:
        solve_phases(mesh, [phase], control=Control(tolerance=1.0e-4, smallest_step=0.01))
    except DivergedError:
        return False
    return True


def test_griffiths_and_lane_slope_fails_at_a_strength_reduction_of_about_1_4() -> None:
    mesh = embankment(12.0, 20, 10)
    assert _stands(mesh, 1.37)
    assert not _stands(mesh, 1.43)


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


def test_a_block_slides_on_its_interface_at_60_kn_per_metre() -> None:
    lower = block(graded(-1.0, 5.0, 6), graded(-1.0, 0.0, 1), name="base")
    upper = block(graded(0.0, 4.0, 4), graded(0.0, 1.0, 1), name="block")
    mesh = stacked(lower, upper)
    joint = InterfaceMaterial(1.0e5, 1.0e5, 2.5, math.degrees(math.atan(0.5)))
    press = Phase(
        "weight",
        materials={"base": elastic(1.0e6, 0.0), "block": elastic(1.0e6, 0.0), "joint": joint},
        fixities=(Fixity("lower bottom", x=0.0, y=0.0), Fixity("left", x=0.0)),
        tractions=(Traction("top", y=-25.0),),
    )
    push = Phase(
        "push",
        fixities=(Fixity("lower bottom", x=0.0, y=0.0), Fixity("left", x=0.01)),
        load_step=0.05,
    )
    result = solve_phases(mesh, [press, push])[-1]
    pushed = float(result.reactions[np.unique(mesh.boundaries["left"]), 0].sum())
    assert pushed == pytest.approx(4.0 * 2.5 + 100.0 * 0.5, rel=0.01)


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
