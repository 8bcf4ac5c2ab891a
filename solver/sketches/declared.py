"""What a test says of itself, for its sketch: a specimen or the ground, what acts on it, and the loading programme."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = [
    "CrossSection",
    "Drains",
    "End",
    "Ground",
    "Support",
    "Layer",
    "Load",
    "Panel",
    "Phase",
    "Place",
    "BoundaryLoad",
    "Reading",
    "Region",
    "Interface",
    "Sketch",
    "SpecimenSketch",
    "Track",
]

End: TypeAlias = Literal["drained", "shut", "closed"]
"""Of a specimen: a porous stone where water leaves, one whose valve is shut, or a plate that lets no water through."""


@dataclass(frozen=True, slots=True)
class Load:
    """What acts: its symbol, and what it is in words."""

    symbol: str
    words: str


@dataclass(frozen=True, slots=True)
class Reading:
    """What is measured: its symbol, what it is in words, and where.

    ``water``: on what leaves the specimen; ``inside``: at mid-height.
    """

    symbol: str
    words: str
    where: Literal["top", "base", "side", "inside", "water"]


@dataclass(frozen=True, slots=True)
class SpecimenSketch:
    """A specimen in its apparatus.

    Parameters
    ----------
    material
        Name of its law.
    held
        What holds the side: a ring, a membrane in a cell, or rings that slide on each other.
    vertical, lateral, shear
        What acts on top, on the side, and along the top; None: nothing.
    top, base
        Whether water leaves there.
    height, diameter
        m; None where the problem does not give them.
    back_pressure
        Of the water that leaves, kPa; 0 is not shown.
    readings
        What is measured.
    remark
        What else there is to say, a sentence.
    """

    material: str
    held: Literal["ring", "membrane", "sliding rings"]
    vertical: Load
    lateral: Load | None = None
    shear: Load | None = None
    top: End = "drained"
    base: End = "drained"
    height: float | None = None
    diameter: float | None = None
    back_pressure: float = 0.0
    readings: tuple[Reading, ...] = ()
    remark: str = ""


@dataclass(frozen=True, slots=True)
class Layer:
    """A layer of ground: name of its soil, law, and thickness, m."""

    soil: str
    material: str
    thickness: float


@dataclass(frozen=True, slots=True)
class Drains:
    """Vertical drains: depths of their ends, and distance of their axes, m."""

    top: float
    bottom: float
    spacing: float


@dataclass(frozen=True, slots=True)
class Ground:
    """Layers from the ground surface downwards, where water leaves.

    Parameters
    ----------
    load
        What acts on the ground surface.
    water_table
        Its depth, m; negative: free water stands on the ground.
    base_drained
        Whether water leaves at the base.
    instruments
        Name and depth, m.
    """

    layers: tuple[Layer, ...]
    load: Load
    water_table: float
    base_drained: bool
    drains: Drains | None = None
    instruments: tuple[tuple[str, float], ...] = ()


Place: TypeAlias = tuple[float, float]
"""x to the right and y upwards, m."""


@dataclass(frozen=True, slots=True)
class Region:
    """A region of a section.

    Parameters
    ----------
    name, kind
        Its name, and whether it is a layer, or a piece of layers that is drawn over them.
    size
        Its thickness, or where its bottom lies, in words; may be empty.
    materials
        Names of its materials in the order of the phases.
    law
        Of the last material.
    pieces
        Its corners; a layer that ends and begins again has several pieces.
    since
        Phase from which it is there; empty: from the beginning.
    removed
        Phase in which it is removed for good; empty: it stays.
    """

    name: str
    kind: Literal["layer", "zone"]
    size: str
    materials: tuple[str, ...]
    law: str
    pieces: tuple[tuple[Place, ...], ...]
    since: str = ""
    removed: str = ""


@dataclass(frozen=True, slots=True)
class Interface:
    """An interface along which the body may open or slide: its lines, and names of its materials."""

    name: str
    lines: tuple[tuple[Place, ...], ...]
    materials: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class BoundaryLoad:
    """A load on a boundary.

    Parameters
    ----------
    boundary
        Its name.
    line
        From left to right, or downwards.
    value
        In words: ``20 kPa``.
    towards
        (x, y): which way it acts; None: at right angles onto the body.
    sizes
        At both ends of the line and wherever it bends, in parts of the largest one; negative: away from the body.
    water
        Height of free water that the load is, m; None where it is none.
    """

    boundary: str
    line: tuple[Place, ...]
    value: str
    towards: Place | None
    sizes: tuple[float, ...]
    water: float | None = None


@dataclass(frozen=True, slots=True)
class Support:
    """A boundary, or a piece of it, that is held in the last phase."""

    boundary: str
    line: tuple[Place, ...]
    how: Literal["horizontal", "vertical", "both"]


@dataclass(frozen=True, slots=True)
class CrossSection:
    """A vertical section of the ground.

    Parameters
    ----------
    surface, bottom
        From left to right.
    points
        Names and places of what is observed.
    given
        What the numbers of the geometry were chosen for: names of parameters and their nominal values.
    """

    surface: tuple[Place, ...]
    bottom: tuple[Place, ...]
    regions: tuple[Region, ...]
    interfaces: tuple[Interface, ...] = ()
    points: tuple[tuple[str, Place], ...] = ()
    loads: tuple[BoundaryLoad, ...] = ()
    supports: tuple[Support, ...] = ()
    given: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True, slots=True)
class Phase:
    """A phase: its name, its kind in words, its duration with unit or nothing, what it changes, and whether time and
    displacements are zero before it."""

    name: str
    kind: str
    duration: str
    changes: tuple[str, ...]
    zero: bool = False


@dataclass(frozen=True, slots=True)
class Track:
    """How one quantity goes: corners of a line.

    Parameters
    ----------
    symbol
        Of the quantity; written at the line where there are several in a panel.
    points
        (x, y); the line is dotted up to a point that ``free`` holds, because something else is led there.
    free
        Indices of these points.
    marks
        Points at which y is written, indices.
    """

    symbol: str
    points: tuple[tuple[float, float], ...]
    free: frozenset[int] = frozenset()
    marks: tuple[int, ...] = ()


@dataclass(frozen=True, slots=True)
class Panel:
    """A part of the loading programme.

    Parameters
    ----------
    words
        What is done, in a sentence.
    symbol, unit
        Of y; no unit: a pure number.
    x, x_unit
        ``time`` with its unit, or ``stage`` without one.
    tracks
        Lines; at least one.
    cycles
        Where more cycles are meant than are drawn: x from, x to, text.
    last
        x up to which the panel goes at least.
    """

    words: str
    symbol: str
    unit: str
    x: str
    x_unit: str
    tracks: tuple[Track, ...]
    cycles: tuple[tuple[float, float, str], ...] = ()
    last: float = 0.0


@dataclass(frozen=True, slots=True)
class Sketch:
    """Everything of one test: its name in words, the specimen or the ground, the programme, and phases."""

    test: str
    body: SpecimenSketch | Ground | CrossSection
    programme: tuple[Panel, ...]
    phases: tuple[Phase, ...] = ()
