"""Structured meshes of layered sections: columns and rows of cells, each of two six-node triangles.

The topology (which elements are neighbours) is planned once from a nominal geometry. After that the mesh of any other
geometry has the same numbers, and each of its nodes is a continuous function of the geometry's numbers: an objective
over depth or thickness of a layer is as smooth as one over a modulus.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.checks import check_mesh
from geoswarm.solver.fem.mesh.columns import ColumnPlan, boundary_heights, cut_positions, plan_columns
from geoswarm.solver.fem.mesh.cross_section import Profile, SectionGeometry
from geoswarm.solver.fem.mesh.mesh import EDGES, IndexArray, Mesh, midpoints, six_node_triangles
from geoswarm.solver.fem.mesh.split import split_along

__all__ = ["LayeredMesh", "lines_below"]


@dataclass(frozen=True)
class LayeredMesh:
    """A planned mesh that follows its geometry.

    Parameters
    ----------
    nominal
        Mesh of the geometry that it was planned for.
    columns
        Plan of the columns.
    """

    nominal: Mesh
    columns: ColumnPlan
    _grid: IndexArray
    """(k,): place in the flattened grid of each corner."""
    _ends: IndexArray
    _origin: IndexArray

    @classmethod
    def plan(cls, geometry: SectionGeometry, element_length: Profile) -> LayeredMesh:
        """Plan the mesh of a section.

        Parameters
        ----------
        element_length
            Wanted width of the columns over x, m.

        Raises
        ------
        MeshError
            The geometry cannot be meshed; the message names the place.
        """
        columns = plan_columns(geometry, element_length)
        x, y = _grid_coordinates(geometry, columns)
        grid = _Grid(geometry, columns, x, y)
        ids, first = np.unique(grid.ids, return_index=True)
        corners = np.stack([x.ravel()[first], y.ravel()[first]], axis=1)
        renumber = np.searchsorted(ids, grid.ids).astype(np.int32)
        grid.ids = renumber
        cells, regions, names = grid.triangles()
        triangles, ends = six_node_triangles(cells, len(ids))
        mesh = Mesh(
            nodes=np.concatenate([corners, midpoints(corners, ends)]),
            triangles=triangles,
            regions=regions,
            region_names=names,
            boundaries=_oriented(dict(grid.boundaries()), triangles),
            points=grid.points(),
        )
        mesh, origin = split_along(mesh, grid.lines())
        check_mesh(mesh)
        return cls(mesh, columns, first.astype(np.int32), ends, origin)

    def mesh(self, geometry: SectionGeometry) -> Mesh:
        """Mesh of another geometry with the same layers, cuts and names.

        Raises
        ------
        MeshError
            The geometry is so different that the mesh cannot follow: a layer without thickness, marks that pass one
            another, folded elements.
        """
        x, y = _grid_coordinates(geometry, self.columns)
        corners = np.stack([x.ravel()[self._grid], y.ravel()[self._grid]], axis=1)
        nodes = np.concatenate([corners, midpoints(corners, self._ends)])[self._origin]
        moved = replace(self.nominal, nodes=nodes)
        check_mesh(moved)
        return moved


def _row_fractions(rows: int, grading: float) -> FloatArray:
    heights = np.geomspace(1.0, grading, rows)
    found: FloatArray = np.cumsum(heights) / heights.sum()
    return found


def _grid_coordinates(geometry: SectionGeometry, columns: ColumnPlan) -> tuple[FloatArray, FloatArray]:
    """x and y of all corners of cells, (columns, rows + 1), from the surface down."""
    x_of, y_of = lines_below(geometry, columns.surface_x(geometry))
    x, y = [x_of[:, :1]], [y_of[:, :1]]
    for number, layer in enumerate(geometry.layers):
        share = _row_fractions(layer.rows, layer.grading)
        x.append(x_of[:, [number]] + share * (x_of[:, [number + 1]] - x_of[:, [number]]))
        y.append(y_of[:, [number]] + share * (y_of[:, [number + 1]] - y_of[:, [number]]))
    return np.concatenate(x, axis=1), np.concatenate(y, axis=1)


def lines_below(geometry: SectionGeometry, surface: FloatArray) -> tuple[FloatArray, FloatArray]:
    """x and y of places at the surface, (n,), and below each of them, along the cuts, at the bottoms of all layers.

    Returns
    -------
    Both (n, layers + 1), m, from the surface down.

    Raises
    ------
    MeshError
        Cuts cross one another or the ends of the section.
    """
    boundaries = len(geometry.layers) + 1
    anchors = [(end, [end] * boundaries) for end in geometry.surface.x[[0, -1]].tolist()]
    for cut in geometry.cuts:
        half = 0.5 * (cut.width or 0.0)
        anchors += [
            (cut.x + shift, cut_positions(geometry, cut, cut.x + shift, cut.x_bottom + shift))
            for shift in ((0.0,) if cut.width is None else (-half, half))
        ]
    anchors += _guards(geometry, anchors, boundaries)
    anchors.sort(key=lambda anchor: anchor[0])
    places = np.array([place for place, _ in anchors])
    depths = np.array([x for _, x in anchors])
    if (np.diff(depths, axis=0) < 0.0).any():
        raise MeshError("two cuts cross one another, or one crosses an end of the section, below the surface")
    x_of = np.stack([np.interp(surface, places, depths[:, k]) for k in range(boundaries)], axis=1)
    y_of = np.stack([boundary_heights(geometry, x_of[:, k], k) for k in range(boundaries)], axis=1)
    return x_of, y_of


def _guards(
    geometry: SectionGeometry, anchors: list[tuple[float, list[float]]], boundaries: int
) -> list[tuple[float, list[float]]]:
    """Vertical columns on both sides of each inclined cut, so that it tilts only the columns near it."""
    ends = [anchor[0] for anchor in anchors[:2]]
    spans = []
    for cut in geometry.cuts:
        half = 0.5 * (cut.width or 0.0)
        spans.append((min(cut.x, cut.x_bottom) - half, max(cut.x, cut.x_bottom) + half))
    spans.sort()
    guards = []
    for number, (low, high) in enumerate(spans):
        before = spans[number - 1][1] if number else ends[0]
        after = spans[number + 1][0] if number + 1 < len(spans) else ends[1]
        reach = 1.5 * (high - low) + 1e-3 * (ends[1] - ends[0])
        guards += [low - min(reach, 0.45 * (low - before)), high + min(reach, 0.45 * (after - high))]
    return [(x, [x] * boundaries) for x in guards]


class _Grid:
    """Corners of cells with their numbers; where a layer has no thickness, those of its rows are the same."""

    def __init__(self, geometry: SectionGeometry, columns: ColumnPlan, x: FloatArray, y: FloatArray) -> None:
        self._geometry = geometry
        self._columns = columns
        self._levels = np.concatenate([[0], np.cumsum([layer.rows for layer in geometry.layers])])
        self.ids: IndexArray = np.arange(x.size, dtype=np.int32).reshape(x.shape)
        size = max(np.ptp(x), np.ptp(y))
        for number, layer in enumerate(geometry.layers):
            above, below = self._levels[number], self._levels[number + 1]
            height = y[:, above] - y[:, below]
            if height.min() < -1e-9 * size:
                raise MeshError(
                    f"layer {layer.name} has the thickness {height.min():.4g} m at x = {x[np.argmin(height), 0]:.6g} m"
                )
            empty = height <= 1e-9 * size
            if empty.all():
                raise MeshError(f"layer {layer.name} has no thickness anywhere")
            self.ids[empty, above + 1 : below + 1] = self.ids[empty, above][:, None]

    def _level(self, layer: str) -> int:
        return int(self._levels[self._geometry.layer_index(layer) + 1])

    def _column(self, kind: str, name: str, number: int) -> int:
        return self._columns.column[kind, name, number]

    def triangles(self) -> tuple[IndexArray, IndexArray, tuple[str, ...]]:
        """Corners (e, 3), regions (e,) and their names; diagonals alternate from cell to cell."""
        names = {layer.name: n for n, layer in enumerate(self._geometry.layers)}
        wide, high = self.ids.shape[0] - 1, self.ids.shape[1] - 1
        region = np.repeat(np.arange(len(names)), np.diff(self._levels))[None, :].repeat(wide, axis=0)
        for zone in self._geometry.zones:
            assert zone.layer is not None
            first, last = (self._column("zone", zone.name, n) for n in (0, 1))
            level = self._level(zone.layer)
            rows = self._geometry.layers[self._geometry.layer_index(zone.layer)].rows
            region[first:last, level - rows : level] = names.setdefault(zone.name, len(names))
        for cut in self._geometry.cuts:
            if cut.width is not None and cut.region is not None:
                first, last = (self._column("cut", cut.name, n) for n in (0, 1))
                region[first:last, : self._level(cut.through)] = names.setdefault(cut.region, len(names))
        cells, regions = [], []
        for i in range(wide):
            for j in range(high):
                upper_left, upper_right = self.ids[i, j], self.ids[i + 1, j]
                lower_left, lower_right = self.ids[i, j + 1], self.ids[i + 1, j + 1]
                if (i + j) % 2:
                    pair = ((lower_left, lower_right, upper_right), (lower_left, upper_right, upper_left))
                else:
                    pair = ((lower_left, lower_right, upper_left), (lower_right, upper_right, upper_left))
                for corners in pair:
                    if len(set(corners)) == 3:
                        cells.append(corners)
                        regions.append(region[i, j])
        used, numbers = np.unique(regions, return_inverse=True)
        ordered = list(names)
        return (
            np.array(cells, dtype=np.int32),
            numbers.astype(np.int32),
            tuple(ordered[number] for number in used.tolist()),
        )

    def boundaries(self) -> Iterator[tuple[str, list[tuple[int, int]]]]:
        """Sides of the section, whole and by layer, and named pieces of the surface, as pairs of corners."""
        yield "surface", self._row(0, 0, -1)
        yield "bottom", self._row(-1, 0, -1)
        for side, column in (("left", 0), ("right", self.ids.shape[0] - 1)):
            yield side, self._steps(column, 0, self.ids.shape[1] - 1)
            for number, layer in enumerate(self._geometry.layers):
                steps = self._steps(column, int(self._levels[number]), int(self._levels[number + 1]))
                if steps:
                    yield f"{side}.{layer.name}", steps
        for segment in self._geometry.segments:
            first, last = (self._column("segment", segment.name, n) for n in (0, 1))
            yield segment.name, self._row(0, first, last)

    def _row(self, level: int, first: int, last: int) -> list[tuple[int, int]]:
        along = self.ids[:, level].tolist()
        along = along[first:] if last == -1 else along[first : last + 1]
        return list(pairwise(along))

    def _steps(self, column: int, top: int, bottom: int) -> list[tuple[int, int]]:
        along = self.ids[column, top : bottom + 1].tolist()
        return [(a, b) for a, b in pairwise(along) if a != b]

    def lines(self) -> dict[str, IndexArray]:
        """Edges of all interfaces: cuts from the surface down, pieces of bottoms of layers from left to right."""
        found: dict[str, IndexArray] = {}
        for cut in self._geometry.cuts:
            steps = []
            for number in (0,) if cut.width is None else (0, 1):
                steps += self._steps(self._column("cut", cut.name, number), 0, self._level(cut.through))
            found[cut.name] = np.array(steps, dtype=np.int32)
        for extent in self._geometry.interfaces:
            assert extent.layer is not None
            first, last = (self._column("interface", extent.name, n) for n in (0, 1))
            found[extent.name] = np.array(self._row(self._level(extent.layer), first, last), dtype=np.int32)
        return found

    def points(self) -> dict[str, int]:
        """Nodes of the named points."""
        return {
            point.name: int(
                self.ids[self._column("point", point.name, 0), 0 if point.below is None else self._level(point.below)]
            )
            for point in self._geometry.points
        }


def _oriented(pairs: dict[str, list[tuple[int, int]]], triangles: IndexArray) -> dict[str, IndexArray]:
    """Edges with mid-sides, the body on the left, of pairs of corners on the boundary."""
    known = {
        frozenset((start, end)): (start, end, mid)
        for a, b, c in EDGES
        for start, end, mid in triangles[:, [a, b, c]].tolist()
    }
    return {name: np.array([known[frozenset(pair)] for pair in edges], dtype=np.int32) for name, edges in pairs.items()}
