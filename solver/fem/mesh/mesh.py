"""The mesh that the solver works on: six-node triangles, interfaces, and the names by which users speak of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geoswarm.solver.arrays import FloatArray

__all__ = ["EDGES", "IndexArray", "Mesh", "boundary_edges", "midpoints", "six_node_triangles"]

IndexArray: TypeAlias = NDArray[np.int32]


def _no_interfaces() -> IndexArray:
    return np.empty((0, 6), dtype=np.int32)


def _no_regions() -> IndexArray:
    return np.empty(0, dtype=np.int32)


@dataclass(frozen=True)
class Mesh:
    """Six-node triangles with named regions, interfaces, boundaries and points.

    Parameters
    ----------
    nodes
        (n, 2), m: x and y, or in axisymmetry radius and height.
    triangles
        (e, 6): corners 0, 1, 2 counter-clockwise, then the mid-sides of 01, 12 and 20.
    regions
        (e,): index into ``region_names`` of each triangle.
    region_names
        Names of the regions, each once.
    interfaces
        (k, 6): start, end and mid node of side A, then of side B. Both sides run in the same direction and have equal
        coordinates pairwise; side A is on the left of the direction from start to end.
    interface_regions
        (k,): index into ``interface_names`` of each interface.
    interface_names
        Names of the interfaces, each once; none is the name of a region.
    boundaries
        By name, edges (m, 3): start, end, mid; the body is on the left.
    points
        Named nodes.
    """

    nodes: FloatArray
    triangles: IndexArray
    regions: IndexArray
    region_names: tuple[str, ...]
    interfaces: IndexArray = field(default_factory=_no_interfaces)
    interface_regions: IndexArray = field(default_factory=_no_regions)
    interface_names: tuple[str, ...] = ()
    boundaries: dict[str, IndexArray] = field(default_factory=dict)
    points: dict[str, int] = field(default_factory=dict)


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
