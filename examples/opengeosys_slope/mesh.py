"""Writes the meshes of this example: that of own_elements.yaml, six-node triangles, and its held sides, as VTU in text.

Only needed to change them; they are kept beside it. Needs geoswarm's extra ``mesh``.
"""

from __future__ import annotations

from pathlib import Path

import meshio
import numpy as np

from geoswarm.solver.forward.cross_section import SectionModel
from geoswarm.solver.problem import load_problem

HERE = Path(__file__).resolve().parent


def main(folder: Path) -> None:
    """Write all four into a folder."""
    model = load_problem(HERE / "own_elements.yaml").model
    assert isinstance(model, SectionModel)
    mesh = model.nominal
    points = np.column_stack([mesh.nodes, np.zeros(len(mesh.nodes))])
    whole = meshio.Mesh(points, [("triangle6", mesh.triangles.astype(np.int64))])
    whole.write(folder / "slope.vtu", file_format="vtu", binary=False)
    for side in ("left", "right", "bottom"):
        edges = mesh.boundaries[side]
        nodes, own = np.unique(edges, return_inverse=True)
        elements = [int(np.flatnonzero((mesh.triangles == edge[2]).any(axis=1))[0]) for edge in edges]
        part = meshio.Mesh(
            points[nodes],
            [("line3", own.reshape(edges.shape).astype(np.int64))],
            point_data={"bulk_node_ids": nodes.astype(np.uint64)},
            cell_data={"bulk_element_ids": [np.array(elements, dtype=np.uint64)]},
        )
        part.write(folder / f"{side}.vtu", file_format="vtu", binary=False)


if __name__ == "__main__":
    main(HERE)
