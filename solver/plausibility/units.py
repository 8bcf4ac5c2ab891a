"""The unit in which a number was probably meant."""

from __future__ import annotations

from collections.abc import Callable

from geoswarm.solver.units import convert

__all__ = ["meant_unit", "with_unit"]

_CANDIDATES = {
    "m": ("mm", "cm", "um"),
    "kPa": ("Pa", "MPa", "bar"),
    "day": ("h", "min", "s"),
    "degree": ("rad",),
    "kN/m³": ("N/m^3",),
    "": ("%",),
    "1": ("%",),
    "dimensionless": ("%",),
}
"""What is mistaken for a base unit, the likeliest first."""


def meant_unit(value: float, base: str, usual: Callable[[float], bool]) -> tuple[str, float] | None:
    """Return the unit in which a value is a usual one, and that value in the base unit; None where there is none."""
    for unit in _CANDIDATES.get(base, ()):
        moved = float(convert(value, unit, base.replace("³", "^3")))
        if usual(moved):
            return unit, moved
    return None


def with_unit(value: float, unit: str) -> str:
    """A value as a sentence shows it."""
    return f"{value:.6g}{'' if unit in ('', '1', 'dimensionless') else f' {unit}'}"
