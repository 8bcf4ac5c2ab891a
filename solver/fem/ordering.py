"""The order of elimination: nested dissection of the elements, and the tree of frontal matrices that follows from it.

The elements are halved near the median of their centres, where the halves share the fewest nodes, again and again.
These nodes separate the halves: they are eliminated after both. Every set of nodes that is eliminated together has a
front, a dense matrix over these nodes (pivots) and over the later ones that they are coupled with (rest).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.fem.mesh.mesh import IndexArray

__all__ = ["Fronts", "plan_fronts"]

_LEAF: Final = 8
"""Elements that are not halved any more."""

_NEAR: Final = 0.1
_CUTS: Final = 8
_SQUARE: Final = 0.5
"""Cuts that are tried: the widest gaps between centres, up to this share of the elements from the median, across the
longer direction and, if it is at least this share of the longer one, across the shorter."""


class Fronts(NamedTuple):
    """Static structure of the frontal matrices; every subtree is complete before the next one begins.

    ``size`` (f,) rows, ``pivots`` (f,) rows that are eliminated here, ``start`` (f + 1,) into ``rows``, the dofs of
    each front; ``parent`` (f,), -1 at a root; ``place``, parallel to ``rows``, row of the parent for those that are
    not eliminated here; ``first_element`` (f + 1,) into ``elements``, those that are assembled here, and
    ``element_node`` (e, 6) the numbers of an element's nodes there; ``room`` (f,) place in the workspace, which the
    fronts of one level of the tree share; ``factor`` (f + 1,) place in the buffer of factors.
    """

    size: IntArray
    pivots: IntArray
    start: IntArray
    rows: IntArray
    parent: IntArray
    place: IntArray
    first_element: IntArray
    elements: IntArray
    element_node: IntArray
    room: IntArray
    factor: IntArray


def plan_fronts(elements: IndexArray, centres: FloatArray, nodes: int) -> Fronts:
    """Plan the fronts of a mesh.

    Parameters
    ----------
    elements
        (e, 6): nodes of triangles and interfaces; every node belongs to one.
    centres
        (e, 2).
    nodes
        Number of nodes.
    """
    pivots, parent = _dissect(elements, centres, nodes)
    count = len(pivots)
    owner = np.empty(nodes, dtype=np.int64)
    for front, own in enumerate(pivots):
        owner[own] = front
    element_front = owner[elements].min(axis=1)
    by_front = np.argsort(element_front, kind="stable")
    bounds = np.searchsorted(element_front[by_front], np.arange(count + 1))
    rest: list[IntArray] = []
    children: list[list[IntArray]] = [[] for _ in range(count)]
    for front in range(count):
        touched = elements[by_front[bounds[front] : bounds[front + 1]]].ravel()
        later = np.unique(np.concatenate([touched, *children[front]]))
        later = later[owner[later] > front]
        rest.append(later)
        if parent[front] >= 0:
            children[parent[front]].append(later)
    element_node = np.empty(elements.shape, dtype=np.int64)
    position = np.empty(nodes, dtype=np.int64)
    rows, places, sizes = [], [], []
    all_nodes = [np.concatenate([pivots[front], rest[front]]).astype(np.int64) for front in range(count)]
    for front in range(count):
        mine = all_nodes[front]
        position[mine] = np.arange(mine.size)
        own = by_front[bounds[front] : bounds[front + 1]]
        element_node[own] = position[elements[own]]
        sizes.append(2 * mine.size)
        rows.append(_dofs(mine))
        place = np.full(mine.size, -1, dtype=np.int64)
        if parent[front] >= 0:
            position[all_nodes[parent[front]]] = np.arange(all_nodes[parent[front]].size)
            place[pivots[front].size :] = position[rest[front]]
        pairs = np.repeat(2 * place, 2)
        pairs[1::2] += 1
        places.append(pairs)
    size = np.array(sizes, dtype=np.int64)
    eliminated = np.array([2 * own.size for own in pivots], dtype=np.int64)
    level = np.zeros(count, dtype=np.int64)
    for front in range(count - 1, -1, -1):
        level[front] = level[parent[front]] + 1 if parent[front] >= 0 else 0
    largest = np.zeros(level.max() + 1, dtype=np.int64)
    np.maximum.at(largest, level, size)
    return Fronts(
        size,
        eliminated,
        np.concatenate([[0], np.cumsum(size)]),
        np.concatenate(rows),
        np.array(parent, dtype=np.int64),
        np.concatenate(places),
        bounds,
        by_front,
        element_node,
        np.concatenate([[0], np.cumsum(largest**2)])[level],
        np.concatenate([[0], np.cumsum(2 * eliminated * size)]),
    )


def _dissect(elements: IndexArray, centres: FloatArray, nodes: int) -> tuple[list[IntArray], list[int]]:
    """Pivots of each front and its parent, children before parents."""
    pivots: list[IntArray] = []
    parent: list[int] = []
    done = np.zeros(nodes, dtype=np.bool_)
    mark = np.zeros(nodes, dtype=np.bool_)

    def between(left: IntArray, right: IntArray) -> IntArray:
        """Nodes that two parts share and that are not eliminated yet."""
        beyond = elements[right].ravel()
        mark[beyond] = True
        inside = elements[left].ravel()
        shared = inside[mark[inside] & ~done[inside]]
        mark[beyond] = False
        return np.unique(shared)

    def halved(part: IntArray) -> tuple[IntArray, IntArray, IntArray]:
        """Two parts of about equal size and the nodes between them: the fewest of some cuts."""
        points = centres[part]
        extent = np.ptp(points, axis=0)
        cuts: list[tuple[float, IntArray, IntArray, IntArray]] = []
        for axis in np.flatnonzero(extent >= _SQUARE * extent.max()):
            order = np.argsort(points[:, axis], kind="stable")
            near = np.arange(int((0.5 - _NEAR) * part.size), int((0.5 + _NEAR) * part.size)) + 1
            gaps = np.diff(points[order, axis])[near - 1]
            for cut in sorted({part.size // 2, *near[np.argsort(-gaps, kind="stable")[:_CUTS]].tolist()}):
                left, right = part[order[:cut]], part[order[cut:]]
                shared = between(left, right)
                cuts.append((shared.size * (1.0 + abs(cut / part.size - 0.5)), left, right, shared))
        return min(cuts, key=lambda one: one[0])[1:]

    def divide(part: IntArray) -> list[int]:
        """Eliminate what belongs to these elements alone; the fronts that have no parent yet."""
        inside = elements[part]
        if part.size <= _LEAF:
            own = np.unique(inside)
            own = own[~done[own]]
            return [_append(own)] if own.size else []
        left, right, shared = halved(part)
        done[shared] = True
        roots = divide(left) + divide(right)
        if not shared.size:
            return roots
        front = _append(shared)
        for root in roots:
            parent[root] = front
        return [front]

    def _append(own: IndexArray | IntArray) -> int:
        done[own] = True
        pivots.append(own.astype(np.int64))
        parent.append(-1)
        return len(pivots) - 1

    divide(np.arange(elements.shape[0]))
    return pivots, parent


def _dofs(nodes: IntArray) -> IntArray:
    pairs: IntArray = np.repeat(2 * nodes, 2)
    pairs[1::2] += 1
    return pairs
