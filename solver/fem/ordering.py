"""The order of elimination: nested dissection of the elements, and the tree of frontal matrices that follows from it.

The elements are halved at the median of their centres, again and again. The nodes that two halves share separate them:
they are eliminated after both. Every set of nodes that is eliminated together has a front, a dense matrix over these
nodes (pivots) and over the later ones that they are coupled with (rest).
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from solver.arrays import FloatArray, IntArray
from solver.fem.mesh.mesh import IndexArray

__all__ = ["Fronts", "plan_fronts"]

_LEAF: Final = 8
"""Elements that are not halved any more."""


class Fronts(NamedTuple):
    """Static structure of the frontal matrices, in the order of their elimination; row-major in one buffer.

    ``offset`` (f,) place in the buffer, ``size`` (f,) rows, ``pivots`` (f,) rows that are eliminated here, ``start``
    (f + 1,) into ``rows``, the dofs of each front; ``parent`` (f,), -1 at a root; ``place``, parallel to ``rows``, row
    of the parent for those that are not eliminated here. ``element_front`` (e,) and ``element_node`` (e, 6): front of
    an element and the numbers of its nodes there; ``diagonal`` (dofs,) place of each pivot in the buffer.
    """

    offset: IntArray
    size: IntArray
    pivots: IntArray
    start: IntArray
    rows: IntArray
    parent: IntArray
    place: IntArray
    element_front: IntArray
    element_node: IntArray
    diagonal: IntArray

    @property
    def length(self) -> int:
        """Numbers in the buffer."""
        return int(self.offset[-1] + self.size[-1] ** 2)


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
    offset = np.concatenate([[0], np.cumsum(size**2)[:-1]])
    eliminated = np.array([2 * own.size for own in pivots], dtype=np.int64)
    diagonal = np.empty(2 * nodes, dtype=np.int64)
    for front in range(count):
        own_rows = np.arange(eliminated[front])
        diagonal[rows[front][: eliminated[front]]] = offset[front] + own_rows * (size[front] + 1)
    return Fronts(
        offset,
        size,
        eliminated,
        np.concatenate([[0], np.cumsum(size)]),
        np.concatenate(rows),
        np.array(parent, dtype=np.int64),
        np.concatenate(places),
        element_front,
        element_node,
        diagonal,
    )


def _dissect(elements: IndexArray, centres: FloatArray, nodes: int) -> tuple[list[IntArray], list[int]]:
    """Pivots of each front and its parent, children before parents."""
    pivots: list[IntArray] = []
    parent: list[int] = []
    done = np.zeros(nodes, dtype=np.bool_)
    mark = np.zeros(nodes, dtype=np.bool_)

    def divide(part: IntArray) -> list[int]:
        """Eliminate what belongs to these elements alone; the fronts that have no parent yet."""
        inside = elements[part]
        if part.size <= _LEAF:
            own = np.unique(inside)
            own = own[~done[own]]
            return [_append(own)] if own.size else []
        points = centres[part]
        across = np.argmax(np.ptp(points, axis=0))
        order = np.argsort(points[:, across], kind="stable")
        left, right = part[order[: part.size // 2]], part[order[part.size // 2 :]]
        beyond = elements[right].ravel()
        mark[beyond] = True
        shared = np.unique(elements[left])
        shared = shared[mark[shared] & ~done[shared]]
        mark[beyond] = False
        done[shared] = True
        roots = divide(left) + divide(right)
        if not shared.size:
            return roots
        front = _append(shared)
        for root in roots:
            parent[root] = front
        return [front]

    def _append(own: IndexArray) -> int:
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
