"""The unit of x or y of an observation: the one given, or that of the column, never a guess."""

from __future__ import annotations

from geoswarm.solver.forward.base import SeriesInfo
from geoswarm.solver.problem.issues import number
from geoswarm.solver.problem.tables.alterations import Alteration
from geoswarm.solver.problem.tables.headings import Heading, best_unit, unclear_unit
from geoswarm.solver.problem.tables.picking import is_cells
from geoswarm.solver.sentences import Sentence, setting
from geoswarm.solver.units import UnitError, convert, same_unit

__all__ = ["UNSTATED", "USUAL", "divided_by_size", "unit_of_axis", "unit_of_data"]

UNSTATED = "unstated"
"""Instead of a unit, where readings come from a file that names none: right for numbers without dimension only."""
USUAL = {"m": "mm, cm or m", "day": "s, min, h or day", "kPa": "kPa, MPa or kg/cm2", "degree": "degree or rad"}
"""Units that laboratories write, as examples."""


def unit_of_axis(
    axis: str, given: str | None, info: SeriesInfo, heading: Heading | None
) -> tuple[str | None, Sentence | None]:
    """Unit of the data along x or y of a series, and what is wrong, as :func:`unit_of_data`."""
    quantity, base = (info.x_quantity, info.x_unit) if axis == "x" else (info.y_quantity, info.y_unit)
    needed = "strain" in quantity  # in per cent as often as not
    return unit_of_data(axis, given, base, heading, unitless=info.x_quantity == "x", needed=needed)


def unit_of_data(
    axis: str, given: str | None, base: str, heading: Heading | None, *, unitless: bool, needed: bool = False
) -> tuple[str | None, Sentence | None]:
    """Unit of the data: the one given, that of the heading where it fits the series, or None; and what is wrong.

    ``unitless``: a formula or a program, whose series without a unit take the numbers as they are. ``needed``: pure
    numbers need a unit, too, as strains do.
    """
    pure = same_unit(base, "1") and not needed
    key = setting(f"{axis}_unit")
    usual = setting(f"{axis}_unit", USUAL.get(base, base or "'%' or dimensionless"))
    if given == UNSTATED:
        return None, None if pure else ("the file names no known unit; give ", usual)
    if heading is None:
        return given, None
    column = f"column '{heading.name}'"
    if given is not None:
        if heading.dates and not same_unit(given, "day"):
            return given, (f"{column} holds dates, which are read as days: leave ", key, f" out, not {given}")
        if heading.in_cells and heading.unit is not None and not same_unit(given, heading.unit):
            return given, (f"the cells of {column} are in {heading.unit}: leave ", key, f" out, not {given}")
        return given, None
    possible = [one for one in heading.named if one.unit is None or _factor(one.unit, base) is not None]
    unclear, best = unclear_unit(possible), best_unit(possible)
    altered = next((one.alters for one in possible if one.alters is not None), None)
    if best is not None and unclear is None:
        return best.unit, None
    if best is not None:
        return None, (
            f"{column} {unclear}",
            *_remedy(axis, altered, (base or "dimensionless") if altered == "share" else best.unit or base),
        )
    if unitless and same_unit(base, "1"):
        return None, None
    if altered == "share":
        return None, (f"{column} {unclear}", *_remedy(axis, altered, base or "dimensionless"))
    other = f"but the series {'has' if axis == 'y' else 'needs'} {base}; name another"
    if heading.certain and heading.unit is not None:
        if divided := _divided(axis, heading.unit, base):
            return None, (f"{column} is in {heading.unit}, ", *divided)
        if same_unit(base, "1"):
            return None, (f"{column} is in {heading.unit}, but the series has no unit; name another column",)
        return None, (f"{column} is in {heading.unit}, {other}, or give ", key)
    if unclear is not None:
        return None, (f"{column} {unclear}; ", key, " says what the numbers are in")
    if pure:
        return None, None
    shown = ", ".join(number(value) for value in heading.first)
    if heading.unit is not None:
        return None, (f"{column} ({shown}, ...) may be in {heading.unit}, {other} column, or give ", usual)
    brackets = "" if is_cells(heading.name) else ", or write it in brackets behind the name in the file"
    return None, (f"{column} ({shown}, ...) has no unit; give ", usual, *([brackets] if brackets else []))


def _remedy(axis: str, altered: Alteration | None, unit: str) -> Sentence:
    """What to do about numbers that are not in the unit beside them; each of the ways is enough."""
    key, factor = setting(f"{axis}_unit"), setting(f"{axis}_factor")
    match altered:
        case None:
            return "; ", key, " says which holds"
        case "factor":
            return "; give ", factor, ", which multiplies, or ", key, ", which says what the numbers are in"
        case "offset" if axis == "y":
            return "; give ", setting("y_zero"), ", which is subtracted, or ", key, ", which says that none is"
        case "sign":
            return "; give ", setting(factor.path, "-1"), ", or 1 where the numbers have the sign of the series"
        case "absolute":
            column = (" (", setting("y_minus"), " takes a column of it)") if axis == "y" else ()
            return "; subtract that of the atmosphere", *column, " and give ", setting(key.path, unit)
        case "share":
            both = setting(key.path, unit), " and ", setting(factor.path, "full scale / 100")
            return "; give the unit of the gauge and its range, such as ", *both
        case _:
            return "; give the quantity itself, or ", key, ", which says what the numbers are in"


def _divided(axis: str, unit: str, base: str) -> Sentence:
    """What to do about a force where a stress is needed, and a length where a strain may be; nothing for others."""
    found = divided_by_size(unit, base)
    if found is None:
        return ()
    factor, size, metres = found
    keys = setting(f"{axis}_unit", base or "dimensionless"), " and ", setting(f"{axis}_factor", factor)
    if base == "kPa":
        what = "a force, but the series needs a stress; name a column of stresses"
    else:
        what = "a length, but the series has no unit; name another column"
    return (f"{what}, or give ", *keys, f" with the {size} in {metres} of the specimen")


def divided_by_size(unit: str, base: str) -> tuple[str, str, str] | None:
    """The factor that makes a stress of a force, or a strain of a length; the size of the specimen in it, and its unit.

    >>> divided_by_size("mm", ""), divided_by_size("kN", "m")
    (('0.001 / H', 'height H', 'm'), None)
    """
    if base == "kPa" and (kilonewtons := _factor(unit, "kN")) is not None:
        return f"{kilonewtons:g} / A", "area A", "m2"
    if same_unit(base, "1") and (metres := _factor(unit, "m")) is not None:
        return f"{metres:g} / H", "height H", "m"
    return None


def _factor(unit: str, base: str) -> float | None:
    try:
        return float(convert(1.0, unit, base))
    except UnitError:
        return None
