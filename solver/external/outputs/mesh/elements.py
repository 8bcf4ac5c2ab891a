"""Shape functions of the elements that result files have, and where in an element a point lies.

The nodes are in the order of VTK (the linear wedge in that of meshio). Shape functions are combinations of monomials
that are 1 in one node and 0 in the others, so that an element is a table of nodes and one of exponents.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from itertools import product

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["ELEMENTS", "Element", "element"]

_NEWTON_STEPS = 30
_LINE = [(-1.0,), (1.0,), (0.0,)]
_TRIANGLE = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (0.5, 0.0), (0.5, 0.5), (0.0, 0.5)]
_QUAD = [
    (-1.0, -1.0),
    (1.0, -1.0),
    (1.0, 1.0),
    (-1.0, 1.0),
    (0.0, -1.0),
    (1.0, 0.0),
    (0.0, 1.0),
    (-1.0, 0.0),
    (0.0, 0.0),
]
_TETRA = [(0.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)]
_TETRA_EDGES = [(0, 1), (1, 2), (2, 0), (0, 3), (1, 3), (2, 3)]
_HEX = [(x, y, z) for z in (-1.0, 1.0) for x, y in _QUAD[:4]]
_HEX_EDGES = [(0, 1), (1, 2), (2, 3), (3, 0), (4, 5), (5, 6), (6, 7), (7, 4), (0, 4), (1, 5), (2, 6), (3, 7)]
_HEX_FACES = [(-1.0, 0.0, 0.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (0.0, 0.0, 1.0)]
_WEDGE = [(x, y, z) for z in (-1.0, 1.0) for x, y in _TRIANGLE[:3]]
_WEDGE_EDGES = [(0, 1), (1, 2), (2, 0), (3, 4), (4, 5), (5, 3), (0, 3), (1, 4), (2, 5)]
_PYRAMID = [(-1.0, -1.0, 0.0), (1.0, -1.0, 0.0), (1.0, 1.0, 0.0), (-1.0, 1.0, 0.0), (0.0, 0.0, 1.0)]


def _with_middles(corners: list[tuple[float, ...]], edges: list[tuple[int, int]]) -> list[tuple[float, ...]]:
    middles = [tuple((a + b) / 2 for a, b in zip(corners[i], corners[j], strict=True)) for i, j in edges]
    return [*corners, *middles]


def _up_to(degree: int, dimension: int, total: int) -> list[tuple[int, ...]]:
    """Exponents up to a degree in each direction and a degree in all."""
    return [powers for powers in product(range(degree + 1), repeat=dimension) if sum(powers) <= total]


def _serendipity(dimension: int) -> list[tuple[int, ...]]:
    """Exponents of which at most one is 2: the elements with a node in the middle of each edge and none elsewhere."""
    return [powers for powers in product(range(3), repeat=dimension) if powers.count(2) <= 1]


_WEDGE_15: list[tuple[int, ...]] = [
    *((i, j, k) for i, j in _up_to(2, 2, 2) for k in range(2)),
    *((0, 0, 2), (1, 0, 2), (0, 1, 2)),
]

# By the name in meshio: what it is bounded by, its nodes, and its exponents. The pyramid's last monomial is x y / (1
# - z).
ELEMENTS: dict[str, tuple[str, list[tuple[float, ...]], list[tuple[int, ...]]]] = {
    "line": ("box", [*_LINE[:2]], _up_to(1, 1, 1)),
    "line3": ("box", [*_LINE], _up_to(2, 1, 2)),
    "triangle": ("simplex", [*_TRIANGLE[:3]], _up_to(1, 2, 1)),
    "triangle6": ("simplex", [*_TRIANGLE], _up_to(2, 2, 2)),
    "quad": ("box", [*_QUAD[:4]], _up_to(1, 2, 2)),
    "quad8": ("box", [*_QUAD[:8]], _serendipity(2)),
    "quad9": ("box", [*_QUAD], _up_to(2, 2, 4)),
    "tetra": ("simplex", [*_TETRA], _up_to(1, 3, 1)),
    "tetra10": ("simplex", _with_middles([*_TETRA], _TETRA_EDGES), _up_to(2, 3, 2)),
    "hexahedron": ("box", [*_HEX], _up_to(1, 3, 3)),
    "hexahedron20": ("box", _with_middles([*_HEX], _HEX_EDGES), _serendipity(3)),
    "hexahedron27": (
        "box",
        [*_with_middles([*_HEX], _HEX_EDGES), *_HEX_FACES, (0.0, 0.0, 0.0)],
        _up_to(2, 3, 6),
    ),
    "wedge": ("wedge", [*_WEDGE], [(i, j, k) for i, j in _up_to(1, 2, 1) for k in range(2)]),
    "wedge15": ("wedge", _with_middles([*_WEDGE], _WEDGE_EDGES), _WEDGE_15),
    "pyramid": ("pyramid", [*_PYRAMID], [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1), (1, 1, -1)]),
}


@dataclass(frozen=True, eq=False)
class Element:
    """One type of element.

    Parameters
    ----------
    nodes
        Reference coordinates, shape (n, d).
    powers
        Exponents of the monomials, shape (n, d); a negative one in the third direction is of 1 - z.
    combinations
        Shape function j is the sum of monomial i times ``combinations[i, j]``, shape (n, n).
    """

    bounds: str
    nodes: FloatArray
    powers: FloatArray
    combinations: FloatArray

    @property
    def dimension(self) -> int:
        """Of the element itself: 1, 2 or 3."""
        return int(self.nodes.shape[1])

    def shape(self, at: FloatArray) -> FloatArray:
        """Shape functions, (n,), at a reference point, (d,)."""
        return _monomials(at, self.powers) @ self.combinations

    def gradient(self, at: FloatArray) -> FloatArray:
        """Derivatives of the shape functions, (d, n), at a reference point, (d,)."""
        return np.stack([_derived(at, self.powers, axis) @ self.combinations for axis in range(self.dimension)])

    def locate(self, corners: FloatArray, point: FloatArray) -> tuple[FloatArray, float]:
        """Find a point in an element by Newton's method.

        Parameters
        ----------
        corners
            Coordinates of the nodes, (n, s); s is d or more, as for a shell in space.
        point
            (s,).

        Returns ------- Shape functions at the point, (n,), and how far it lies outside: the most by which a bound is
        passed, in reference coordinates, or the distance from the element's surface in relation to its size; 0 or less
        inside.
        """
        at = self.nodes.mean(axis=0)
        size = float(np.ptp(corners, axis=0).max())
        if size == 0.0:
            return self.shape(at), np.inf
        for _ in range(_NEWTON_STEPS):
            rest = point - self.shape(at) @ corners
            step = np.linalg.lstsq((self.gradient(at) @ corners).T, rest, rcond=None)[0]
            at = np.clip(at + step, -5.0, 5.0)
            if float(np.abs(step).max()) < 1e-13:
                break
        shape = self.shape(at)
        off = float(np.abs(point - shape @ corners).max()) / size
        outside = _outside(self.bounds, at)
        return shape, max(outside, off) if off > 1e-9 else outside


@cache
def element(name: str) -> Element | None:
    """Return a type of element by its name in meshio; None for types that are not known."""
    if name not in ELEMENTS:
        return None
    bounds, nodes, powers = ELEMENTS[name]
    points, exponents = np.array(nodes, dtype=np.float64), np.array(powers, dtype=np.float64)
    matrix = np.stack([_monomials(point, exponents) for point in points])
    return Element(bounds, points, exponents, np.linalg.inv(matrix).astype(np.float64))


def _monomials(at: FloatArray, powers: FloatArray) -> FloatArray:
    values = np.prod(at ** np.maximum(powers, 0.0), axis=1)
    negative = powers.min(axis=1) < 0.0
    if negative.any():
        values[negative] /= _below_top(at)
    return np.asarray(values, dtype=np.float64)


def _derived(at: FloatArray, powers: FloatArray, axis: int) -> FloatArray:
    lowered = powers.copy()
    lowered[:, axis] -= 1.0
    factors = np.maximum(powers[:, axis], 0.0)
    values = factors * np.prod(at ** np.maximum(lowered, 0.0), axis=1)
    negative = powers.min(axis=1) < 0.0
    if negative.any():
        top = _below_top(at)
        values[negative] = at[0] * at[1] / top**2 if axis == 2 else values[negative] / top
    return np.asarray(values, dtype=np.float64)


def _below_top(at: FloatArray) -> float:
    top = 1.0 - float(at[2])
    return top if abs(top) > 1e-12 else 1e-12


def _outside(bounds: str, at: FloatArray) -> float:
    if bounds == "box":
        return float(np.abs(at).max()) - 1.0
    if bounds == "simplex":
        return max(float(-at.min()), float(at.sum()) - 1.0)
    if bounds == "wedge":
        return max(float(-at[:2].min()), float(at[:2].sum()) - 1.0, abs(float(at[2])) - 1.0)
    return max(-float(at[2]), float(np.abs(at[:2]).max()) + float(at[2]) - 1.0)
