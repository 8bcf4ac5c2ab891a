"""Six-node triangles from triangles of three corners: one mid-side node an edge, halfway."""

from __future__ import annotations

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.mesh.mesh import IndexArray

__all__ = ["EDGES", "boundary_edges", "midpoints", "six_node_triangles"]

EDGES = ((0, 1, 3), (1, 2, 4), (2, 0, 5))
"""Start, end and mid of each edge of a six-node triangle; the triangle is on the left."""


def six_node_triangles(corners: IndexArray, corner_count: int) -> tuple[IndexArray, IndexArray]:
    """Number the mid-side nodes of a mesh of three-node triangles.

    Parameters
    ----------
    corners
        (e, 3): corners of each triangle, counter-clockwise.
    corner_count
        Number n of corner nodes; mid-side nodes are numbered from n.

    Returns
    -------
    triangles
        (e, 6).
    ends
        (m, 2): the two corners between which each mid-side node lies.
    """
    pairs = np.concatenate([corners[:, [start, end]] for start, end, _ in EDGES])
    ends, number = np.unique(np.sort(pairs, axis=1), axis=0, return_inverse=True)
    mids = corner_count + number.reshape(3, -1).T
    return np.concatenate([corners, mids], axis=1).astype(np.int32), ends.astype(np.int32)


def midpoints(nodes: FloatArray, ends: IndexArray) -> FloatArray:
    """Halfway points (m, 2) of pairs of corners."""
    return 0.5 * (nodes[ends[:, 0]] + nodes[ends[:, 1]])


def boundary_edges(triangles: IndexArray) -> IndexArray:
    """Edges (m, 3) that belong to one triangle only: start, end, mid, the body on the left."""
    edges = np.concatenate([triangles[:, list(edge)] for edge in EDGES])
    _, first, count = np.unique(np.sort(edges[:, :2], axis=1), axis=0, return_index=True, return_counts=True)
    found: IndexArray = edges[np.sort(first[count == 1])]
    return found
