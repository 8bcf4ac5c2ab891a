"""Groups of an AGS 4 file; their cells as texts and numbers, with errors that name file, line, group and heading."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

from geoswarm.solver.errors import SolverError
from geoswarm.solver.problem.tables.numerals import two_readings
from geoswarm.solver.problem.tables.reading import cell_number
from geoswarm.solver.units import UnitError, convert
from geoswarm.solver.words import visible

__all__ = ["AgsError", "AgsFile", "AgsGroup", "AgsRow"]

_SHOWN = 60
_SMALLEST, _LARGEST = 1e-12, 1e12
"""Amounts in base units, between which calculations with them stay finite."""
_UNITS = {"deg": "degree", "hr": "h", "yr": "year", "sec": "s"}
"""Units of the dictionary that other programs write otherwise."""


class AgsError(SolverError):
    """A file cannot be read as AGS 4, or what it says makes no problem."""


@dataclass(frozen=True, slots=True)
class AgsRow:
    """One DATA row: number of its line, and its cells in the order of the headings."""

    line: int
    cells: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class AgsGroup:
    """A group.

    Parameters
    ----------
    file
        Name of the file, for messages.
    name, line
        Of the group, and the line where it begins.
    headings, units, types
        One a column; units and types are empty where the file has no such row.
    rows
        Its data.
    """

    file: str
    name: str
    line: int
    headings: tuple[str, ...]
    units: tuple[str, ...]
    types: tuple[str, ...]
    rows: tuple[AgsRow, ...]

    def text(self, row: AgsRow, heading: str) -> str:
        """What a cell holds; nothing where the group has no such heading."""
        return row.cells[self.headings.index(heading)].strip() if heading in self.headings else ""

    def unit(self, heading: str) -> str:
        """Unit of a column; nothing where it has none."""
        return self.units[self.headings.index(heading)].strip() if heading in self.headings and self.units else ""

    def number(
        self,
        row: AgsRow,
        heading: str,
        base: str,
        *,
        above: float | None = None,
        least: float | None = None,
        default_unit: str = "",
    ) -> float | None:
        """Return the number in a cell; None where it is empty or the group has no such heading.

        Parameters
        ----------
        base
            Unit that it is given in.
        above, least
            What it must be above, or at least, in ``base``.
        default_unit
            Unit of the dictionary, where the column names none.

        Raises
        ------
        AgsError
            It is not a number, outside these limits, or the unit of the column is of another kind.
        """
        text = self.text(row, heading)
        if not text:
            return None
        value = cell_number(text)
        bound = f" above {above:g}" if above is not None else f" of at least {least:g}" if least is not None else ""
        accepted = f"a number{bound}{f' {base}' if base else ''} is accepted"
        if value is None:
            raise self.error(row, heading, accepted)
        if "," in text and len(both := set(two_readings(text).values())) > 1:
            either = " or ".join(f"{one:g}" for one in sorted(both))
            raise self.error(row, heading, f"it can be {either}; write it with a decimal point, without a comma")
        try:
            value = float(convert(value, _pint(self.unit(heading) or default_unit), base or "1"))
        except UnitError as error:
            raise AgsError(f"{self.file} line {self.line}: group {self.name}, heading {heading}: {error}") from None
        if (above is not None and value <= above) or (least is not None and value < least):
            raise self.error(row, heading, accepted)
        if value != 0.0 and not _SMALLEST <= abs(value) <= _LARGEST:
            raise self.error(row, heading, f"{accepted}, of an amount between {_SMALLEST:g} and {_LARGEST:g}")
        return value

    def needed(self, row: AgsRow, heading: str, base: str, *, above: float = 0.0, default_unit: str = "") -> float:
        """Return the number in a cell that must have one; raises as :meth:`number`, or where it is empty."""
        value = self.number(row, heading, base, above=above, default_unit=default_unit)
        if value is None:
            raise self.error(row, heading, f"a number above {above:g}{f' {base}' if base else ''} is accepted")
        return value

    def error(self, row: AgsRow, heading: str, accepted: str) -> AgsError:
        """Return an error about a cell."""
        if heading not in self.headings:
            return AgsError(f"{self.file} line {self.line}: group {self.name} has no heading {heading}; {accepted}")
        shown = visible(self.text(row, heading))
        shown = shown if len(shown) <= _SHOWN else f"{shown[:_SHOWN]}..."
        told = f"'{shown}'" if shown else "the empty cell"
        return AgsError(f"{self.file} line {row.line}: group {self.name}, heading {heading}: {told}: {accepted}")


@dataclass(frozen=True, slots=True)
class AgsFile:
    """A file: its name and its groups by their names; ``damaged`` are lines that break the format, with what was done.

    Each is the name of a group and a sentence.
    """

    name: str
    groups: Mapping[str, AgsGroup]
    damaged: tuple[tuple[str, str], ...] = ()


@lru_cache(maxsize=256)
def _pint(unit: str) -> str:
    """Return a unit of the dictionary as the registry of units knows it: ``kN/m2`` is ``kN/m^2``, ``%/hr`` ``%/h``."""
    words = re.sub(r"[A-Za-z]+", lambda word: _UNITS.get(word[0], word[0]), unit)
    return re.sub(r"(?<=[A-Za-z])(?=-?\d)", "^", words)
