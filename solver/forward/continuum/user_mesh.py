"""A mesh of the user in a problem file: the name of a file beside it, or the mesh itself as tables."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from geoswarm.solver.errors import Issue, MeshError, ProblemError
from geoswarm.solver.fem.mesh.columns import MAX_ELEMENTS
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.mesh.reading import mesh_of_tables, read_mesh
from geoswarm.solver.forward.continuum.geometry import Name

__all__ = ["MeshSection"]


class MeshSection(BaseModel):
    """A mesh of triangles: from a file, or as tables (which is what becomes of the file in a submitted problem)."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    file: str | None = Field(
        None,
        max_length=1000,
        description="File next to the problem file, of gmsh (.msh) or another program that meshio reads.",
    )
    scale: float = Field(1.0, gt=0.0, description="Length of the file's unit, m.")
    interfaces: list[Name] = Field(default=[], max_length=50, description="Lines along which the body is opened.")
    nodes: list[tuple[float, float]] | None = Field(
        None, max_length=3 * MAX_ELEMENTS, description="x and y of each node, m."
    )
    triangles: list[list[int]] | None = Field(
        None, max_length=MAX_ELEMENTS, description="3 or 6 nodes of each triangle, counted from 0."
    )
    regions: dict[Name, list[int]] | None = Field(None, description="Triangles of each region, counted from 0.")
    lines: dict[Name, list[Annotated[list[int], Field(min_length=2, max_length=2)]]] = Field(
        default={}, description="Edges of each boundary and interface: two corners."
    )
    named_nodes: dict[Name, int] = Field(default={}, description="Nodes with a name.")

    @model_validator(mode="after")
    def _one_source(self) -> MeshSection:
        tables = [self.nodes, self.triangles, self.regions]
        if self.file is not None and any(table is not None for table in tables):
            raise ValueError("a file and tables are both given; give only one of them")
        if self.file is None and any(table is None for table in tables):
            raise ValueError("give a file, or all of nodes, triangles and regions")
        return self

    def with_tables(self, folder: Path | None, path: str) -> MeshSection:
        """The same mesh as tables, its file read.

        Parameters
        ----------
        folder
            Where relative files lie; None when no file may be read.
        path
            Of this section in the problem.

        Raises
        ------
        ProblemError
            A file may not be read, or is not a sound mesh.
        """
        if self.file is None:
            return self
        if folder is None:
            message = "files can only be read beside a problem file; give nodes, triangles and regions themselves"
            raise ProblemError([Issue(f"{path}.file", message)])
        try:
            mesh = read_mesh(folder / self.file, scale=self.scale, keep_lines=True)
        except MeshError as error:
            raise ProblemError([Issue(f"{path}.file", str(error))]) from error
        return MeshSection.model_validate({"interfaces": self.interfaces, **_tables(mesh)})

    def mesh(self) -> Mesh:
        """Build the mesh of the tables.

        Raises
        ------
        MeshError
            It is not sound, or its file has not been read.
        """
        if self.nodes is None or self.triangles is None or self.regions is None:
            raise MeshError(f"file {self.file} has not been read; load the problem from its file")
        names: list[str | None] = [None] * len(self.triangles)
        for name, members in self.regions.items():
            for triangle in members:
                if not 0 <= triangle < len(names):
                    raise MeshError(f"region {name}: triangle {triangle} does not exist; 0 to {len(names) - 1} do")
                names[triangle] = name
        if None in names:
            raise MeshError(f"triangle {names.index(None)} belongs to no region")
        widths = {len(nodes) for nodes in self.triangles}
        if widths not in ({3}, {6}):
            raise MeshError("all triangles must have 3 nodes, or all 6")
        return mesh_of_tables(
            np.array(self.nodes, dtype=np.float64),
            np.array(self.triangles, dtype=np.int64),
            [str(name) for name in names],
            self.lines,
            self.named_nodes,
            self.interfaces,
        )


def _tables(mesh: Mesh) -> dict[str, Any]:
    return {
        "nodes": [tuple(node) for node in mesh.nodes.tolist()],
        "triangles": mesh.triangles.tolist(),
        "regions": {
            name: np.flatnonzero(mesh.regions == number).tolist() for number, name in enumerate(mesh.region_names)
        },
        "lines": {name: edges[:, :2].tolist() for name, edges in mesh.boundaries.items()},
        "named_nodes": mesh.points,
    }
