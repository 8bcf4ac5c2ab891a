"""The sketch of a section: its geometry as given, for the nominal values, without a mesh."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleError, SolverError
from geoswarm.solver.fem.mesh.columns import boundary_heights, mark_positions
from geoswarm.solver.fem.mesh.cross_section import Extent, SectionGeometry
from geoswarm.solver.fem.mesh.layered import lines_below
from geoswarm.solver.forward.continuum.body import BodySections
from geoswarm.solver.forward.continuum.geometry import GeometrySections
from geoswarm.solver.forward.continuum.materials import InterfaceSection
from geoswarm.solver.forward.continuum.phases import Fixity, LoadSection, PhaseSection
from geoswarm.solver.forward.continuum.quantity import Quantity, quantities_in, value_of
from geoswarm.solver.sketches.declared import (
    BoundaryLoad,
    CrossSection,
    Interface,
    Panel,
    Phase,
    Place,
    Region,
    Sketch,
    Support,
    Track,
)
from geoswarm.solver.sketches.ticks import ground_length, number

__all__ = ["SketchedSection"]

_THIN = 1.0e-9
"""Thickness, in lengths of the section, at which a layer ends."""
_WATER = (9.5, 10.5)
"""Increase of a pressure with depth, kN/m³, that is meant for water."""
_YEAR = 365.25


class SketchedSection(GeometrySections, BodySections):
    """A section that can be drawn; mixed into the section of the forward model."""

    def sketch(self) -> Sketch | None:
        """The section with what acts on it, and its phases; None while its geometry is not possible."""
        if not set(_named(self)) <= self.nominal.keys():
            return None
        try:
            outline = _Outline(self.geometry(self.nominal))
            points = tuple(outline.points())
            regions = tuple(_regions(self, outline))
        except SolverError:
            return None
        body = CrossSection(
            surface=outline.along(0),
            bottom=outline.along(len(self.layers)),
            regions=regions,
            interfaces=tuple(_interfaces(self, outline)),
            points=points,
            loads=tuple(_loads(self, outline)),
            supports=_supports(self, outline),
            given=tuple((name, self.nominal[name]) for name in _named(self)),
        )
        return Sketch("Section", body, _programme(self), tuple(_phases(self)))


class _Outline:
    """Lines of a section: the surface (0) and the bottoms of all layers."""

    def __init__(self, geometry: SectionGeometry) -> None:
        self.geometry = geometry
        self.low, self.high = geometry.surface.x[[0, -1]].tolist()
        lines = [
            geometry.surface,
            *(line for layer in geometry.layers for line in (layer.thickness, layer.bottom) if line),
        ]
        crossings = [x for (kind, _, _), x in mark_positions(geometry).items() if kind == "crossing"]
        breaks = np.unique(np.concatenate([*(line.x for line in lines), crossings]))
        self.breaks = np.concatenate([[self.low], breaks[(breaks > self.low) & (breaks < self.high)], [self.high]])
        self._least = _THIN * (self.high - self.low)
        if any((self._gap(n, self.breaks) < -self._least).any() for n in range(len(geometry.layers))):
            raise InfeasibleError("a layer has a negative thickness")
        wanted = [point.x for point in geometry.points]
        wanted += [x for one in (*geometry.zones, *geometry.interfaces) for x in (one.start, one.end)]
        across, heights = (found.tolist() for found in lines_below(geometry, np.array(wanted)))
        columns = zip(across, heights, strict=True)
        self._below = {x: list(zip(*one, strict=True)) for x, one in zip(wanted, columns, strict=True)}

    def _gap(self, layer: int, x: FloatArray) -> FloatArray:
        found: FloatArray = boundary_heights(self.geometry, x, layer) - boundary_heights(self.geometry, x, layer + 1)
        return found

    def along(self, line: int, start: float | None = None, end: float | None = None) -> tuple[Place, ...]:
        """Corners of a line between two x, from left to right."""
        start, end = self.low if start is None else start, self.high if end is None else end
        inner = self.breaks[(self.breaks > start) & (self.breaks < end)]
        x = np.concatenate([[start], inner, [end]])
        return tuple(zip(x.tolist(), boundary_heights(self.geometry, x, line).tolist(), strict=True))

    def below(self, x: float) -> list[Place]:
        """The place of a point or of an end of a piece, and those below it, along the cuts."""
        return self._below[x]

    def layer(self, number: int) -> Iterator[tuple[Place, ...]]:
        """Corners of the pieces of a layer."""
        thick = self._gap(number, self.breaks) > self._least
        first: int | None = None
        for place, (left, right) in enumerate(pairwise(thick.tolist())):
            if (left or right) and first is None:
                first = place
            last = place + 2 == len(thick)
            if first is not None and (last or not right):
                ends = self.breaks[[first, place + 1]].tolist()
                yield self.between(number, number + 1, (ends[0], ends[0]), (ends[1], ends[1]))
                first = None

    def between(
        self, upper: int, lower: int, left: tuple[float, float], right: tuple[float, float]
    ) -> tuple[Place, ...]:
        """Corners of what lies between two lines; ``left`` and ``right``: x at the upper and at the lower one."""
        top = self.along(upper, left[0], right[0])
        return _corners([*top, *reversed(self.along(lower, left[1], right[1]))])

    def side(self, name: str, layer: str) -> tuple[Place, ...]:
        """A side, or the piece of it of a layer, from the top down."""
        x = self.low if name == "left" else self.high
        count = len(self.geometry.layers)
        first, last = (0, count) if not layer else (self.geometry.layer_index(layer), None)
        last = first + 1 if last is None else last
        return tuple((x, float(boundary_heights(self.geometry, np.array([x]), n)[0])) for n in (first, last))

    def boundary(self, name: str) -> tuple[Place, ...]:
        """A boundary by its name; empty where there is none."""
        side, _, layer = name.partition(".")
        if side in ("left", "right"):
            known = not layer or layer in [one.name for one in self.geometry.layers]
            return self.side(side, layer) if known else ()
        if name in ("surface", "bottom"):
            return self.along(0 if name == "surface" else len(self.geometry.layers))
        piece = next((one for one in self.geometry.segments if one.name == name), None)
        return () if piece is None else self.along(0, piece.start, piece.end)

    def points(self) -> Iterator[tuple[str, Place]]:
        """Observed points."""
        for point in self.geometry.points:
            line = 0 if point.below is None else self.geometry.layer_index(point.below) + 1
            yield point.name, self.below(point.x)[line]


def _corners(points: Sequence[Place]) -> tuple[Place, ...]:
    """Without those that repeat the one before."""
    return tuple(point for before, point in zip([None, *points], points, strict=False) if point != before)


def _named(section: SketchedSection) -> list[str]:
    parts = [getattr(section, name) for name in GeometrySections.model_fields]
    return sorted({name for quantity in quantities_in(parts) for name in quantity.expression.names})


def _regions(section: SketchedSection, outline: _Outline) -> Iterator[Region]:
    geometry = outline.geometry
    for index, (given, layer) in enumerate(zip(section.layers, geometry.layers, strict=True)):
        pieces = tuple(outline.layer(index))
        size = _thickness(given.thickness, layer.thickness.y if layer.thickness else None)
        if layer.bottom is not None:
            level = layer.bottom.y
            size = f"down to {number(level.min())} m" if level.min() == level.max() else ""
        yield _region(section, layer.name, "layer", size, pieces)
    for zone in geometry.zones:
        yield _region(section, zone.name, "zone", "", (_piece(outline, zone),))
    bands: dict[str, list[tuple[Place, ...]]] = {}
    for cut in geometry.cuts:
        if cut.width is not None and cut.region is not None:
            half, last = 0.5 * cut.width, geometry.layer_index(cut.through) + 1
            left, right = ((cut.x + d, cut.x_bottom + d) for d in (-half, half))
            bands.setdefault(cut.region, []).append(outline.between(0, last, left, right))
    for name, found in bands.items():
        yield _region(section, name, "zone", "", tuple(found))


def _thickness(given: Any, values: FloatArray | None) -> str:
    if values is None:
        return ""
    low, high = float(values.min()), float(values.max())
    if low < high:
        return f"{number(low)} to {number(high)} m"
    return f"{given.expression.text} = {ground_length(low)}" if isinstance(given, Quantity) else ground_length(low)


def _piece(outline: _Outline, zone: Extent) -> tuple[Place, ...]:
    assert zone.layer is not None
    upper = outline.geometry.layer_index(zone.layer)
    left, right = outline.below(zone.start), outline.below(zone.end)
    ends = [(places[upper][0], places[upper + 1][0]) for places in (left, right)]
    return outline.between(upper, upper + 1, ends[0], ends[1])


def _region(section: SketchedSection, name: str, kind: Any, size: str, pieces: tuple[tuple[Place, ...], ...]) -> Region:
    materials = _materials(section, name)
    last = section.materials.get(materials[-1]) if materials else None
    law = "" if last is None or isinstance(last, InterfaceSection) else last.law.replace("_", " ")
    active, since, removed = True, "", ""
    for phase in section.phases:
        if name in phase.deactivate:
            active, removed = False, phase.name
        if name in phase.activate:
            since, active = "" if active else phase.name, True
    return Region(name, kind, size, materials, law, pieces, since, "" if active else removed)


def _materials(section: SketchedSection, part: str) -> tuple[str, ...]:
    found: list[str] = []
    for phase in section.phases:
        one = phase.materials.get(part)
        if one is not None and (not found or found[-1] != one):
            found.append(one)
    return tuple(found)


def _interfaces(section: SketchedSection, outline: _Outline) -> Iterator[Interface]:
    geometry = outline.geometry
    for cut in geometry.cuts:
        last = geometry.layer_index(cut.through) + 1
        lines = []
        for shift in (0.0,) if cut.width is None else (-0.5 * cut.width, 0.5 * cut.width):
            top = outline.along(0, cut.x + shift, cut.x + shift)[0]
            lines.append((top, outline.along(last, cut.x_bottom + shift, cut.x_bottom + shift)[0]))
        yield Interface(cut.name, tuple(lines), _materials(section, cut.name))
    for slip in geometry.interfaces:
        assert slip.layer is not None
        line = geometry.layer_index(slip.layer) + 1
        ends = [outline.below(x)[line][0] for x in (slip.start, slip.end)]
        yield Interface(slip.name, (outline.along(line, ends[0], ends[1]),), _materials(section, slip.name))


def _loads(section: SketchedSection, outline: _Outline) -> Iterator[BoundaryLoad]:
    """The last load of every boundary that is not zero."""
    given_loads = [load for phase in section.phases for load in phase.loads]
    acting = [load for load in given_loads if any((load.pressure, load.pressure_increase, load.x, load.y))]
    for name, load in {load.boundary: load for load in acting}.items():
        line = outline.boundary(name)
        if not line:
            continue
        told = _told(load)
        level = _known(load.level, section.nominal)
        if load.pressure or load.pressure_increase:
            base, grows = (_known(one, section.nominal) for one in (load.pressure, load.pressure_increase))
            water = level if base == 0.0 and grows is not None and _WATER[0] <= grows <= _WATER[1] else None
            base = _sign(load.pressure) if base is None else base  # as if it were 1, with its sign
            grows = _sign(load.pressure_increase) if grows is None else grows
            sizes = [base + grows * ((level or 0.0) - y) for _, y in line]
            yield BoundaryLoad(name, line, told, None, _parts(sizes), water)
        for given, towards in ((load.x, (1.0, 0.0)), (load.y, (0.0, 1.0))):
            if given:
                value = _known(given, section.nominal)
                sign = _sign(given) if value is None else -1.0 if value < 0.0 else 1.0
                yield BoundaryLoad(name, line, told, (sign * towards[0], sign * towards[1]), tuple(1.0 for _ in line))


def _parts(sizes: Sequence[float]) -> tuple[float, ...]:
    most = max(abs(one) for one in sizes)
    return tuple(one / most if most > 0.0 else 0.0 for one in sizes)


def _known(given: Any, values: Mapping[str, float]) -> float | None:
    """A number; None where it depends on parameters that have no nominal value."""
    if isinstance(given, Quantity) and not set(given.expression.names) <= values.keys():
        return None
    return value_of(given, values)


def _sign(given: Any) -> float:
    """That of an expression whose value is not known: as it is written."""
    return -1.0 if given.expression.text.lstrip().startswith("-") else 1.0


def _shown(given: Any) -> str:
    return given.expression.text if isinstance(given, Quantity) else number(given)


def _told(load: LoadSection) -> str:
    parts = []
    if load.pressure:
        parts.append(f"{_shown(load.pressure)} kPa")
    if load.pressure_increase:
        grown = f"{_shown(load.pressure_increase)} kPa/m"
        parts.append(f"{grown} below {_shown(load.level)} m")
    parts += [f"{_shown(given)} kPa along {axis}" for axis, given in (("x", load.x), ("y", load.y)) if given]
    return " + ".join(parts)


def _supports(section: SketchedSection, outline: _Outline) -> tuple[Support, ...]:
    """What is held in the last phase; pieces of a side that are held alike are one."""
    found: list[Support] = []
    state: dict[str, Fixity] = {}
    sides = [f".{layer.name}" for layer in outline.geometry.layers]
    for fixities in (section.fixities, *(phase.fixities for phase in section.phases)):
        for name, how in fixities.items():
            for piece in [f"{name}{side}" for side in sides] if name in ("left", "right") else [name]:
                state[piece] = how
    for name, how in state.items():
        line = outline.boundary(name)
        if how == "free" or not line or line[0] == line[-1]:
            continue
        if found and found[-1].how == how and found[-1].line[-1] == line[0]:
            line = (*found.pop().line[:-1], line[-1])
        found.append(Support(name, line, how))
    return tuple(found)


def _phases(section: SketchedSection) -> Iterator[Phase]:
    zero = section.zero_at_phase or next((one.name for one in section.phases if one.kind == "creep"), "")
    for phase in section.phases:
        duration = ""
        if phase.duration is not None:
            days = _known(phase.duration, section.nominal)
            duration = f"{_shown(phase.duration)} day"
            if days is not None and days >= _YEAR:
                duration += f" ({days / _YEAR:.3g} years)"
        yield Phase(phase.name, phase.kind, duration, tuple(_changes(phase)), phase.name == zero)


def _changes(phase: PhaseSection) -> Iterator[str]:
    parts: dict[str, list[str]] = {}
    for part, material in phase.materials.items():
        parts.setdefault(material, []).append(part)
    for material, names in parts.items():
        yield f"{', '.join(names)}: {material}"
    if phase.activate:
        yield f"placed: {', '.join(phase.activate)}"
    if phase.deactivate:
        yield f"removed: {', '.join(phase.deactivate)}"
    loads: dict[str, list[str]] = {}
    for load in phase.loads:
        loads.setdefault(_told(load) or "0 kPa", []).append(load.boundary)
    for value, names in loads.items():
        yield f"load on {', '.join(names)}: {value}"
    fixities: dict[str, list[str]] = {}
    for boundary, how in phase.fixities.items():
        fixities.setdefault("free" if how == "free" else f"held ({how})", []).append(boundary)
    for told, names in fixities.items():
        yield f"{told}: {', '.join(names)}"
    if phase.updated_mesh:
        yield "large deformations"
    if phase.reset_displacements:
        yield "displacements are zero before it"


def _programme(section: SketchedSection) -> tuple[Panel, ...]:
    """Even loads over time, where there are such and time passes."""
    steps: dict[str, list[tuple[float, float]]] = {}
    time = 0.0
    for phase in section.phases:
        for load in phase.loads:
            value = _known(load.pressure, section.nominal)
            if value is None or load.pressure_increase or load.x or load.y:
                return ()
            track = steps.setdefault(load.boundary, [(0.0, 0.0)])
            track += [(time, track[-1][1]), (time, value)]
        time += 0.0 if phase.duration is None else _known(phase.duration, section.nominal) or 0.0
    if time == 0.0 or not steps:
        return ()
    tracks = []
    for name, points in steps.items():
        corners = _corners([*points, (time, points[-1][1])])
        changes = (at for at, (before, after) in enumerate(pairwise(corners), 1) if before[1] != after[1])
        tracks.append(Track(name, corners, marks=tuple(changes)))
    return (Panel("Loads over time.", "p", "kPa", "time", "day", tuple(tracks)),)
