"""The geometry of a section in a problem file, and its numbers for given parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, TypeAlias

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.fem.mesh.cross_section import Cut, Extent, Layer, Profile, SectionGeometry, SurfacePoint
from geoswarm.solver.forward.continuum.quantity import Length, LineValueRange, Positive, value_of

__all__ = [
    "CutSection",
    "ExtentSection",
    "GeometrySections",
    "LayerSection",
    "Line",
    "Name",
    "PointSection",
    "SlipSection",
    "ZoneSection",
    "profile_of",
]

Name: TypeAlias = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=50)]
"""A name of a region, boundary, point ..."""

Line: TypeAlias = Annotated[Any, LineValueRange("m", fewest=2, number=False)]
"""Points [x, y], x increasing."""


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class LayerSection(_Section):
    """One layer, from the surface or the layer above it down."""

    name: Name = Field(description="Name of the layer and of its region.")
    thickness: Annotated[Any, LineValueRange("m", 0.0)] | None = Field(
        None, description="Vertical thickness, m: one number, or points [x, thickness]; or give bottom."
    )
    bottom: Annotated[Any, LineValueRange("m")] | None = Field(
        None,
        description="Height of the bottom, m: one number, or points [x, y]; the layer ends where it meets its top.",
    )
    rows: int = Field(1, ge=1, le=50, description="Rows of elements over the thickness.")
    grading: float = Field(1.0, gt=0.01, lt=100.0, description="Height of the lowest row over that of the uppermost.")

    @model_validator(mode="after")
    def _one_of_two(self) -> LayerSection:
        if (self.thickness is None) == (self.bottom is None):
            raise ValueError(f"layer {self.name}: give exactly one of thickness and bottom")
        return self


class CutSection(_Section):
    """A crack or secondary shear zone: it runs straight from the surface to the bottom of a layer.

    The body is open along it: an interface, or with a width one on each side of a band.
    """

    name: Name = Field(description="Name of the interface.")
    x: Length = Field(description="x of its middle at the surface, m.")
    x_bottom: Length | None = Field(None, description="x at its lower end, m; the same as x unless given.")
    through: Name = Field(description="The lowest layer that it cuts.")
    width: Positive | None = Field(None, description="Horizontal width of the band, m; without it one interface.")
    region: Name | None = Field(None, description="Region of the band; the layers run through unless given.")

    @model_validator(mode="after")
    def _band(self) -> CutSection:
        if self.region is not None and self.width is None:
            raise ValueError(f"cut {self.name}: a region needs a width above 0 m")
        return self


class ExtentSection(_Section):
    """A named piece of the surface, for loads."""

    name: Name = Field(description="Name of the boundary.")
    start: Length = Field(description="x of its left end, m.")
    end: Length = Field(description="x of its right end, m.")


class ZoneSection(ExtentSection):
    """A piece of a layer that is a region of its own."""

    name: Name = Field(description="Name of the region.")
    layer: Name = Field(description="The layer of which it is a piece.")


class SlipSection(ExtentSection):
    """A piece of the bottom of a layer along which the body may slide: an interface."""

    name: Name = Field(description="Name of the interface.")
    layer: Name = Field(description="The layer whose bottom it is.")


class PointSection(_Section):
    """A point whose displacement is calculated, at the surface or straight below it."""

    x: Length = Field(description="x at the surface, m.")
    below: Name | None = Field(None, description="At the bottom of this layer; at the surface unless given.")


class GeometrySections(_Section):
    """What describes the geometry of a section; mixed into the section of the forward model."""

    surface: Line = Field(description="Surface line from left to right: points [x, y], m.")
    layers: list[LayerSection] = Field(min_length=1, max_length=50, description="Layers from the surface down.")
    cuts: list[CutSection] = Field(default=[], max_length=20, description="Cracks and secondary shear zones.")
    zones: list[ZoneSection] = Field(default=[], max_length=50, description="Pieces of layers with their own region.")
    slips: list[SlipSection] = Field(default=[], max_length=20, description="Interfaces along bottoms of layers.")
    segments: list[ExtentSection] = Field(default=[], max_length=50, description="Named pieces of the surface.")
    points: dict[Name, PointSection] = Field(min_length=1, max_length=200, description="Observation points by name.")
    element_length: Annotated[Any, LineValueRange("m", 0.0, lower_open=True)] = Field(
        description="Width of the columns of elements, m: one number, or points [x, width]."
    )

    @model_validator(mode="after")
    def _known_layers(self) -> GeometrySections:
        known = [layer.name for layer in self.layers]
        users: list[tuple[str, str | None]] = [
            *((f"cut {cut.name}", cut.through) for cut in self.cuts),
            *((f"zone {zone.name}", zone.layer) for zone in self.zones),
            *((f"slip {slip.name}", slip.layer) for slip in self.slips),
            *((f"point {name}", point.below) for name, point in self.points.items()),
        ]
        for user, layer in users:
            if layer is not None and layer not in known:
                raise ValueError(f"{user}: layer {layer} is unknown; known layers: {', '.join(known)}")
        names = [
            *known,
            *dict.fromkeys(cut.region for cut in self.cuts if cut.region is not None),
            *(cut.name for cut in self.cuts),
            *(extent.name for extent in (*self.zones, *self.slips, *self.segments)),
        ]
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(
                f"the name {twice[0]} is given twice; layers, cuts, zones, slips and segments need their own"
            )
        return self

    def geometry(self, values: Mapping[str, float]) -> SectionGeometry:
        """Geometry for parameters by name.

        Raises
        ------
        InfeasibleError
            A number is outside its range, or the points of a line do not follow one another.
        """

        def number(given: Any) -> float:
            return value_of(given, values)

        return SectionGeometry(
            surface=profile_of(self.surface, values, "surface"),
            layers=tuple(
                Layer(
                    layer.name,
                    layer.rows,
                    None if layer.thickness is None else profile_of(layer.thickness, values, f"layer {layer.name}"),
                    None if layer.bottom is None else profile_of(layer.bottom, values, f"layer {layer.name}"),
                    layer.grading,
                )
                for layer in self.layers
            ),
            cuts=tuple(
                Cut(
                    cut.name,
                    number(cut.x),
                    number(cut.x if cut.x_bottom is None else cut.x_bottom),
                    cut.through,
                    None if cut.width is None else number(cut.width),
                    cut.region,
                )
                for cut in self.cuts
            ),
            points=tuple(SurfacePoint(name, number(point.x), point.below) for name, point in self.points.items()),
            segments=tuple(Extent(s.name, number(s.start), number(s.end)) for s in self.segments),
            zones=tuple(Extent(z.name, number(z.start), number(z.end), z.layer) for z in self.zones),
            interfaces=tuple(Extent(s.name, number(s.start), number(s.end), s.layer) for s in self.slips),
        )


def profile_of(line: Any, values: Mapping[str, float], name: str) -> Profile:
    """Line over x of one number, or of points.

    Raises
    ------
    InfeasibleError
        x does not increase from point to point.
    """
    if not isinstance(line, list):
        return Profile(np.zeros(1), np.array([value_of(line, values)]))
    points = np.array([[value_of(x, values), value_of(y, values)] for x, y in line])
    if (np.diff(points[:, 0]) <= 0.0).any():
        first = int(np.argmax(np.diff(points[:, 0]) <= 0.0))
        raise InfeasibleError(
            f"{name}: x = {points[first + 1, 0]:g} m follows x = {points[first, 0]:g} m; x must increase"
        )
    return Profile(points[:, 0], points[:, 1])
