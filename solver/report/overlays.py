"""Several tests in one diagram: the curves of all that have the same axes, measured and calculated."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.report.compression import CompressionCurve
from geoswarm.solver.report.curves import SeriesCurve
from geoswarm.solver.report.diagrams import DiagramCurve
from geoswarm.solver.units import convert

__all__ = ["MANY_TESTS", "Overlay", "OverlayLine", "overlays"]

MANY_TESTS = 4
"""Tests in one diagram from which on there is no figure for each of them."""


@dataclass(frozen=True, slots=True)
class OverlayLine:
    """A test in a diagram.

    Parameters
    ----------
    test
        Its name.
    x, y
        Calculated, shape (n,); nan between stages that are not joined.
    measured_x, measured_y
        Shape (m,).
    compared
        x and y calculated with another set of parameters; None without one.
    """

    test: str
    x: FloatArray
    y: FloatArray
    measured_x: FloatArray
    measured_y: FloatArray
    compared: tuple[FloatArray, FloatArray] | None = None


@dataclass(frozen=True, slots=True)
class Overlay:
    """A diagram of several tests: its name, quantity and unit of both axes, and a line for each test."""

    name: str
    x_axis: tuple[str, str]
    y_axis: tuple[str, str]
    lines: tuple[OverlayLine, ...]
    log: bool = False
    downwards: bool = False


def overlays(
    curves: Sequence[SeriesCurve],
    diagrams: Iterable[DiagramCurve],
    compression: Iterable[CompressionCurve],
    compared: Sequence[Overlay] = (),
) -> tuple[Overlay, ...]:
    """Return the diagrams that at least two tests of a combined problem have.

    Parameters
    ----------
    curves, diagrams, compression
        Those of all tests. Series over the number of a stage are in the compression curves.
    compared
        The same with another set of parameters.
    """
    single = [*map(_of_series, curves), *map(_of_diagram, diagrams), *map(_of_compression, compression)]
    found: dict[tuple[object, ...], Overlay] = {}
    for one in single:
        if one is None:
            continue
        key = one.name, one.x_axis[0], one.y_axis[0]
        before = found.get(key)
        found[key] = one if before is None else replace(before, lines=(*before.lines, *_in_units(one, before).lines))
    other = {(one.name, line.test): (one, line) for one in compared for line in one.lines}
    return tuple(_beside(one, other) for one in found.values() if len(one.lines) > 1)


def _beside(one: Overlay, other: Mapping[tuple[str, str], tuple[Overlay, OverlayLine]]) -> Overlay:
    lines = []
    for line in one.lines:
        found = other.get((one.name, line.test))
        lines.append(line if found is None else replace(line, compared=(found[1].x, found[1].y)))
    return replace(one, lines=tuple(lines))


def _of_series(curve: SeriesCurve) -> Overlay | None:
    test, dot, name = curve.series.partition(".")
    if not dot or name.startswith("stage_"):
        return None
    line = OverlayLine(test, curve.x, curve.y, curve.measured_x, curve.measured_y)
    down = curve.y_quantity == "settlement" or name.endswith("settlement")
    return Overlay(name, (curve.x_quantity, curve.x_unit), (curve.y_quantity, curve.y_unit), (line,), downwards=down)


def _of_diagram(curve: DiagramCurve) -> Overlay | None:
    if not curve.part:
        return None
    line = OverlayLine(curve.part, curve.x, curve.y, curve.measured_x, curve.measured_y)
    x_axis = (curve.x_info.y_quantity, curve.x_info.y_unit)
    y_axis = (curve.y_info.y_quantity, curve.y_info.y_unit)
    one = curve.diagram
    return Overlay(one.name, x_axis, y_axis, (line,), log=one.log, downwards=one.downwards)


def _of_compression(curve: CompressionCurve) -> Overlay | None:
    if not curve.part:
        return None
    line = OverlayLine(curve.part, curve.stress, curve.calculated, curve.measured_stress, curve.measured)
    x_axis, y_axis = curve.axes
    return Overlay("compression", x_axis, y_axis, (line,), log=True, downwards=not curve.void_ratio)


def _in_units(one: Overlay, of: Overlay) -> Overlay:
    """A diagram in the units of another one with the same quantities."""
    if (one.x_axis, one.y_axis) == (of.x_axis, of.y_axis):
        return one

    def converted(values: FloatArray, axis: tuple[str, str], wanted: tuple[str, str]) -> FloatArray:
        return np.asarray(convert(values, axis[1] or "1", wanted[1] or "1"))

    lines = tuple(
        replace(
            line,
            x=converted(line.x, one.x_axis, of.x_axis),
            y=converted(line.y, one.y_axis, of.y_axis),
            measured_x=converted(line.measured_x, one.x_axis, of.x_axis),
            measured_y=converted(line.measured_y, one.y_axis, of.y_axis),
        )
        for line in one.lines
    )
    return replace(one, lines=lines)
