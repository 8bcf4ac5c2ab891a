"""Reads the cells of a spreadsheet (XLSX, ODS): values as they are stored, no formulas are calculated."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from xml.etree import ElementTree
from xml.parsers import expat

from geoswarm.solver.problem.tables.opendocument import ods_names, ods_rows, ods_sheets
from geoswarm.solver.problem.tables.packed import (
    MAX_CELLS,
    MAX_COLUMNS,
    Cell,
    Covered,
    PackedParts,
    column_number,
    formula_text,
)
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.sentences import setting

__all__ = ["named_cells", "read_workbook"]

_MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_RELATION = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"
_BUILT_IN = {  # formats that every program has
    **{9: "0%", 10: "0.00%", 18: "h:mm", 19: "h:mm:ss", 20: "h:mm", 21: "h:mm:ss", 45: "mm:ss", 46: "[h]:mm:ss"},
    **dict.fromkeys((14, 15, 16, 17, 22, 47), "yyyy-mm-dd"),
}
_ELAPSED = re.compile(r"\[(?:h+|m+|s+)\]", re.IGNORECASE)
_LITERAL = re.compile(r'"([^"]*)"|\\(.)')
_THOUSANDS = re.compile(r"[0#?](,+)(?![0#?,])")  # commas behind the digits: shown in thousands
_SYMBOL = re.compile(r"\[\$([^\]\-]*)[^\]]*\]")  # [$cm]; [$-407] is a language
_CONDITION = re.compile(r"\[[<>=][^\]]*\]")
_QUOTED = re.compile(r'"[^"]*"?|\[[^\]]*\]?|\\.')  # what is not closed reaches to the end: linear in the text
_LONGEST_FORMAT = 255
"""Characters of a format that spreadsheet programs accept."""
_MERGED = re.compile(r"([A-Z]{1,3})(\d{1,7}):([A-Z]{1,3})(\d{1,7})", re.ASCII)
_SECONDS_A_DAY = 86400
_WELL = 2

_Suits = Callable[[list[list[Cell]]], int]
_Sheets = tuple[list[str], Callable[[str], Iterable[list[Cell]]]]


def read_workbook(
    content: bytes, name: str, sheet: str | None = None, suits: _Suits | None = None, *, alone: bool = False
) -> tuple[list[str], str, list[list[Cell]]]:
    """Read one sheet of a workbook.

    Parameters
    ----------
    content
        The file.
    name
        Its name, for messages.
    sheet
        Name of the sheet; the first one that has cells unless given.
    suits
        Returns how well the rows of an unnamed sheet are what is looked for, 0: not at all, 2: well. The
        first of the best sheets is read, and the first one that has cells where there is none.
    alone
        Whether several sheets that suit well are a mistake.

    Returns
    -------
    Names of all sheets, the name of this one, and its rows from the first on; empty cells are empty text.

    Raises
    ------
    TableError
        It is not a workbook, has no such sheet, or is too large.
    """
    with _opened(content, name) as archive, _explained(name):
        parts = PackedParts(archive, name)
        sheets, rows_of = _ods(parts) if _is_ods(archive) else _Workbook(parts).sheets()
        return sheets, *_chosen(name, sheet, sheets, rows_of, suits, alone)


def named_cells(content: bytes, name: str) -> dict[str, str]:
    """Cells that a workbook has names for: address such as ``Sheet1!$B$5:$B$30`` (``$Sheet1.$B$5`` in ODS) by name.

    Raises
    ------
    TableError
        It is not a workbook.
    """
    with _opened(content, name) as archive, _explained(name):
        parts = PackedParts(archive, name)
        if _is_ods(archive):
            return ods_names(parts)
        defined = parts.part("xl/workbook.xml").iter(f"{_MAIN}definedName")
        return {one.get("name", ""): one.text or "" for one in defined}


@contextmanager
def _explained(name: str) -> Iterator[None]:
    try:
        yield
    except (zipfile.BadZipFile, ElementTree.ParseError, expat.ExpatError, NotImplementedError, RuntimeError) as error:
        # RuntimeError: a part is encrypted; NotImplementedError: packed in a way that Python does not know
        raise TableError(f"{name} cannot be read as an XLSX or ODS workbook: {error}") from None
    except (KeyError, ValueError, IndexError, EOFError, OSError) as error:
        raise TableError(f"{name} is not a complete XLSX or ODS workbook: {error}") from None


def _opened(content: bytes, name: str) -> zipfile.ZipFile:
    with _explained(name):
        return zipfile.ZipFile(io.BytesIO(content))


def _is_ods(archive: zipfile.ZipFile) -> bool:
    return "content.xml" in archive.namelist()


def _ods(parts: PackedParts) -> _Sheets:
    tables = ods_sheets(parts)
    return list(tables), lambda sheet: ods_rows(parts, tables[sheet])


def _chosen(
    name: str,
    wanted: str | None,
    sheets: Sequence[str],
    rows_of: Callable[[str], Iterable[list[Cell]]],
    suits: _Suits | None,
    alone: bool,
) -> tuple[str, list[list[Cell]]]:
    """The sheet that is wanted, or the first of those that suit best, or the first one with cells; and its rows."""
    if not sheets:
        raise TableError(f"{name} has no sheets with cells")
    if wanted is not None:
        if wanted not in sheets:
            raise TableError(f"{name} has no sheet '{wanted}'; its sheets: {', '.join(sheets)}")
        return wanted, list(rows_of(wanted))
    best: tuple[int, str, list[list[Cell]]] | None = None
    well: list[str] = []
    for sheet in sheets:
        rows = list(rows_of(sheet))
        if not any(cell != "" for row in rows for cell in row):
            continue
        merit = _WELL if suits is None else suits(rows)
        if best is None or merit > best[0]:
            best = merit, sheet, rows
        well += [sheet] if merit == _WELL else []
        if merit == _WELL and not alone:
            break
    if len(well) > 1:
        raise TableError(
            (f"{name}: several sheets have these columns, {', '.join(well)}; give ", setting("sheet", well[0]))
        )
    return (sheets[-1], []) if best is None else best[1:]


class _Workbook:
    def __init__(self, parts: PackedParts) -> None:
        self._parts = parts

    def sheets(self) -> _Sheets:
        """Names of the sheets, and what reads one."""
        part = self._parts.part
        book = part("xl/workbook.xml")
        targets = {one.get("Id", ""): one.get("Target", "") for one in part("xl/_rels/workbook.xml.rels")}
        sheets = {
            one.get("name", ""): _place(targets[one.get(_RELATION, "")])
            for one in book.iter(f"{_MAIN}sheet")
            if _place(targets.get(one.get(_RELATION, ""), "")).startswith("xl/worksheets/")  # not the charts
        }
        settings = book.find(f"{_MAIN}workbookPr")
        since_1904 = settings is not None and settings.get("date1904") in ("1", "true")
        texts = [self._text(one) for one in part("xl/sharedStrings.xml", optional=True).iter(f"{_MAIN}si")]
        styles = _styles(part("xl/styles.xml", optional=True))
        return list(sheets), lambda sheet: self._rows(sheets[sheet], texts, styles, since_1904)

    def _rows(self, place: str, texts: list[str], styles: list[str], since_1904: bool) -> Iterator[list[Cell]]:
        left, line = MAX_CELLS, 0
        root = self._parts.part(place)
        merged = _merged(root)
        for row in root.iter(f"{_MAIN}row"):
            blank = int(row.get("r") or line + 1) - line - 1  # empty rows are not stored
            left -= max(blank, 0)
            if left < 0:
                raise self._parts.too_many()
            yield from ([] for _ in range(blank))
            line += max(blank, 0) + 1
            cells: list[Cell] = []
            for cell in row.iter(f"{_MAIN}c"):
                column = _column(cell.get("r"), len(cells))
                if column >= MAX_COLUMNS:
                    break
                cells += [""] * (column - len(cells))
                cells.append(self._value(cell, texts, styles, since_1904))
            end = -1
            for first, last in sorted(merged.get(line, ())):
                text = cells[first] if end < first < len(cells) else ""  # those that overlap are none
                if isinstance(text, str) and text:
                    end = last
                    cells += [""] * (last + 1 - len(cells))
                    cells[first + 1 : last + 1] = [cell or Covered(text) for cell in cells[first + 1 : last + 1]]
            left -= len(cells)
            if left < 0:
                raise self._parts.too_many()
            yield cells

    def _value(self, cell: ElementTree.Element, texts: list[str], styles: list[str], since_1904: bool) -> Cell:
        kind = cell.get("t", "n")
        if kind == "inlineStr":
            holder = cell.find(f"{_MAIN}is")
            return "" if holder is None else self._text(holder)
        stored = cell.findtext(f"{_MAIN}v")
        formula = cell.find(f"{_MAIN}f")
        if stored is None or (stored == "" and kind == "n"):
            return "" if formula is None else formula_text(formula.text or "")
        if kind == "s":
            return texts[int(stored)]
        if kind == "b":  # no number, as a person sees none
            return "TRUE" if stored.strip() == "1" else "FALSE"
        if kind != "n":  # a formula's text, an error, a date in ISO 8601
            return self._parts.short(stored.strip())
        style = int(cell.get("s", "0"))
        return _as_shown(float(stored), styles[style] if style < len(styles) else "", since_1904)

    def _text(self, holder: ElementTree.Element) -> str:
        """Text of all runs; phonetic hints beside them are left out."""
        runs = [holder, *holder.findall(f"{_MAIN}r")]
        return self._parts.short("".join(part.text or "" for run in runs for part in run.findall(f"{_MAIN}t")).strip())


def _merged(sheet: ElementTree.Element) -> dict[int, list[tuple[int, int]]]:
    """First and last columns of cells that are merged over several columns, by their first line."""
    found: dict[int, list[tuple[int, int]]] = {}
    for one in sheet.iter(f"{_MAIN}mergeCell"):
        cells = _MERGED.fullmatch(one.get("ref", ""))
        if cells is not None and (first := column_number(cells[1])) < (last := column_number(cells[3])) < MAX_COLUMNS:
            found.setdefault(int(cells[2]), []).append((first, last))
    return found


def _place(target: str) -> str:
    return target.lstrip("/") if target.startswith("/") else f"xl/{target}"


def _column(reference: str | None, following: int) -> int:
    """Number of a cell's column from its reference (B7 is in 1); the next one without a reference."""
    letters = re.match(r"[A-Z]{1,3}", reference or "")
    if letters is None:
        return following
    return max(column_number(letters.group()), following)


