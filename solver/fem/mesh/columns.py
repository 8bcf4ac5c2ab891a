"""Where the columns of a section's mesh stand: planned once, then moved smoothly with the geometry.

A mark is an x that a column must meet: an end or a break of the surface, a cut, a point, an end of a piece, a crossing
of a layer's bottom with its top. The plan says between which marks how many columns stand. Marks may move with the
geometry, but not pass one another.
"""

from __future__ import annotations

from bisect import bisect
from dataclasses import dataclass
from itertools import pairwise
from typing import TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import MeshError
from geoswarm.solver.fem.mesh.cross_section import Cut, Profile, SectionGeometry

__all__ = ["MAX_ELEMENTS", "ColumnPlan", "Mark", "boundary_heights", "cut_positions", "mark_positions", "plan_columns"]

Mark: TypeAlias = tuple[str, str, int]
"""Kind, name and number of a mark; for words: ``("cut", "crack", 0)``."""

MAX_ELEMENTS = 100_000
"""Triangles that a section may have."""

_MERGED = 1.0e-7
"""Marks closer than this, in lengths of the section, are one."""

_CROWDED = 0.3
"""A break of a layer closer than this to another mark, in lengths of an element, gets no column of its own."""


@dataclass(frozen=True)
class ColumnPlan:
    """The marks from left to right, the column of each, and the place of every column between its two marks."""

    marks: tuple[Mark, ...]
    column: dict[Mark, int]
    merged: tuple[tuple[Mark, Mark], ...]
    """Marks that are one with another one of ``marks``."""
    block: FloatArray
    """(n,): index of the mark on the left plus the fraction of the way to the next one."""

    def surface_x(self, geometry: SectionGeometry) -> FloatArray:
        """x of every column at the surface, (n,).

        Raises
        ------
        MeshError
            Two marks have passed one another, one has vanished, or two that were planned as one have parted.
        """
        positions = mark_positions(geometry)
        missing = [mark for mark in (*self.marks, *(mark for mark, _ in self.merged)) if mark not in positions]
        if missing:
            raise MeshError(f"{_words(missing[0])} has vanished; the mesh cannot follow")
        x = np.array([positions[mark] for mark in self.marks])
        passed = np.flatnonzero(np.diff(x) <= _MERGED * (x[-1] - x[0]))
        if passed.size:
            left, right = self.marks[passed[0]], self.marks[passed[0] + 1]
            raise MeshError(
                f"{_words(left)} at x = {x[passed[0]]:.6g} m is not left of {_words(right)} at "
                f"x = {x[passed[0] + 1]:.6g} m; the mesh cannot follow"
            )
        for mark, other in self.merged:
            if abs(positions[mark] - positions[other]) > 10.0 * _MERGED * (x[-1] - x[0]):
                raise MeshError(
                    f"{_words(mark)} at x = {positions[mark]:.6g} m and {_words(other)} at x = {positions[other]:.6g} "
                    "m were at one place when the mesh was planned; plan it with a geometry where they are apart"
                )
        found: FloatArray = np.interp(self.block, np.arange(len(x)), x)
        return found


def _words(mark: Mark) -> str:
    kind, name, number = mark
    return {
        "end": f"the {'right' if number else 'left'} end of the surface",
        "surface": f"point {number + 1} of the surface",
        "layer": f"point {number + 1} of layer {name}",
        "crossing": f"the end of layer {name}",
        "cut": f"cut {name}",
        "point": f"point {name}",
    }.get(kind, f"the {'end' if number else 'start'} of {kind} {name}")


def boundary_heights(geometry: SectionGeometry, x: FloatArray, boundary: int) -> FloatArray:
    """Height of the surface (0) or of the bottom of layer ``boundary`` - 1 at x, same shape."""
    height = geometry.surface.at(x)
    for layer in geometry.layers[:boundary]:
        if layer.thickness is not None:
            height = height - layer.thickness.at(x)
        elif layer.bottom is not None:
            height = np.minimum(height, layer.bottom.at(x))
    return height


def _breaks(geometry: SectionGeometry) -> FloatArray:
    """x of all breaks of the lines, between which everything is straight."""
    lines = [geometry.surface, *(line for layer in geometry.layers for line in (layer.thickness, layer.bottom) if line)]
    x = np.unique(np.concatenate([line.x for line in lines]))
    low, high = geometry.surface.x[[0, -1]]
    return np.concatenate([[low], x[(x > low) & (x < high)], [high]])


def _crossings(geometry: SectionGeometry, number: int, bottom: Profile) -> list[float]:
    """x at which a layer begins or ends, from left to right."""
    knots = _breaks(geometry)
    while True:  # a minimum of lines is straight only between its own crossings: two passes suffice
        gap = boundary_heights(geometry, knots, number) - bottom.at(knots)
        flat = np.abs(gap) < 1e-9 * max(1.0, float(np.abs(gap).max()))
        gap[flat] = 0.0
        changes = np.flatnonzero(gap[:-1] * gap[1:] < 0.0)
        if not changes.size:
            break
        share = gap[changes] / (gap[changes] - gap[changes + 1])
        knots = np.sort(np.concatenate([knots, knots[changes] + share * np.diff(knots)[changes]]))
        if len(knots) > 10_000:
            break
    inside = gap > 0.0
    starts = ~inside[:-1] & inside[1:] & (gap[:-1] <= 0.0)
    ends = inside[:-1] & ~inside[1:]
    return sorted([*knots[:-1][starts].tolist(), *knots[1:][ends].tolist()])


