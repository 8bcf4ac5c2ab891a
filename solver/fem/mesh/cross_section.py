"""The geometry of a layered section in plain numbers: what a mesh is built from and follows.

x runs to the right, y upwards, m. Layers lie below one another from the surface down, cuts open the upper ones.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from geoswarm.solver.arrays import FloatArray

__all__ = ["Cut", "Extent", "Layer", "Profile", "SectionGeometry", "SurfacePoint"]


@dataclass(frozen=True)
class Profile:
    """A line over x: straight between (x, y), constant beyond its ends; both (k,), x strictly increasing."""

    x: FloatArray
    y: FloatArray

    def at(self, x: FloatArray) -> FloatArray:
        """y at x, same shape."""
        found: FloatArray = np.interp(x, self.x, self.y)
        return found


@dataclass(frozen=True)
class Layer:
    """One layer.

    Parameters
    ----------
    name
        Name of its region.
    rows
        Rows of elements over its thickness.
    thickness, bottom
        One of them: vertical thickness, or height of its bottom. A bottom above the layer's top is cut off there: the
        layer ends where they cross.
    grading
        Height of the lowest row over that of the uppermost one.
    """

    name: str
    rows: int
    thickness: Profile | None = None
    bottom: Profile | None = None
    grading: float = 1.0


@dataclass(frozen=True)
class Cut:
    """A crack or shear zone that runs straight from the surface to the bottom of a layer.

    Parameters
    ----------
    name
        Name of the interface; a cut of some width has one on each side.
    x, x_bottom
        Middle of the cut at the surface and at its lower end, m.
    through
        The lowest layer that it cuts.
    width
        Horizontal width of the band between two interfaces, m; None for a single interface.
    region
        Name of the region of the band; where None, the layers run through.
    """

    name: str
    x: float
    x_bottom: float
    through: str
    width: float | None = None
    region: str | None = None


@dataclass(frozen=True)
class Extent:
    """A name for a piece of the section between two x at the surface, m.

    Without ``layer`` a piece of the surface (for loads). With it the region of the layer's elements there, or for an
    interface the bottom of the layer.
    """

    name: str
    start: float
    end: float
    layer: str | None = None


@dataclass(frozen=True)
class SurfacePoint:
    """A named point: x at the surface, or straight below it (along the cuts) at the bottom of a layer."""

    name: str
    x: float
    below: str | None = None


@dataclass(frozen=True)
class SectionGeometry:
    """A layered section.

    Parameters
    ----------
    surface
        Surface line from the left end to the right end.
    layers
        From the top down.
    cuts
        Cracks and shear zones through the upper layers.
    points
        Named points.
    segments
        Named pieces of the surface.
    zones
        Pieces of layers that are regions of their own.
    interfaces
        Pieces of bottoms of layers along which the body may slide.
    """

    surface: Profile
    layers: tuple[Layer, ...]
    cuts: tuple[Cut, ...] = ()
    points: tuple[SurfacePoint, ...] = ()
    segments: tuple[Extent, ...] = ()
    zones: tuple[Extent, ...] = ()
    interfaces: tuple[Extent, ...] = field(default_factory=tuple)

    def layer_index(self, name: str) -> int:
        """Index of a layer by its name."""
        return [layer.name for layer in self.layers].index(name)
