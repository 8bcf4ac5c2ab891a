"""Patch tests on distorted meshes, with curved sides and interfaces, and the order of convergence."""

from __future__ import annotations

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.materials import InterfaceMaterial
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.solver.fem.triangle import shape_functions
from tests.soils import elastic, mohr_coulomb
from tests.verification.fem.bodies import block, graded, moved, stacked

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


def _errors(cells: int) -> tuple[float, float]:
    """Errors in displacement and stress (L2) for a harmonic gradient field, which needs no weight."""
    mesh = block(graded(0.0, 1.0, cells), graded(0.0, 1.0, cells), distortion=0.2)

    def exact(x: FloatArray) -> FloatArray:
        return np.stack([np.exp(x[..., 0]) * np.cos(x[..., 1]), -np.exp(x[..., 0]) * np.sin(x[..., 1])], axis=-1)

    phase = Phase("rate", materials={"soil": ELASTIC}, fixities=everywhere(mesh, exact(mesh.nodes)), load_step=1.0)
    result = solve_phases(mesh, [phase], control=TIGHT)[0]
    displacement, stress = 0.0, 0.0
    for xi, eta in np.random.default_rng(0).dirichlet((1.0, 1.0, 1.0), 12)[:, :2]:
        values, slopes = shape_functions(float(xi), float(eta))
        corners = mesh.nodes[mesh.triangles]
        own = result.displacements[mesh.triangles]
        at = np.einsum("n,enj->ej", values, corners)
        jacobian = np.einsum("in,enj->eij", slopes, corners)
        gradient = np.einsum("eij,ejk->eik", np.linalg.inv(jacobian), np.einsum("in,enj->eij", slopes, own))
        area = 0.5 * np.linalg.det(jacobian) / 12.0
        e = np.exp(at[:, 0])
        wanted = np.stack(
            [
                np.stack([e * np.cos(at[:, 1]), -e * np.sin(at[:, 1])], axis=-1),
                np.stack([-e * np.sin(at[:, 1]), -e * np.cos(at[:, 1])], axis=-1),
            ],
            axis=1,
        )
        off = gradient - wanted
        sym = off + off.transpose(0, 2, 1)
        shear = 1.0e4 / 2.6
        trace = off[:, 0, 0] + off[:, 1, 1]
        lame = 2.0 * shear * 0.3 / 0.4
        sigma = shear * sym + (lame * trace)[:, np.newaxis, np.newaxis] * np.eye(2)
        displacement += float((area * ((np.einsum("n,enj->ej", values, own) - exact(at)) ** 2).sum(axis=1)).sum())
        stress += float((area * (sigma**2).sum(axis=(1, 2))).sum())
    return float(np.sqrt(displacement)), float(np.sqrt(stress))


def test_displacement_converges_with_order_three_and_stress_with_order_two() -> None:
    coarse, fine = _errors(8), _errors(16)
    assert np.log2(coarse[0] / fine[0]) == pytest.approx(3.0, abs=0.2)
    assert np.log2(coarse[1] / fine[1]) == pytest.approx(2.0, abs=0.15)
