"""A laboratory specimen as a boundary value problem: a cylinder of six-node triangles in axisymmetry.

The published calculations took two triangles and the specimen's own weight as its initial stress. Without weight the
state is the same everywhere, and the results are those of one material point.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.fem.materials import Material
from geoswarm.solver.fem.mesh.cross_section import Layer, Profile, SectionGeometry
from geoswarm.solver.fem.mesh.layered import LayeredMesh
from geoswarm.solver.fem.mesh.mesh import IndexArray, Mesh
from geoswarm.solver.fem.phases import Control, Fixity, Phase, Traction
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.solver.laws.base import Soil

__all__ = ["StagedSpecimen", "specimen_mesh"]

_SOIL = "soil"


def specimen_mesh(radius: float, height: float, columns: int, rows: int) -> Mesh:
    """Mesh of half a section through a cylinder; nodes of its top and side are points ``top0``, ``side0`` ..."""
    surface = Profile(np.array([0.0, radius]), np.full(2, height))
    layer = Layer(_SOIL, rows, thickness=Profile(np.zeros(1), np.array([height])))
    mesh = LayeredMesh.plan(
        SectionGeometry(surface, (layer,)), Profile(np.zeros(1), np.array([radius / columns]))
    ).nominal
    points = {
        f"{name}{number}": node
        for name, edges in (("top", mesh.boundaries["surface"]), ("side", mesh.boundaries["right"]))
        for number, node in enumerate(edges.ravel().tolist())
    }
    return replace(mesh, points=points)


@dataclass(frozen=True)
class StagedSpecimen:
    """A specimen under constant loads in stages.

    Parameters
    ----------
    mesh
        From :func:`specimen_mesh`.
    height, radius
        m.
    confined
        A ring holds the side; otherwise the load acts on it too.
    initial_stress
        Vertical stress at the top before the first stage, kPa, compression positive.
    unit_weight
        kN/m3.
    updated
        Large deformations, with logarithmic strain; otherwise small strain.
    control
        Accuracy.
    """

    mesh: Mesh
    height: float
    radius: float
    confined: bool
    initial_stress: float
    unit_weight: float
    updated: bool
    control: Control

    def history(
        self,
        soil: Soil,
        lateral_ratio: float,
        loads: FloatArray,
        durations: FloatArray,
        times: FloatArray,
        firsts: IntArray,
    ) -> tuple[FloatArray, FloatArray]:
        """Calculate axial and lateral strain, compression positive, as :func:`constant_load_history` does.

        Parameters
        ----------
        lateral_ratio
            Initial ratio of horizontal to vertical stress.
        loads, durations
            (s,): kPa and day.
        times, firsts
            (n,), (s + 1,): when to record, day since the beginning of the stage, and the first of each stage.

        Returns
        -------
        At the times (n, 2) and at the ends of the stages (s, 2), means over top and side; logarithmic if updated.

        Raises
        ------
        DivergedError
            No solution was found.
        """
        material = Material(soil, self.unit_weight, lateral_ratio)
        sides = (Fixity("left", x=0.0), Fixity("bottom", y=0.0))
        phases = [
            Phase(
                "initial",
                "K0",
                materials={_SOIL: material},
                fixities=(*sides, Fixity("right", x=0.0)) if self.confined else sides,
                surcharge=self.initial_stress,
            )
        ]
        for stage, (load, duration) in enumerate(zip(loads.tolist(), durations.tolist(), strict=True)):
            loaded = ("surface",) if self.confined else ("surface", "right")
            phases.append(
                Phase(
                    f"stage {stage + 1}",
                    "creep",
                    tractions=tuple(Traction(name, normal=-load, follower=self.updated) for name in loaded),
                    duration=duration,
                    updated_mesh=self.updated,
                    output_times=(*times[firsts[stage] : firsts[stage + 1]].tolist(), duration),
                )
            )
        results = solve_phases(
            self.mesh, phases, geometry="axisymmetric", observe=tuple(self.mesh.points), control=self.control
        )
        recorded = []
        for stage, result in enumerate(results[1:]):
            wanted = np.append(times[firsts[stage] : firsts[stage + 1]], durations[stage])
            rows = [int(np.argmin(np.abs(result.history.times - time))) for time in wanted]
            recorded.append(self._strain(result.history.displacements[rows]))
        ends = np.array([strain[-1] for strain in recorded])
        return np.concatenate([strain[:-1] for strain in recorded]), ends

    def _strain(self, displacements: FloatArray) -> FloatArray:
        """Axial and lateral strain of the whole specimen from displacements of the points (m, k, 2)."""
        top = _mean(self.mesh, "surface", displacements, 0, 1, weighted_by_radius=True)
        side = _mean(self.mesh, "right", displacements, len(self.mesh.boundaries["surface"]), 0)
        stretch = np.stack([1.0 + top / self.height, 1.0 + side / self.radius], axis=1)
        return -np.log(stretch) if self.updated else 1.0 - stretch


def _mean(
    mesh: Mesh, boundary: str, displacements: FloatArray, first: int, axis: int, weighted_by_radius: bool = False
) -> FloatArray:
    """Mean of a displacement over a boundary by Simpson's rule; over its area where weighted by the radius."""
    edges: IndexArray = mesh.boundaries[boundary]
    values = displacements[:, 3 * first : 3 * (first + len(edges)), axis].reshape(len(displacements), -1, 3)
    ends = mesh.nodes[edges]
    weights = np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1)[:, None] * np.array([1.0, 1.0, 4.0]) / 6.0
    if weighted_by_radius:
        weights = weights * ends[:, :, 0]
    mean: FloatArray = np.sum(values * weights, axis=(1, 2)) / weights.sum()
    return mean
