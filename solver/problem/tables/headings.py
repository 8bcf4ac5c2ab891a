"""The units that headings and comments of a file of measurements name."""

from __future__ import annotations

import re

from geoswarm.solver.units import UnitError, convert

__all__ = ["guess_unit", "known_unit", "units_in_comments"]

BASES = ("day", "m", "kPa", "degree", "dimensionless")
ALIASES = {
    "sec": "s",
    "secs": "s",
    "second": "s",
    "seconds": "s",
    "mins": "min",
    "minute": "min",
    "minutes": "min",
    "hr": "h",
    "hrs": "h",
    "hour": "h",
    "hours": "h",
    "d": "day",
    "days": "day",
    "weeks": "week",
    "years": "year",
    "a": "year",
    "µm": "um",
    "μm": "um",
    "kn/m2": "kN/m^2",
    "kn/m²": "kN/m^2",
    "kn/m^2": "kN/m^2",
    "mn/m²": "MPa",
    "n/mm²": "MPa",
    "kpa": "kPa",
    "mpa": "MPa",
    "°": "degree",
    "deg": "degree",
    "percent": "%",
    "-": "dimensionless",
    "1": "dimensionless",
    "–": "dimensionless",
}
"""What laboratories write, and what the registry of units (or a problem file) calls it."""

_BRACKETS = re.compile(r"^(?P<label>.*?)\s*[\[({](?P<unit>[^\])}]{0,20})[\])}]\s*$")
_BEHIND = re.compile(r"^(?P<label>.+?)(?:\s+in\s+|\s*/\s*|\s*,\s*|_)(?P<unit>[^\s,]{1,20})$", re.IGNORECASE)
_COMMENT = re.compile(r"(?<![\w.])([\w.]+) in ([^\s,;]+)")  # from the start of a word only: linear in the text


def guess_unit(heading: str) -> tuple[str, str | None, str | None]:
    """Split a heading such as ``settlement [mm]`` or ``time in min`` into label, unit and base unit."""
    heading = " ".join(heading.split())
    found = _BRACKETS.match(heading)
    if found is None or not found["label"]:
        found = _BEHIND.match(heading)
    if found is not None:
        unit, base = known_unit(found["unit"])
        if unit is not None:
            return found["label"], unit, base
    return heading, None, None


def known_unit(text: str) -> tuple[str | None, str | None]:
    """Return a unit as a problem file writes it and its base unit; None twice for what is no unit."""
    unit = ALIASES.get(text.strip().lower(), text.strip())
    if not unit:
        return None, None
    for base in BASES:
        try:
            convert([1.0], unit, base)
        except UnitError:
            continue
        return unit, base
    return None, None


def units_in_comments(comments: str) -> dict[str, str]:
    """Return what comments such as ``# x in min, y in mm`` say, by heading."""
    return dict(_COMMENT.findall(comments))
