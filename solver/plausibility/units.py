"""The unit in which a number was probably meant."""

from __future__ import annotations

from collections.abc import Callable

from geoswarm.solver.units import convert, same_unit, shown_unit

__all__ = ["meant_unit", "with_unit"]

_CANDIDATES = {
    "m": ("mm", "cm", "um", "0.01 mm", "inch"),
    "kPa": ("Pa", "MPa", "bar", "kgf/cm^2", "psi"),
    "day": ("h", "min", "s"),
    "degree": ("rad",),
    "kN/m³": ("N/m^3",),
    "": ("%",),
    "1": ("%",),
    "dimensionless": ("%",),
}
"""What is mistaken for another unit, the likeliest first."""


def meant_unit(
    value: float, base: str, usual: Callable[[float], bool], *, given: str | None = None
) -> tuple[str, float] | None:
    """Return the unit in which a value is a usual one, and that value in the base unit; None where there is none.

    ``value`` is in the base unit and was given in the unit ``given``, the base unit where that is None.
    """
    base = base.replace("³", "^3")
    written = value if given is None else float(convert(value, base or "1", given or "1"))
    for unit in (base or "1", *_CANDIDATES.get(base.replace("^3", "³"), ())):
        if same_unit(unit, base if given is None else given):
            continue
        moved = float(convert(written, unit, base or "1"))
        if usual(moved):
            return unit, moved
    return None


def with_unit(value: float, unit: str) -> str:
    """A value as a sentence shows it."""
    return f"{value:.6g} {shown_unit(unit)}".rstrip()
