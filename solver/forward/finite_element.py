"""A plane body on the user's own mesh of triangles."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from geoswarm.solver.errors import Issue, MeshError, ProblemError
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.continuum.body import BodySections, check_names
from geoswarm.solver.forward.continuum.geometry import Name
from geoswarm.solver.forward.continuum.model import BodyModel
from geoswarm.solver.forward.continuum.user_mesh import MeshSection

__all__ = ["FiniteElementModel", "FiniteElementSpec"]


class FiniteElementSpec(BodySections, ForwardModelSpec):
    """A body on a mesh of the user, with finite elements in plane strain.

    Series: ``A.ux`` and ``A.uy`` over time for every point A (m; x to the right, y upwards), and ``gps.ux`` and
    ``gps.uy`` over the number of the point for every entry ``gps`` of ``vectors``.
    """

    kind: Literal["finite_element"] = "finite_element"
    mesh: MeshSection = Field(description="The mesh.")
    points: dict[Name, tuple[float, float]] = Field(
        default={}, max_length=200, description="Observation points: x and y, m; the nearest node is taken."
    )

    @classmethod
    def example(cls) -> dict[str, Any]:
        """A block of clay of two triangles."""
        return {
            "kind": "finite_element",
            "mesh": {
                "nodes": [[0, 0], [2, 0], [2, 1], [0, 1]],
                "triangles": [[0, 1, 2], [0, 2, 3]],
                "regions": {"clay": [0, 1]},
                "lines": {"base": [[0, 1]]},
            },
            "points": {"A": [2, 1]},
            "fixities": {"base": "both"},
            "materials": {"soil": {"law": "elastic", "E": "E", "nu": 0.3, "unit_weight": 20}},
            "phases": [{"name": "weight", "kind": "gravity", "materials": {"clay": "soil"}}],
        }

    def with_files(self, folder: Path | None, path: str) -> FiniteElementSpec:
        """The section with the mesh itself instead of the name of its file, and what is known of libraries."""
        found = super().with_files(folder, path)
        mesh = found.mesh.with_tables(folder, f"{path}.mesh")
        return found if mesh is found.mesh else found.model_copy(update={"mesh": mesh})

    def build(self) -> FiniteElementModel:
        """Build the forward model."""
        return FiniteElementModel(self)


class FiniteElementModel(BodyModel):
    """Forward model of a body on the user's mesh."""

    def __init__(self, spec: FiniteElementSpec) -> None:
        super().__init__(spec)
        try:
            mesh = spec.mesh.mesh()
        except MeshError as error:
            raise ProblemError([Issue("forward_model.mesh", str(error))]) from error
        points = {**mesh.points, **{name: _nearest(mesh, name, place) for name, place in spec.points.items()}}
        if not points:
            text = "no point is named; name at least one, whose displacement is observed"
            raise ProblemError([Issue("forward_model.points", text)])
        self._mesh = replace(mesh, points=points)
        check_names(spec, self._mesh)

    @property
    def nominal(self) -> Mesh:
        """The mesh."""
        return self._mesh

    def mesh(self, values: Mapping[str, float]) -> Mesh:
        """The mesh, whatever the parameters."""
        del values
        return self._mesh


def _nearest(mesh: Mesh, name: str, place: tuple[float, float]) -> int:
    distance = np.linalg.norm(mesh.nodes - np.array(place), axis=1)
    node = int(np.argmin(distance))
    corners = mesh.nodes[mesh.triangles[(mesh.triangles == node).any(axis=1), :3]]
    size = float(np.ptp(corners, axis=1).max())
    if distance[node] > size:
        x, y = mesh.nodes[node].tolist()
        text = f"({place[0]:g}, {place[1]:g}) lies outside the mesh; the nearest node is at ({x:g}, {y:g})"
        raise ProblemError([Issue(f"forward_model.points.{name}", text)])
    return node
