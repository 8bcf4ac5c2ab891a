"""Thick cylinders under internal pressure: elastic, Tresca and Mohr-Coulomb, against closed forms."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest

from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.results import PhaseResult
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.verification.specimens.bodies import block, graded, moved
from geoswarm.verification.specimens.soils import elastic, mohr_coulomb

CLOSE = Control(tolerance=1.0e-9)


def ring(cells: int) -> Mesh:
    """Quarter of a ring, radii 1 and 2; "left" is the inside."""

    def bend(nodes: np.ndarray) -> np.ndarray:  # type: ignore[type-arg]
        # The angle grows clockwise so that the triangles stay counter-clockwise.
        return np.column_stack(
            [nodes[:, 0] * np.cos(nodes[:, 1]), nodes[:, 0] * np.sin(nodes[:, 1])],
        )

    return moved(block(graded(1.0, 2.0, cells), graded(0.0, math.pi / 2, 2 * cells)), bend)


def disc(cells: int) -> Mesh:
    """Strip of a disc between the radii 1 and 2, 0.1 high, for axisymmetry."""
    return block(graded(1.0, 2.0, cells), np.array([0.0, 0.1]))


RING = (Fixity("bottom", y=0.0), Fixity("top", x=0.0))
DISC = (Fixity("bottom", y=0.0), Fixity("top", y=0.0))


@pytest.mark.parametrize("geometry", ["plane_strain", "axisymmetric"])
def test_the_elastic_cylinder_widens_as_lame_says(geometry: Literal["plane_strain", "axisymmetric"]) -> None:
    mesh, fixities = (ring(16), RING) if geometry == "plane_strain" else (disc(16), DISC)
    phase = Phase(
        "pressure",
        materials={"soil": elastic(1.0e4, 0.3)},
        fixities=fixities,
        tractions=(Traction("left", normal=-100.0),),
    )
    result = solve_phases(mesh, [phase], geometry=geometry, control=CLOSE)[0]
    inside, outside = np.unique(mesh.boundaries["left"]), np.unique(mesh.boundaries["right"])
    assert np.hypot(*result.displacements[inside].T) == pytest.approx(0.0190667, rel=1.0e-4)
    assert np.hypot(*result.displacements[outside].T) == pytest.approx(0.0121333, rel=1.0e-4)


def _squeezed(material: Material, widening: float, load_step: float = 0.02) -> tuple[float, PhaseResult]:
    """Pressure that a prescribed widening of the inside needs, and the state."""
    mesh = disc(24)
    phase = Phase(
        "widening",
        materials={"soil": material},
        fixities=(*DISC, Fixity("left", x=widening)),
        load_step=load_step,
        largest_load_step=load_step,
    )
    result = solve_phases(mesh, [phase], geometry="axisymmetric", control=CLOSE)[0]
    inside = np.unique(mesh.boundaries["left"])
    return float(result.reactions[inside, 0].sum()) / 0.1, result


def test_a_tresca_tube_yields_spreads_and_fails_at_its_limit_pressure() -> None:
    tresca = mohr_coulomb(1.0e4, 0.3, 50.0, 0.0, tension_cutoff=None)
    # u(a) at first yield by Lame: 37.5/100 of 0.0190667 m.
    below, state = _squeezed(tresca, 0.99 * 0.375 * 0.0190667)
    assert not state.plastic.any()
    assert below == pytest.approx(0.99 * 37.5, rel=1.0e-3)
    limit, state = _squeezed(tresca, 0.06)
    assert state.plastic.all()
    assert limit == pytest.approx(69.3147, rel=0.01)


def test_the_plastic_front_of_the_tresca_tube_is_where_it_should_be() -> None:
    mesh = disc(40)
    phase = Phase(
        "pressure",
        materials={"soil": mohr_coulomb(1.0e4, 0.3, 50.0, 0.0, tension_cutoff=None)},
        fixities=DISC,
        tractions=(Traction("left", normal=-62.4215),),
        load_step=0.1,
        largest_load_step=0.1,
    )
    result = solve_phases(mesh, [phase], geometry="axisymmetric", control=CLOSE)[0]
    points = mesh.nodes[mesh.triangles[:, :3]].mean(axis=1)[:, 0]
    plastic = result.plastic.any(axis=1)
    assert points[plastic].max() == pytest.approx(1.5, abs=1.0 / 40)
    assert points[~plastic].min() == pytest.approx(1.5, abs=1.0 / 40)


@pytest.mark.parametrize("psi", [0.0, 30.0])
def test_a_mohr_coulomb_tube_fails_at_its_limit_pressure(psi: float) -> None:
    c, phi = 50.0, math.radians(30.0)
    N = (1.0 + math.sin(phi)) / (1.0 - math.sin(phi))
    limit = c / math.tan(phi) * (2.0 ** (1.0 - 1.0 / N) - 1.0)
    pressure, state = _squeezed(mohr_coulomb(1.0e4, 0.3, c, 30.0, psi, tension_cutoff=None), 0.06)
    assert state.plastic.all()
    assert pressure == pytest.approx(limit, rel=0.01)


def test_the_triaxial_strength_of_mohr_coulomb() -> None:
    mesh = block(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
    at_rest = Phase(
        "cell",
        "K0",
        materials={"soil": mohr_coulomb(1.0e4, 0.3, 5.0, 25.0)},
        initial_stress=lambda x: np.tile([-100.0, -100.0, -100.0, 0.0], (x.shape[0], 1)),
        fixities=(Fixity("bottom", y=0.0), Fixity("left", x=0.0)),
        tractions=(Traction("right", normal=-100.0), Traction("top", normal=-100.0)),
    )
    shear = Phase(
        "shear",
        fixities=(Fixity("bottom", y=0.0), Fixity("left", x=0.0), Fixity("top", y=-0.05)),
        tractions=(Traction("right", normal=-100.0),),
        load_step=0.1,
    )
    result = solve_phases(mesh, [at_rest, shear], geometry="axisymmetric", control=CLOSE)[-1]
    assert result.stress[..., 0] - result.stress[..., 1] == pytest.approx(162.0881, rel=1.0e-5)
