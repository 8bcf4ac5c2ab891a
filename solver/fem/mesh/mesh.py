"""The mesh that the solver works on: six-node triangles, interfaces, and the names by which users speak of them."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from geoswarm.solver.arrays import FloatArray

__all__ = ["IndexArray", "Mesh"]

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
