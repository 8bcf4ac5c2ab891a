"""What a test says of itself, for its sketch: a specimen or the ground, what acts on it, and the loading programme."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

__all__ = ["Drains", "End", "Ground", "Layer", "Load", "Panel", "Reading", "Sketch", "SpecimenSketch", "Track"]

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
    """Everything of one test: its name in words, the specimen or the ground, and the programme."""

    test: str
    body: SpecimenSketch | Ground
    programme: tuple[Panel, ...]