def mark_positions(geometry: SectionGeometry) -> dict[Mark, float]:
    """x of all marks at the surface, the most important kinds first."""
    low, high = geometry.surface.x[[0, -1]].tolist()
    found: dict[Mark, float] = {("end", "", 0): low, ("end", "", 1): high}
    for cut in geometry.cuts:
        half = 0.5 * (cut.width or 0.0)
        edges = [cut.x] if cut.width is None else [cut.x - half, cut.x + half]
        found |= {("cut", cut.name, n): x for n, x in enumerate(edges)}
    found |= {("point", point.name, 0): point.x for point in geometry.points}
    for kind, extents in (
        ("segment", geometry.segments),
        ("zone", geometry.zones),
        ("interface", geometry.interfaces),
    ):
        for extent in extents:
            found |= {(kind, extent.name, 0): extent.start, (kind, extent.name, 1): extent.end}
    for number, x in enumerate(geometry.surface.x.tolist()[1:-1], start=1):
        found["surface", "", number] = x
    for number, layer in enumerate(geometry.layers):
        if layer.bottom is not None:
            for which, x in enumerate(_crossings(geometry, number, layer.bottom)):
                found["crossing", layer.name, which] = x
    for layer in geometry.layers:
        line = layer.thickness or layer.bottom
        if line is not None:
            found |= {("layer", layer.name, n): x for n, x in enumerate(line.x.tolist()) if low < x < high}
    return found


def plan_columns(geometry: SectionGeometry, element_length: Profile) -> ColumnPlan:
    """Choose the columns for a geometry: about ``element_length`` (over x) apart.

    Raises
    ------
    MeshError
        A mark lies beyond the ends of the surface, or there would be too many elements.
    """
    positions = mark_positions(geometry)
    low, high = positions["end", "", 0], positions["end", "", 1]
    merged = _MERGED * (high - low)
    for mark, x in positions.items():
        if not low - merged <= x <= high + merged:
            raise MeshError(f"{_words(mark)} at x = {x:g} m lies outside the surface, from {low:g} to {high:g} m")
    chosen: list[tuple[float, int, Mark]] = []  # in the order of x; the number is the order of their definition
    alias: dict[Mark, Mark] = {}
    for number, (mark, x) in enumerate(positions.items()):
        place = bisect(chosen, (x, number, mark))
        if not chosen:
            chosen.append((x, number, mark))
            continue
        _, _, nearest = min(
            (abs(other - x), order, name) for other, order, name in chosen[max(place - 1, 0) : place + 1]
        )
        apart = abs(positions[nearest] - x)
        crowded = mark[0] == "layer" and apart < _CROWDED * float(element_length.at(np.array([x]))[0])
        if apart <= merged:
            alias[mark] = nearest
        elif not crowded:
            chosen.insert(place, (x, number, mark))
    marks = tuple(mark for _, _, mark in chosen)
    counts = _counts(geometry, element_length, np.array([x for x, _, _ in chosen]))
    blocks, column = [np.zeros(1)], {marks[0]: 0}
    for number, ((left, right), count) in enumerate(zip(pairwise(marks), counts, strict=True)):
        blocks.append(number + np.arange(1, count + 1) / count)
        column[right] = column[left] + count
    column |= {mark: column[other] for mark, other in alias.items()}
    return ColumnPlan(marks, column, tuple(alias.items()), np.concatenate(blocks))


def _counts(geometry: SectionGeometry, element_length: Profile, marks: FloatArray) -> list[int]:
    """Columns between each mark and the next one; marks (k,), result k - 1 numbers."""
    wanted = []
    for left, right in pairwise(marks.tolist()):
        sample = left + (np.arange(32, dtype=np.float64) + 0.5) / 32.0 * (right - left)
        with np.errstate(over="ignore"):
            wanted.append(max(1.0, float(np.mean(1.0 / element_length.at(sample))) * (right - left)))
    elements = 2.0 * sum(wanted) * sum(layer.rows for layer in geometry.layers)
    if not elements <= MAX_ELEMENTS:
        shortest = float(element_length.y.min())
        raise MeshError(
            f"the element length, {shortest:g} m at its shortest, and the rows of the layers give {elements:.3g} "
            f"elements; at most {MAX_ELEMENTS} are accepted"
        )
    return [round(count) for count in wanted]


def cut_positions(geometry: SectionGeometry, cut: Cut, x_top: float, x_bottom: float) -> list[float]:
    """x at which an edge of a cut, from ``x_top`` to ``x_bottom``, meets the surface and the bottoms of all layers."""
    last = geometry.layer_index(cut.through) + 1
    top = float(boundary_heights(geometry, np.array([x_top]), 0)[0])
    bottom = float(boundary_heights(geometry, np.array([x_bottom]), last)[0])
    found = [x_top]
    for boundary in range(1, last):
        low, high = 0.0, 1.0
        for _ in range(60):
            middle = 0.5 * (low + high)
            x = np.array([x_top + middle * (x_bottom - x_top)])
            above = top + middle * (bottom - top) > boundary_heights(geometry, x, boundary)[0]
            low, high = (middle, high) if above else (low, middle)
        found.append(x_top + 0.5 * (low + high) * (x_bottom - x_top))
    return [*found, *[x_bottom] * (len(geometry.layers) - last + 1)]
