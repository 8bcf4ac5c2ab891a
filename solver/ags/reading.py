"""Reads a file in the AGS 4 format.

Rules of the format (AGS 4.1, rules 1 to 6 and 18): a line begins with GROUP, HEADING, UNIT, TYPE or DATA; cells are in
double quotes and separated by commas; a quote inside is doubled; a cell holds no line break. A workbook, as converters
write it, has a sheet for each group.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from geoswarm.solver.ags.tables import AgsError, AgsFile, AgsGroup, AgsRow
from geoswarm.solver.problem.tables.blocks import shown
from geoswarm.solver.problem.tables.reading import (
    MAX_CELL_CHARACTERS,
    MAX_LINE_CHARACTERS,
    MAX_TABLE_BYTES,
    TableError,
    decoded,
)
from geoswarm.solver.problem.tables.workbooks import read_workbook
from geoswarm.solver.words import visible

__all__ = ["read_ags", "read_ags_file"]

MAX_ROWS = 200_000
"""DATA rows of a group."""
MAX_COLUMNS = 500
"""Headings of a group."""

_KINDS = ("GROUP", "HEADING", "UNIT", "TYPE", "DATA")


_READ = frozenset(("CONG", "CONS", "ESCG", "ESCT", "TREG", "TRET", "TRIG", "TRIT", "MOND", "MONG"))
"""Groups of which a row is never left out."""
_MOST_LINES = 50
"""Lines of a row with line breaks inside its cells."""


class _DamagedError(AgsError):
    """A row breaks the format."""


@dataclass(slots=True)
class _Open:
    """A group while it is read."""

    name: str
    line: int
    headings: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    types: tuple[str, ...] = ()
    rows: list[AgsRow] = field(default_factory=list)


def read_ags_file(path: Path) -> AgsFile:
    """Read a file; raises AgsError where it cannot be read, or is not AGS 4."""
    try:
        with path.open("rb") as stream:
            content = stream.read(MAX_TABLE_BYTES + 1)
    except OSError as error:
        raise AgsError(f"{path}: {error.strerror or error}") from None
    return read_ags(content, path.name)


def read_ags(content: bytes, name: str) -> AgsFile:
    """Read the content of a file: UTF-8, with its mark or without, else Windows-1252; or a workbook of groups.

    Raises
    ------
    AgsError
        It is not AGS 4; the message names the line.

    Examples
    --------
    >>> file = read_ags(b'"GROUP","PROJ"\\r\\n"HEADING","PROJ_ID"\\r\\n"DATA","7"\\r\\n', "a.ags")
    >>> group = file.groups["PROJ"]
    >>> group.text(group.rows[0], "PROJ_ID")
    '7'
    """
    if len(content) > MAX_TABLE_BYTES:
        raise AgsError(f"{name} is larger than {MAX_TABLE_BYTES // 2**20} MiB, the most that is accepted")
    if content.startswith(b"PK"):
        return _file(name, _of_workbook(content, name))
    if b"\0" in content:
        raise AgsError(f"{name} is not a text file; give a file in the AGS 4 format")
    groups: dict[str, _Open] = {}
    damaged: list[tuple[str, str]] = []
    lines = [line.removesuffix("\r") for line in decoded(content).split("\n")]
    number = 0
    while number < len(lines):
        following = 1
        try:
            cells = _cells(lines[number], name, number + 1)
            if cells:
                _take(groups, cells, name, number + 1)
        except _DamagedError as error:
            group = groups[next(reversed(groups))] if groups else None
            cells, following = _repaired(lines, number, group)
            if group is None or (not cells and group.name in _READ):
                raise
            done = "mended" if cells else "left out"
            damaged.append((group.name, f"{error}; the row of group {group.name} is {done}"))
            if cells:
                _take(groups, cells, name, number + 1)
        number += following
    return _file(name, groups, damaged)


def _file(name: str, groups: dict[str, _Open], damaged: Sequence[tuple[str, str]] = ()) -> AgsFile:
    if not groups:
        raise AgsError(f"{name} contains no groups; give a file in the AGS 4 format")
    found = {
        one.name: AgsGroup(name, one.name, one.line, one.headings, one.units, one.types, tuple(one.rows))
        for one in groups.values()
    }
    return AgsFile(name, found, tuple(damaged))


def _of_workbook(content: bytes, name: str) -> dict[str, _Open]:
    """Groups of the sheets that begin with HEADING; rows of other kinds and cells without a heading are left out."""
    groups: dict[str, _Open] = {}
    try:
        for sheet in read_workbook(content, name)[0]:
            rows = [[shown(cell) for cell in row] for row in read_workbook(content, name, sheet)[2]]
            heading = next((row for row in rows if row and row[0] in _KINDS), [""])
            if heading[0] != "HEADING":
                continue
            where = f"{name} sheet '{sheet}'"
            width = max(place for place, cell in enumerate(heading, 1) if cell)
            _take(groups, ["GROUP", sheet], where, 1)
            for line, row in enumerate(rows, 1):
                if row and row[0] in _KINDS:
                    _take(groups, [*row, *[""] * width][:width], where, line)
    except TableError as error:
        raise AgsError(str(error)) from None
    return groups


def _repaired(lines: list[str], number: int, group: _Open | None) -> tuple[list[str], int]:
    """Cells of a damaged row of data, none where they cannot be told, and the number of its lines.

    A line break inside a cell, or a quote that is not doubled, costs nothing if the row then has a cell for each
    heading.
    """
    text, count = lines[number], 1
    if group is None or not group.headings or not text.lstrip().startswith('"DATA"'):
        return [], 1
    for line in lines[number + 1 : number + 1 + _MOST_LINES]:
        if not line.strip() or line.lstrip('" ').startswith(_KINDS) or _row(text, group):
            break
        text, count = f"{text} {line}", count + 1
    return _row(text, group), count


def _row(text: str, group: _Open) -> list[str]:
    plain = text.strip()
    if len(plain) < 2 or not plain.startswith('"') or not plain.endswith('"') or len(plain) > MAX_LINE_CHARACTERS:
        return []
    cells = re.split(r'"\s*,\s*"', plain[1:-1])
    return [cell.replace('""', '"') for cell in cells] if len(cells) == len(group.headings) + 1 else []


def _cells(line: str, name: str, number: int) -> list[str]:
    if not line.strip():
        return []
    if len(line) > MAX_LINE_CHARACTERS:
        raise AgsError(f"{name} line {number} has {len(line)} characters; at most {MAX_LINE_CHARACTERS} are accepted")
    if line.lstrip('" \t').startswith("**"):
        raise AgsError(
            f"{name} line {number}: {visible(line.strip()[:40])} is AGS 3; AGS 4 is accepted. Ask for the data as AGS "
            "4, or convert the file"
        )
    try:
        (cells,) = csv.reader([line], skipinitialspace=True, strict=True)
    except csv.Error as error:
        told = f"{name} line {number}: {error}; cells in double quotes, with a quote inside doubled, are accepted"
        raise _DamagedError(told) from None
    longest = max(map(len, cells), default=0)
    if longest > MAX_CELL_CHARACTERS:
        raise AgsError(
            f"{name} line {number} has a cell of {longest} characters; at most {MAX_CELL_CHARACTERS} are accepted"
        )
    return cells


def _take(groups: dict[str, _Open], cells: list[str], name: str, number: int) -> None:
    """Take a line into its group."""
    kind, values = cells[0].strip(), tuple(cells[1:])
    if kind not in _KINDS:
        raise (_DamagedError if groups else AgsError)(
            f"{name} line {number} begins with '{visible(kind[:40])}'; {', '.join(_KINDS)} are accepted in the AGS 4 "
            "format"
        )
    if kind == "GROUP":
        title = values[0].strip() if values else ""
        if not title or any(values[1:]):
            raise AgsError(f"{name} line {number}: GROUP and one name is accepted")
        if title in groups:
            raise AgsError(f"{name} line {number}: group {title} is there already, in line {groups[title].line}")
        groups[title] = _Open(title, number)
        return
    if not groups:
        raise AgsError(f"{name} line {number}: {kind} comes before the first GROUP")
    group = groups[next(reversed(groups))]
    where = f"{name} line {number}: group {group.name}"
    if kind == "HEADING":
        if group.headings:
            raise AgsError(f"{where} has a second row HEADING; one is accepted")
        group.headings = tuple(value.strip() for value in values)
        if not values or len(values) > MAX_COLUMNS:
            raise AgsError(f"{where} has {len(values)} headings; 1 to {MAX_COLUMNS} are accepted")
        twice = next((one for one in group.headings if group.headings.count(one) > 1), None)
        if twice is not None:
            raise AgsError(f"{where} has the heading {visible(twice)} twice")
        return
    if not group.headings:
        raise AgsError(f"{where}: {kind} comes before HEADING")
    if len(values) != len(group.headings):
        raise (_DamagedError if kind == "DATA" else AgsError)(
            f"{where}: {len(values)} cells of {kind} under {len(group.headings)} headings"
        )
    if kind == "UNIT":
        group.units = values
    elif kind == "TYPE":
        group.types = values
    elif len(group.rows) == MAX_ROWS:
        raise AgsError(f"{where} has more than {MAX_ROWS} rows of data, the most that are accepted")
    else:
        group.rows.append(AgsRow(number, values))
