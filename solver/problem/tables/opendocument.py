"""The cells of an OpenDocument workbook (ODS): values as they are stored, no formulas are calculated."""

from __future__ import annotations

import re
from collections.abc import Iterator
from xml.etree import ElementTree

from geoswarm.solver.problem.tables.packed import MAX_CELLS, MAX_COLUMNS, Cell, Covered, PackedParts, formula_text

__all__ = ["ods_names", "ods_rows", "ods_sheets"]

_TABLE = "{urn:oasis:names:tc:opendocument:xmlns:table:1.0}"
_OFFICE = "{urn:oasis:names:tc:opendocument:xmlns:office:1.0}"
_TEXT = "{urn:oasis:names:tc:opendocument:xmlns:text:1.0}"
_UNIT_BEHIND = re.compile(r"[\d.,'\u2019\s+\u2212-]*\d[.,]?\s*(?!E[+-]?\d+$)((?:[^\W\d_]|[%‰°]).{0,19})")
_DURATION = re.compile(r"PT(\d{1,5})H(\d{1,2})M(\d{1,2})(?:[.,]\d{1,9})?S", re.ASCII)


def ods_sheets(parts: PackedParts) -> dict[str, ElementTree.Element]:
    """Tables of the workbook by name."""
    book = parts.part("content.xml").find(f"{_OFFICE}body/{_OFFICE}spreadsheet")
    tables = [] if book is None else book.findall(f"{_TABLE}table")  # not the tables inside of cells
    return {one.get(f"{_TABLE}name", ""): one for one in tables}


def ods_rows(parts: PackedParts, table: ElementTree.Element) -> Iterator[list[Cell]]:
    """Rows of a table from the first on; empty cells are empty text.

    Raises
    ------
    TableError
        There are too many cells.
    """
    left, blank = MAX_CELLS, 0
    for row in table.iter(f"{_TABLE}table-row"):
        cells = _cells(parts, row)
        repeated = _repeated(row, "rows")
        if not cells:
            blank += repeated  # the last row stands for all that follow
            continue
        left -= blank + max(len(cells), 1) * repeated
        if left < 0:
            raise parts.too_many()
        yield from ([] for _ in range(blank))
        blank = 0
        yield from (list(cells) for _ in range(repeated))


def _cells(parts: PackedParts, row: ElementTree.Element) -> list[Cell]:
    cells: list[Cell] = []
    blank = 0
    covering = ""
    for cell in row:
        if cell.tag not in (f"{_TABLE}table-cell", f"{_TABLE}covered-table-cell"):
            continue
        value = _value(parts, cell)
        repeated = _repeated(cell, "columns")
        if cell.tag == f"{_TABLE}table-cell":
            covering = value if isinstance(value, str) and cell.get(f"{_TABLE}number-columns-spanned") else ""
        elif value == "" and covering:
            value = Covered(covering)
        if value == "" and not isinstance(value, Covered):
            blank += repeated
            continue
        if len(cells) + blank >= MAX_COLUMNS:
            break
        cells += [""] * blank
        cells += [value] * min(repeated, MAX_COLUMNS - len(cells))
        blank = 0
    return cells


def _repeated(element: ElementTree.Element, what: str) -> int:
    return max(int(element.get(f"{_TABLE}number-{what}-repeated", "1")), 1)


def _value(parts: PackedParts, cell: ElementTree.Element) -> Cell:
    kind = cell.get(f"{_OFFICE}value-type")
    formula = cell.get(f"{_TABLE}formula")
    if kind is None and formula is not None:
        return formula_text(formula.partition("=")[2])
    if kind in ("float", "percentage", "currency"):
        value = float(cell.get(f"{_OFFICE}value", ""))
        if kind == "percentage":
            return f"{100.0 * value:.15g} %"
        behind = _UNIT_BEHIND.fullmatch(_text(cell)) if kind == "float" else None
        return value if behind is None else f"{value:.15g} {behind[1]}"
    if kind == "date":
        return parts.short(cell.get(f"{_OFFICE}date-value", "").replace("T", " "))
    if kind == "time":
        found = _DURATION.fullmatch(cell.get(f"{_OFFICE}time-value", ""))
        return "" if found is None else f"{int(found[1]):02d}:{found[2]}:{found[3]}"
    if kind is None:
        return ""
    return parts.short(_text(cell))


def _text(cell: ElementTree.Element) -> str:
    """What a cell shows."""
    return "\n".join("".join(line.itertext()) for line in cell.findall(f"{_TEXT}p")).strip()


def ods_names(parts: PackedParts) -> dict[str, str]:
    """Named cells, as ``$Sheet.$B$5:.$B$30``."""
    return {
        one.get(f"{_TABLE}name", ""): one.get(f"{_TABLE}cell-range-address", "")
        for one in parts.part("content.xml").iter(f"{_TABLE}named-range")
    }
