"""Updated mesh: rotation keeps stress, shear follows Jaumann's rate, strain is logarithmic, loads follow."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import Calculation, solve_phases
from geoswarm.verification.specimens.bodies import block, graded
from geoswarm.verification.specimens.soils import elastic

CLOSE = Control(tolerance=1.0e-9)
ALONG, UP = np.array([0.0, 1.0, 2.0]), np.array([0.0, 1.0])


def _everywhere(mesh: Mesh, change: FloatArray) -> tuple[Fixity, ...]:
    nodes = np.unique(mesh.boundaries["around"])
    return (Fixity("around", x=change[nodes, 0], y=change[nodes, 1]),)


def test_a_turn_by_360_degree_keeps_the_stress() -> None:
    mesh = block(graded(0.0, 2.0, 2), graded(0.0, 1.0, 2), distortion=0.2)
    stress = np.array([-30.0, -80.0, -40.0, 12.0])
    calculation = Calculation(mesh, control=CLOSE)
    calculation.run(
        Phase(
            "start",
            "K0",
            materials={"soil": elastic(1.0e4, 0.3)},
            initial_stress=lambda x: np.tile(stress, (x.shape[0], 1)),
        )
    )
    steps = 36
    for step in range(steps):
        angle = 2.0 * math.pi * (step + 1) / steps
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        change = mesh.nodes @ turn.T - calculation.positions
        phase = Phase(f"turn {step}", fixities=_everywhere(mesh, change), updated_mesh=True, load_step=1.0)
        result = calculation.run(phase)
        if step == 8:
            quarter = np.array([stress[1], stress[0], stress[2], -stress[3]])
            assert result.stress == pytest.approx(np.broadcast_to(quarter, result.stress.shape), abs=1.0e-6)
    assert result.stress == pytest.approx(np.broadcast_to(stress, result.stress.shape), abs=1.0e-6)
    assert result.positions == pytest.approx(mesh.nodes, abs=1.0e-9)


def _sheared(steps: int) -> FloatArray:
    mesh = block(ALONG, UP)
    change = np.column_stack([2.0 * mesh.nodes[:, 1], 0.0 * mesh.nodes[:, 0]])
    phase = Phase(
        "shear",
        materials={"soil": elastic(2.6e3, 0.3)},
        fixities=_everywhere(mesh, change),
        updated_mesh=True,
        load_step=1.0 / steps,
        largest_load_step=1.0 / steps,
    )
    stress: FloatArray = solve_phases(mesh, [phase], control=CLOSE)[0].stress
    return stress


def test_simple_shear_follows_jaumann() -> None:
    coarse, fine = _sheared(20), _sheared(40)
    shear = 1.0e3
    assert fine[..., 3] == pytest.approx(shear * math.sin(2.0), rel=1.0e-3)
    assert fine[..., 0] == pytest.approx(shear * (1.0 - math.cos(2.0)), rel=1.0e-3)
    errors = [abs(float(stress[0, 0, 3]) - shear * math.sin(2.0)) for stress in (coarse, fine)]
    assert math.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.2)


@pytest.mark.parametrize("geometry", ["plane_strain", "axisymmetric"])
def test_large_compaction_is_logarithmic(geometry: str) -> None:
    """A pressure that gives the logarithmic strain 0.23026 shortens by 0.20567 of the height."""
    mesh = block(ALONG, UP)
    stiffness = 1.0e4 * 0.7 / (1.3 * 0.4)
    phase = Phase(
        "compaction",
        materials={"soil": elastic(1.0e4, 0.3)},
        fixities=(Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", y=0.0)),
        tractions=(Traction("top", normal=-0.23026 * stiffness),),
        updated_mesh=True,
        load_step=0.02,
        largest_load_step=0.02,
    )
    result = solve_phases(mesh, [phase], geometry=geometry, control=CLOSE)[0]  # type: ignore[arg-type]
    top = np.unique(mesh.boundaries["top"])
    assert result.displacements[top, 1] == pytest.approx(-0.20567, abs=1.0e-5)


@pytest.mark.parametrize("follower", [True, False])
def test_a_pressure_follows_a_turning_body_only_when_asked_to(follower: bool) -> None:
    mesh = block(ALONG, UP)
    base = Phase(
        "pressure",
        materials={"soil": elastic(1.0e4, 0.3)},
        fixities=(Fixity("left", x=0.0, y=0.0),),
        tractions=(Traction("right", normal=-10.0, follower=follower),),
        updated_mesh=True,
    )
    calculation = Calculation(mesh, control=CLOSE)
    calculation.run(base)
    left = np.unique(mesh.boundaries["left"])
    at = calculation.positions[left]
    turned = np.column_stack([-at[:, 1], at[:, 0]]) - at
    quarter = Phase(
        "turn", fixities=(Fixity("left", x=turned[:, 0], y=turned[:, 1]),), updated_mesh=True, load_step=0.05
    )
    result = calculation.run(quarter)
    reaction = result.reactions[left].sum(axis=0)
    assert reaction == pytest.approx([0.0, 10.0] if follower else [10.0, 0.0], abs=0.05)
