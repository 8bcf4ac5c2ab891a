"""Laboratory tests as boundary value problems: two triangles, or more, against the material point."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.constitutive.soft_soil_creep.physics import soft_soil_creep
from geoswarm.solver.element_test.material_point import follow
from geoswarm.solver.element_test.setups import confined_load, isotropic_load
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.results import PhaseResult
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.solver.laws.soft_soil_creep import creep_constants
from geoswarm.verification.specimens.bodies import block, graded, node_at
from geoswarm.verification.specimens.soils import creep_law, creep_point, creeping

STAGES = ((100.0, 1.0), (200.0, 1.0), (400.0, 1.0), (400.0, 99.0))
TWO = block(np.array([0.0, 1.0]), np.array([0.0, 1.0]))
Test = Literal["oedometer", "isotropic"]


def _soil(c: float = 0.0) -> Material:
    return creeping(soft_soil_creep(0.10, 0.02, 0.005, c, 30.0, K0nc=0.5), OCR=1.3)


def _elements(mesh: Mesh, test: Test, *, updated: bool = False, time_tolerance: float = 1.0e-4) -> list[PhaseResult]:
    lateral = 0.5 if test == "oedometer" else 1.0
    start = 50.0 * np.array([-lateral, -1.0, -lateral, 0.0])
    fixities = [Fixity("left", x=0.0), Fixity("bottom", y=0.0)]
    if test == "oedometer":
        fixities.append(Fixity("right", x=0.0))
    phases = [
        Phase(
            "start",
            "K0",
            materials={"soil": _soil()},
            initial_stress=lambda x: np.tile(start, (x.shape[0], 1)),
            fixities=tuple(fixities),
        )
    ]
    for number, (pressure, duration) in enumerate(STAGES):
        tractions = [Traction("top", normal=-pressure, follower=updated)]
        if test == "isotropic":
            tractions.append(Traction("right", normal=-pressure, follower=updated))
        phases.append(
            Phase(
                f"stage {number + 1}",
                "creep",
                duration=duration,
                tractions=tuple(tractions),
                output_times=tuple(np.linspace(0.0, duration, 5)),
                updated_mesh=updated,
                load_step=0.05 if updated else 0.25,
                largest_load_step=0.05 if updated else 1.0,
            )
        )
    return solve_phases(
        mesh,
        phases,
        geometry="axisymmetric",
        observe=[node_at(mesh, 0.0, 1.0)],
        control=Control(tolerance=1.0e-8, time_tolerance=time_tolerance),
    )[1:]


def _point(test: Test) -> FloatArray:
    """Axial strain at the times of :func:`_elements`, (stages, times)."""
    soil = creep_constants(_soil().soil.constants)
    lateral = 25.0 if test == "oedometer" else 50.0
    stage = confined_load if test == "oedometer" else isotropic_load
    start = creep_point([lateral, lateral, 50.0, 0.0, 0.0, 0.0], soil, OCR=1.3)
    times = [np.linspace(0.0, duration, 5) for _, duration in STAGES]
    history = follow(creep_law(soil), start, [stage(*one) for one in STAGES], times)
    axial: FloatArray = history.strain[:, 2].reshape(len(STAGES), -1)
    return axial


@pytest.mark.parametrize("test", ["oedometer", "isotropic"])
def test_elements_and_material_point_agree(test: Test) -> None:
    settlements = np.array([-result.history.displacements[:, 0, 1] for result in _elements(TWO, test)])
    expected = _point(test)
    assert settlements == pytest.approx(expected, abs=1.0e-4 * expected[-1, -1])


def test_the_incremental_oedometer_gives_the_published_limit() -> None:
    results = _elements(TWO, "oedometer", time_tolerance=1.0e-5)
    jumps = [-float(result.history.displacements[0, 0, 1]) for result in results[:3]]
    ends = [-float(result.history.displacements[-1, 0, 1]) for result in results]
    assert jumps == pytest.approx([0.010334, 0.058896, 0.128216], abs=1.0e-5)
    assert ends == pytest.approx([0.048785, 0.118116, 0.187431, 0.210458], abs=1.0e-5)
    final = results[-1].stress[..., :2]
    assert final[..., 0] / final[..., 1] == pytest.approx(0.52981, abs=1.0e-4)


def test_finer_meshes_give_the_same_uniform_strain() -> None:
    mesh = block(graded(0.0, 1.0, 3), graded(0.0, 1.0, 3), distortion=0.2)
    fine, coarse = _elements(mesh, "oedometer"), _elements(TWO, "oedometer")
    for one, other in zip(fine, coarse, strict=True):
        assert one.history.displacements == pytest.approx(other.history.displacements, abs=1.0e-5)


def test_an_updated_mesh_makes_the_strain_logarithmic() -> None:
    results = _elements(TWO, "oedometer", updated=True, time_tolerance=1.0e-5)
    settlements = np.array([-result.history.displacements[:, 0, 1] for result in results])
    assert settlements == pytest.approx(1.0 - np.exp(-_point("oedometer")), abs=1.0e-4)


def test_weight_adds_what_half_the_height_of_soil_weighs() -> None:
    """With its own weight a specimen settles as a point at its mean stress, but for the curvature over its height."""
    weight = 18.0
    soil = soft_soil_creep(0.10, 0.02, 0.005, 0.0, 30.0, K0nc=0.5)
    mesh = block(np.array([0.0, 1.0]), graded(0.0, 1.0, 8))
    phases = [
        Phase(
            "start",
            "K0",
            materials={"soil": creeping(soil, weight, OCR=1.3)},
            surcharge=50.0,
            fixities=(Fixity("left", x=0.0), Fixity("right", x=0.0), Fixity("bottom", y=0.0)),
        ),
        Phase("load", "creep", duration=1.0, tractions=(Traction("top", normal=-100.0),), output_times=(1.0,)),
    ]
    result = solve_phases(
        mesh, phases, geometry="axisymmetric", observe=[node_at(mesh, 0.0, 1.0)], control=Control(time_tolerance=1e-4)
    )[-1]
    settlement = -float(result.history.displacements[-1, 0, 1])
    depths = (np.arange(40) + 0.5) / 40
    column = 0.0
    for depth in depths:
        own = weight * depth
        start = creep_point([0.5 * (50.0 + own), 0.5 * (50.0 + own), 50.0 + own, 0, 0, 0], soil, OCR=1.3)
        history = follow(creep_law(soil), start, [confined_load(100.0 + own, 1.0)], [[1.0]])
        column += float(history.strain[-1, 2]) / depths.size
    assert settlement == pytest.approx(column, rel=1.0e-3)
    assert settlement < 0.99 * 0.048785
