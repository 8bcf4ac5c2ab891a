"""Patch tests on distorted meshes, with curved sides and interfaces."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.materials import InterfaceMaterial
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.verification.specimens.bodies import block, graded, moved, stacked
from geoswarm.verification.specimens.soils import elastic, mohr_coulomb

TIGHT = Control(tolerance=1.0e-13)
ELASTIC = elastic(1.0e4, 0.3)


def everywhere(mesh: Mesh, field: FloatArray) -> tuple[Fixity, ...]:
    """Prescribe a displacement field (n, 2) on the whole boundary."""
    nodes = np.unique(mesh.boundaries["around"])
    return (Fixity("around", x=field[nodes, 0], y=field[nodes, 1]),)


@pytest.mark.parametrize("geometry", ["plane_strain", "axisymmetric"])
def test_a_linear_field_is_exact_on_a_distorted_mesh(geometry: str) -> None:
    mesh = block(graded(1.0, 3.0, 4), graded(0.0, 1.0, 3), distortion=0.3)
    gradient = np.array([[0.01, 0.02], [-0.005, 0.03]]) if geometry == "plane_strain" else np.diag([0.01, -0.02])
    field = mesh.nodes @ gradient.T
    phase = Phase("patch", materials={"soil": ELASTIC}, fixities=everywhere(mesh, field))
    result = solve_phases(mesh, [phase], geometry=geometry, control=TIGHT)[0]  # type: ignore[arg-type]
    assert result.displacements == pytest.approx(field, abs=1.0e-12)
    around = 0.01 if geometry == "axisymmetric" else 0.0
    strain = np.array([gradient[0, 0], gradient[1, 1], around, gradient[0, 1] + gradient[1, 0]])
    shear = 1.0e4 / 2.6
    lame = 2.0 * shear * 0.3 / 0.4
    stress = 2.0 * shear * strain * [1.0, 1.0, 1.0, 0.5] + lame * strain[:3].sum() * np.array([1.0, 1.0, 1.0, 0.0])
    assert result.stress == pytest.approx(np.broadcast_to(stress, result.stress.shape), abs=1.0e-9)


def test_curved_sides_pass_the_patch_test() -> None:
    straight = block(graded(0.0, 2.0, 3), graded(0.0, 1.0, 2))
    inner = np.setdiff1d(np.arange(straight.nodes.shape[0]), np.unique(straight.boundaries["around"]))

    def change(nodes: FloatArray) -> FloatArray:
        new = nodes.copy()
        new[inner] += np.random.default_rng(4).uniform(-0.04, 0.04, (inner.size, 2))
        return new

    mesh = moved(straight, change)
    field = mesh.nodes @ np.array([[0.01, 0.02], [-0.005, 0.03]])
    phase = Phase("patch", materials={"soil": ELASTIC}, fixities=everywhere(mesh, field))
    result = solve_phases(mesh, [phase], control=TIGHT)[0]
    assert result.displacements == pytest.approx(field, abs=1.0e-12)


@pytest.mark.parametrize("slant", [0.0, 0.4])
def test_uniform_tractions_pass_through_an_interface(slant: float) -> None:
    lower = block(graded(0.0, 3.0, 3), graded(0.0, 1.0, 2), distortion=0.2, name="lower")
    upper = moved(block(graded(0.0, 3.0, 3), graded(0.0, 1.0, 2), name="upper"), lambda x: x + np.array([0.0, 1.0]))
    mesh = moved(stacked(lower, upper), lambda x: x + np.column_stack([0.0 * x[:, 0], slant * x[:, 0]]))
    stress = np.array([[-30.0, 6.0], [6.0, -20.0]])
    rise = np.hypot(1.0, slant)
    along = np.array([1.0, slant]) / rise
    out = np.array([-along[1], along[0]])
    top, left, right = stress @ out, stress @ [-1.0, 0.0], stress @ [1.0, 0.0]
    tractions = [Traction("top", x=top[0], y=top[1])]
    for prefix in ("", "lower "):
        tractions += [
            Traction(f"{prefix}left", x=left[0], y=left[1]),
            Traction(f"{prefix}right", x=right[0], y=right[1]),
        ]
    tractions.append(Traction("lower bottom", x=-top[0], y=-top[1]))
    joint = InterfaceMaterial(2.0e4, 1.0e4, 50.0, 30.0)
    corner = int(mesh.boundaries["lower bottom"][0, 0])
    other = int(mesh.boundaries["lower bottom"][1, 1])
    phase = Phase(
        "patch",
        materials={"lower": ELASTIC, "upper": ELASTIC, "joint": joint},
        fixities=(Fixity((corner,), x=0.0, y=0.0), Fixity((other,), y=0.0)),
        tractions=tuple(tractions),
        load_step=1.0,
    )
    result = solve_phases(mesh, [phase], control=TIGHT)[0]
    uniform = np.array([-30.0, -20.0, 0.3 * -50.0, 6.0])
    assert result.stress == pytest.approx(np.broadcast_to(uniform, result.stress.shape), abs=1.0e-9)
    assert result.interface_tractions[..., 0] == pytest.approx(top @ out, abs=1.0e-9)
    assert result.interface_tractions[..., 1] == pytest.approx(top @ along, abs=1.0e-9)
    jump = result.displacements[mesh.interfaces[:, :3]] - result.displacements[mesh.interfaces[:, 3:]]
    assert jump @ out == pytest.approx(top @ out / 2.0e4, abs=1.0e-12)
    assert jump @ along == pytest.approx(top @ along / 1.0e4, abs=1.0e-12)


def test_plastic_patch_keeps_uniform_stress_at_the_limit() -> None:
    mesh = block(graded(0.0, 2.0, 3), graded(0.0, 1.0, 3), distortion=0.25)
    field = mesh.nodes * [0.01, -0.02]
    phase = Phase(
        "patch", materials={"soil": mohr_coulomb(1.0e4, 0.3, 5.0, 25.0, 5.0)}, fixities=everywhere(mesh, field)
    )
    result = solve_phases(mesh, [phase], control=TIGHT)[0]
    assert result.plastic.all()
    assert result.displacements == pytest.approx(field, abs=1.0e-10)
    assert result.stress == pytest.approx(np.broadcast_to(result.stress[0, 0], result.stress.shape), abs=1.0e-6)
