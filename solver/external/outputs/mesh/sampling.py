"""Values of a field at a point inside a mesh."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.mesh.elements import element
from geoswarm.solver.external.outputs.mesh.snapshots import Piece, Snapshot
from geoswarm.solver.words import did_you_mean

__all__ = ["Place", "Sampler"]

Component = Literal["x", "y", "z", "magnitude"] | int

_SLACK = 1e-6  # of an element: coordinates in files are rounded
_AXES = {"x": 1, "y": 2, "z": 3}


@dataclass(frozen=True, slots=True, eq=False)
class Place:
    """Where a point lies: the piece, the block and the element in it, from 0, its nodes (k,) and their weights (k,)."""

    piece: int
    block: int
    element: int
    kind: str
    nodes: IntArray
    weights: FloatArray


class Sampler:
    """Samples a field at a point of one snapshot after another; the element is looked for again when the mesh changes.

    Parameters
    ----------
    point
        (2,) for a plane mesh, or (3,), in the mesh's length unit.
    component
        None for a scalar.
    """

    def __init__(self, file: str, point: Sequence[float], field: str, component: Component | None) -> None:
        self._file, self._field, self._component = file, field, component
        self._point = np.array(point, dtype=np.float64)
        self._meshes: tuple[Piece, ...] = ()
        self._place: Place | None = None

    def value(self, snapshot: Snapshot) -> tuple[float, str]:
        """Return the value, and in words where it comes from.

        Raises
        ------
        OutputError
            No element holds the point, or there is no such field or component.
        """
        if self._place is None or not _same(self._meshes, snapshot.pieces):
            self._place, self._meshes = self._found(snapshot.pieces), snapshot.pieces
        place = self._place
        piece = snapshot.pieces[place.piece]
        if self._field in piece.at_nodes:
            values = np.asarray(piece.at_nodes[self._field], dtype=np.float64)[place.nodes]
            number = self._of(place.weights @ values.reshape(len(values), -1), piece)
        elif self._field in piece.in_elements:
            values = np.asarray(piece.in_elements[self._field][place.block], dtype=np.float64)[place.element]
            number = self._of(values.ravel(), piece)
        else:
            known = [*piece.at_nodes, *piece.in_elements]
            hint = did_you_mean(self._field, known)
            listed = ", ".join(known[:20]) or "none"
            raise OutputError("bad_output", f"{piece.file}: no field {self._field}{hint}; there are {listed}")
        component = "" if self._component is None else f" {self._component}"
        where = f"element {place.element} ({place.kind}) of {piece.file}"
        return number, f"{where} at time {snapshot.time:g}: {self._field}{component} = {number!r}"

    def _of(self, vector: FloatArray, piece: Piece) -> float:
        """Return the wanted component of a value, (components,)."""
        count = len(vector)
        if self._component == "magnitude":
            return float(np.linalg.norm(vector))
        if self._component is None:
            if count == 1:
                return float(vector[0])
            message = f"field {self._field} has {count} components; write component: x, y, z, magnitude or a number"
            raise OutputError("bad_output", f"{piece.file}: {message}")
        number = self._component if isinstance(self._component, int) else _AXES[self._component]
        if number > count:
            message = f"field {self._field} has {count} components; {self._component} does not exist"
            raise OutputError("bad_output", f"{piece.file}: {message}")
        return float(vector[number - 1])

    def _found(self, pieces: Sequence[Piece]) -> Place:
        best: tuple[float, Place] | None = None
        dimensions = [found.dimension for piece in pieces for kind, _ in piece.blocks if (found := element(kind))]
        highest = max(dimensions, default=0)
        self._check_plane(pieces, highest)
        for at, piece in enumerate(pieces):
            for number, (kind, table) in enumerate(piece.blocks):
                found = element(kind)
                if found is None or found.dimension != highest or not table.size:
                    continue
                for candidate in self._candidates(piece, table):
                    corners = piece.nodes[table[candidate]][:, : len(self._point)]
                    weights, outside = found.locate(corners, self._point)
                    if best is None or outside < best[0]:
                        best = outside, Place(at, number, int(candidate), kind, table[candidate], weights)
                    if outside <= 0.0:
                        return best[1]
        if best is not None and best[0] <= _SLACK:
            return best[1]
        raise self._outside(pieces)

    def _candidates(self, piece: Piece, table: IntArray) -> IntArray:
        """Elements whose box, a fifth larger for curved edges, holds the point."""
        corners = piece.nodes[table][:, :, : len(self._point)]
        low, high = corners.min(axis=1), corners.max(axis=1)
        margin = 0.2 * (high - low).max(axis=1, keepdims=True)
        inside = ((self._point >= low - margin) & (self._point <= high + margin)).all(axis=1)
        return np.flatnonzero(inside)

    def _check_plane(self, pieces: Sequence[Piece], highest: int) -> None:
        if len(self._point) == 3:
            return
        if highest == 3:
            raise OutputError("bad_output", f"{self._file}: the mesh has volumes; point needs three coordinates")
        nodes = np.concatenate([piece.nodes for piece in pieces])
        extent = np.ptp(nodes, axis=0)
        if extent[2] > 1e-9 * max(extent[0], extent[1]):
            message = "the mesh does not lie in the plane of x and y; point needs three coordinates"
            raise OutputError("bad_output", f"{self._file}: {message}")

    def _outside(self, pieces: Sequence[Piece]) -> OutputError:
        where = ", ".join(f"{one:g}" for one in self._point)
        unknown = sorted({kind for piece in pieces for kind, _ in piece.blocks if element(kind) is None})
        nodes = np.concatenate([piece.nodes for piece in pieces])[:, : len(self._point)]
        if not len(nodes):
            return OutputError("bad_output", f"{self._file}: the mesh has no nodes")
        distances = np.linalg.norm(nodes - self._point, axis=1)
        nearest = nodes[int(distances.argmin())]
        near = ", ".join(f"{one:g}" for one in nearest)
        kinds = f"; elements of type {', '.join(unknown)} are not known" if unknown else ""
        message = (
            f"no element holds the point ({where}); the nearest node is ({near}), {distances.min():.4g} away{kinds}"
        )
        return OutputError("bad_output", f"{self._file}: {message}")


def _same(before: Sequence[Piece], now: Sequence[Piece]) -> bool:
    if len(before) != len(now):
        return False
    return all(
        np.array_equal(a.nodes, b.nodes)
        and len(a.blocks) == len(b.blocks)
        and all(x[0] == y[0] and np.array_equal(x[1], y[1]) for x, y in zip(a.blocks, b.blocks, strict=True))
        for a, b in zip(before, now, strict=True)
    )