def _styles(styles: ElementTree.Element) -> list[str]:
    """What each cell style shows of a number: ``date``, ``elapsed``, the unit behind it, or nothing more."""
    own = {int(one.get("numFmtId", "0")): one.get("formatCode", "") for one in styles.iter(f"{_MAIN}numFmt")}
    shown = {number: _shown(code) for number, code in (_BUILT_IN | own).items()}
    formats = styles.find(f"{_MAIN}cellXfs")
    return [shown.get(int(style.get("numFmtId", "0")), "") for style in (formats if formats is not None else ())]


def _shown(code: str) -> str:
    code = _SYMBOL.sub(lambda found: f'"{found[1]}"', code[:_LONGEST_FORMAT])
    if _CONDITION.search(code) is not None:  # each of the sections may have a unit of its own
        several = {_shown(_CONDITION.sub("", section)) for section in code.split(";")}
        return several.pop() if len(several) == 1 else "(in several units)"
    code = code.split(";")[0]
    plain = _QUOTED.sub("", code)
    if _ELAPSED.search(code) is not None:
        return "elapsed"
    if re.search(r"[ymdhs]", plain, re.IGNORECASE) is not None:
        return "date" if re.search(r"[yd]", plain, re.IGNORECASE) is not None else "clock"
    scaled = _THOUSANDS.search(plain)
    shown = "%" if "%" in plain else " ".join("".join(map("".join, _LITERAL.findall(code))).split())
    return shown if scaled is None else f"{scaled[1]}{shown}"


def _as_shown(value: float, style: str, since_1904: bool) -> Cell:
    """A number as people see it: with its unit where the format adds one."""
    if not style:
        return value
    if style == "date" or (style == "clock" and value >= 1.0):
        return _date(value, since_1904)
    if style == "clock":
        return _date(value, False)[11:] if value >= 0.0 else value
    if style == "elapsed":
        return f"{value:.15g} day"
    shown = style.lstrip(",")
    value /= 1000.0 ** (len(style) - len(shown))
    if not shown:
        return value
    return f"{100.0 * value:.15g} %" if shown == "%" else f"{value:.15g} {shown}"


def _date(serial: float, since_1904: bool) -> str:
    """ISO 8601 of the days since the end of 1899 (or the beginning of 1904), to a thousandth of a second."""
    from datetime import datetime, timedelta

    # The first spreadsheets took 1900 for a leap year; the files of the others still count that day.
    origin = datetime(1904, 1, 1) if since_1904 else datetime(1899, 12, 30)
    try:
        moment = origin + timedelta(milliseconds=round(serial * _SECONDS_A_DAY * 1000))
    except OverflowError:
        return str(serial)
    return moment.isoformat(sep=" ", timespec="milliseconds").removesuffix(".000")
