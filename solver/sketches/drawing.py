"""A sketch as drawings, each with the same in words."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from geoswarm.solver.sketches.declared import CrossSection, Ground, Sketch, SpecimenSketch
from geoswarm.solver.sketches.ground import draw_ground
from geoswarm.solver.sketches.legend import draw_legend, legend_words
from geoswarm.solver.sketches.panels import draw_programme
from geoswarm.solver.sketches.phases import draw_phases, phase_text
from geoswarm.solver.sketches.section import draw_section, enlarged, size_of
from geoswarm.solver.sketches.shapes import Drawing
from geoswarm.solver.sketches.specimen import draw_specimen
from geoswarm.solver.sketches.ticks import ground_length, number, specimen_length

__all__ = ["DrawnSketch", "Told", "drawings"]

_MOST_NAMED = 12
_HELD = {
    "ring": "in a ring that holds its side",
    "membrane": "in a membrane under cell pressure",
    "sliding rings": "between rings that slide on each other",
}


@dataclass(frozen=True, slots=True)
class Told:
    """A drawing, its heading, and the same in words."""

    heading: str
    drawing: Drawing
    words: str


@dataclass(frozen=True, slots=True)
class DrawnSketch:
    """A sketch and its drawings."""

    sketch: Sketch
    drawings: tuple[Told, ...]

    @property
    def words(self) -> str:
        """The same in words."""
        return " ".join(one.words for one in self.drawings)


def drawings(sketch: Sketch) -> tuple[Told, ...]:
    """The specimen or the ground, then phases and the loading programme where there are such."""
    if isinstance(sketch.body, Ground):
        body = Told(sketch.test, draw_ground(sketch.body), _of_ground(sketch.body))
    elif isinstance(sketch.body, CrossSection):
        body = Told(sketch.test, draw_section(sketch.body), _of_section(sketch.body))
    else:
        body = Told(sketch.test, draw_specimen(sketch.body), _of_specimen(sketch.body))
    found = [body]
    if isinstance(sketch.body, CrossSection):
        found.append(Told("Legend", draw_legend(sketch.body), legend_words(sketch.body)))
    if sketch.phases:
        named = [phase_text(phase) for phase in sketch.phases]
        found.append(Told("Phases", draw_phases(sketch.phases), f"Phases: {_listed(named)}."))
    if sketch.programme:
        words = " ".join(panel.words for panel in sketch.programme)
        found.append(Told("Loading programme", draw_programme(sketch.programme), words))
    return tuple(found)


def _of_specimen(one: SpecimenSketch) -> str:
    size = [f"height h = {specimen_length(one.height)}"] if one.height is not None else []
    size += [f"diameter d = {specimen_length(one.diameter)}"] if one.diameter is not None else []
    parts = [f"Specimen of {one.material}, {_HELD[one.held]}{''.join(f', {text}' for text in size)}."]
    acting = [load for load in (one.vertical, one.lateral, one.shear) if load is not None]
    parts.append(f"It bears {', '.join(dict.fromkeys(f'{load.symbol}: {load.words}' for load in acting))}.")
    parts.append(_drainage(one))
    if one.readings:
        parts.append(f"Measured: {', '.join(f'{reading.symbol}: {reading.words}' for reading in one.readings)}.")
    if one.remark:
        parts.append(one.remark)
    return " ".join(parts)


def _drainage(one: SpecimenSketch) -> str:
    ends = {"top": one.top, "base": one.base}
    drained = [name for name, end in ends.items() if end == "drained"]
    if not drained:
        shut = "shut" in ends.values()
        text = "No water leaves while it is sheared" if shut else "No water leaves"
    else:
        text = f"Water leaves through porous stones at {' and '.join(drained)}"
        if len(drained) == 1:
            text = f"Water leaves through a porous stone at the {drained[0]}"
            text += "".join(f", the {name} is closed" for name, end in ends.items() if end == "closed")
    if one.back_pressure > 0.0:
        text += f"; back pressure u₀ = {one.back_pressure:g} kPa"
    return f"{text}."


def _of_ground(ground: Ground) -> str:
    layers = [f"{one.soil} ({one.material}), {ground_length(one.thickness)}" for one in ground.layers[:_MOST_NAMED]]
    left = len(ground.layers) - len(layers)
    parts = [f"Layers from the ground surface: {'; '.join(layers)}{f'; and {left} further layers' if left else ''}."]
    parts.append(f"{ground.load.symbol}: {ground.load.words}.")
    if ground.water_table >= 0.0:
        parts.append(f"Water table {ground_length(ground.water_table)} below the surface.")
    else:
        parts.append(f"Free water stands {ground_length(-ground.water_table)} above the surface.")
    base = "and at the base" if ground.base_drained else "; the base is closed"
    parts.append(f"Water leaves at the surface{' ' if ground.base_drained else ''}{base}.")
    if ground.drains is not None:
        drains = ground.drains
        top, bottom, spacing = (ground_length(one) for one in (drains.top, drains.bottom, drains.spacing))
        parts.append(f"Vertical drains from {top} to {bottom}, {spacing} apart.")
    if ground.instruments:
        named = ", ".join(f"{name} in {ground_length(depth)}" for name, depth in ground.instruments[:_MOST_NAMED])
        left = len(ground.instruments) - _MOST_NAMED
        parts.append(f"Instruments: {named}{f' and {left} more' if left > 0 else ''}.")
    return " ".join(parts)


def _listed(texts: Sequence[str]) -> str:
    """Texts after each other, the first ones of many."""
    left = len(texts) - _MOST_NAMED
    return "; ".join(texts[:_MOST_NAMED]) + (f"; and {left} more" if left > 0 else "")


def _of_section(section: CrossSection) -> str:
    wide, tall = size_of(section)
    parts = [f"Vertical section, {number(round(wide, 3))} m wide and {number(round(tall, 3))} m high."]
    if section.given:
        parts.append(f"Drawn for {_listed([f'{name} = {value:g}' for name, value in section.given])}.")
    if enlarged(section) > 1.0:
        parts.append(f"Heights are drawn {enlarged(section):g} times larger than widths.")
    return " ".join(parts)
