"""Reads the cells of a spreadsheet (XLSX): values as they are stored, no formulas are calculated."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Iterator
from xml.etree import ElementTree
from xml.parsers import expat

from geoswarm.solver.problem.tables.reading import MAX_CELL_CHARACTERS, TableError

__all__ = ["Cell", "read_workbook"]

Cell = str | float
"""Text or a number; a date is text in ISO 8601."""

MAX_PART_BYTES = 32 * 2**20
MAX_UNPACKED_BYTES = 4 * MAX_PART_BYTES
MAX_CELLS = 2_000_000
MAX_COLUMNS = 500

_MAIN = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_RELATION = "{http://schemas.openxmlformats.org/officeDocument/2006/relationships}id"
_DATE_FORMATS = frozenset({*range(14, 23), *range(45, 48)})  # numbers of the formats that every program has built in
_QUOTED = re.compile(r'"[^"]*"?|\[[^\]]*\]?|\\.')  # what is not closed reaches to the end: linear in the text
_SECONDS_A_DAY = 86400


def read_workbook(content: bytes, name: str, sheet: str | None = None) -> tuple[list[str], str, list[list[Cell]]]:
    """Read one sheet of a workbook.

    Parameters
    ----------
    content
        The file.
    name
        Its name, for messages.
    sheet
        Name of the sheet; the first one that has cells unless given.

    Returns
    -------
    Names of all sheets, the name of this one, and its rows from the first on; empty cells are empty text.

    Raises
    ------
    TableError
        It is no workbook, has no such sheet, or is too large.
    """
    try:
        with zipfile.ZipFile(io.BytesIO(content)) as archive:
            return _Workbook(archive, name).read(sheet)
    except (zipfile.BadZipFile, ElementTree.ParseError, expat.ExpatError, NotImplementedError, RuntimeError) as error:
        # RuntimeError: a part is encrypted; NotImplementedError: packed in a way that Python does not know
        raise TableError(f"{name} cannot be read as an XLSX workbook: {error}") from None
    except (KeyError, ValueError, IndexError, EOFError, OSError) as error:
        raise TableError(f"{name} is no complete XLSX workbook: {error}") from None


class _Workbook:
    def __init__(self, archive: zipfile.ZipFile, name: str) -> None:
        self._archive = archive
        self._name = name
        self._left = MAX_UNPACKED_BYTES

    def read(self, wanted: str | None) -> tuple[list[str], str, list[list[Cell]]]:
        if "content.xml" in self._archive.namelist():
            raise TableError(f"{self._name} is an OpenDocument workbook (.ods); save it as .xlsx or .csv")
        book = self._part("xl/workbook.xml")
        targets = {one.get("Id", ""): one.get("Target", "") for one in self._part("xl/_rels/workbook.xml.rels")}
        sheets = {
            one.get("name", ""): _place(targets[one.get(_RELATION, "")])
            for one in book.iter(f"{_MAIN}sheet")
            if _place(targets.get(one.get(_RELATION, ""), "")).startswith("xl/worksheets/")  # not the charts
        }
        if not sheets:
            raise TableError(f"{self._name} has no sheets with cells")
        if wanted is not None and wanted not in sheets:
            raise TableError(f"{self._name} has no sheet '{wanted}'; its sheets: {', '.join(sheets)}")
        settings = book.find(f"{_MAIN}workbookPr")
        since_1904 = settings is not None and settings.get("date1904") in ("1", "true")
        texts = [self._text(one) for one in self._part("xl/sharedStrings.xml", optional=True).iter(f"{_MAIN}si")]
        dates = _date_styles(self._part("xl/styles.xml", optional=True))
        chosen, rows = "", []
        for chosen in [wanted] if wanted is not None else sheets:  # the one at which it ends
            rows = list(self._rows(sheets[chosen], texts, dates, since_1904))
            if any(cell != "" for row in rows for cell in row):
                break
        return list(sheets), chosen, rows

    def _part(self, place: str, optional: bool = False) -> ElementTree.Element:
        if optional and place not in self._archive.namelist():
            return ElementTree.Element("none")
        size = self._archive.getinfo(place).file_size
        if size > MAX_PART_BYTES:
            raise TableError(f"{self._name}: {place} is larger than {MAX_PART_BYTES} bytes")
        self._left -= size  # many sheets may be one and the same large part
        if self._left < 0:
            raise TableError(f"{self._name} unpacks to more than {MAX_UNPACKED_BYTES} bytes before its first cell")
        with self._archive.open(place) as part:
            content = part.read(size + 1)  # no more than it says: read() unpacks all before it finds too much
        _refuse_definitions(content, self._name)
        return ElementTree.fromstring(content)

    def _rows(self, place: str, texts: list[str], dates: set[int], since_1904: bool) -> Iterator[list[Cell]]:
        left, line = MAX_CELLS, 0
        for row in self._part(place).iter(f"{_MAIN}row"):
            blank = int(row.get("r") or line + 1) - line - 1  # empty rows are not stored
            left -= max(blank, 0)
            if left < 0:
                raise TableError(f"{self._name} has more than {MAX_CELLS} cells")
            yield from ([] for _ in range(blank))
            line += max(blank, 0) + 1
            cells: list[Cell] = []
            for cell in row.iter(f"{_MAIN}c"):
                column = _column(cell.get("r"), len(cells))
                if column >= MAX_COLUMNS:
                    break
                cells += [""] * (column - len(cells))
                cells.append(self._value(cell, texts, dates, since_1904))
            left -= len(cells)
            if left < 0:
                raise TableError(f"{self._name} has more than {MAX_CELLS} cells")
            yield cells

    def _value(self, cell: ElementTree.Element, texts: list[str], dates: set[int], since_1904: bool) -> Cell:
        kind = cell.get("t", "n")
        if kind == "inlineStr":
            holder = cell.find(f"{_MAIN}is")
            return "" if holder is None else self._text(holder)
        stored = cell.findtext(f"{_MAIN}v")
        if stored is None:
            return ""
        if kind == "s":
            return texts[int(stored)]
        if kind != "n":  # a formula's text, an error, true or false, a date in ISO 8601
            return self._short(stored.strip())
        value = float(stored)
        return _date(value, since_1904) if int(cell.get("s", "0")) in dates else value

    def _text(self, holder: ElementTree.Element) -> str:
        """Text of all runs; phonetic hints beside them are left out."""
        runs = [holder, *holder.findall(f"{_MAIN}r")]
        return self._short("".join(part.text or "" for run in runs for part in run.findall(f"{_MAIN}t")).strip())

    def _short(self, text: str) -> str:
        """Refuse long texts: any number of cells may show one."""
        if len(text) > MAX_CELL_CHARACTERS:
            raise TableError(
                f"{self._name} has a cell of {len(text)} characters; at most {MAX_CELL_CHARACTERS} are accepted"
            )
        return text


def _refuse_definitions(content: bytes, name: str) -> None:
    """Refuse document types: no workbook has one, and their entities could stand for any amount of text."""
    parser = expat.ParserCreate()

    def found(*_: object) -> None:
        raise TableError(f"{name} has a document type, which no workbook needs")

    parser.StartDoctypeDeclHandler = found
    parser.Parse(content, True)


def _place(target: str) -> str:
    return target.lstrip("/") if target.startswith("/") else f"xl/{target}"


def _column(reference: str | None, following: int) -> int:
    """Number of a cell's column from its reference (B7 is in 1); the next one without a reference."""
    letters = re.match(r"[A-Z]{1,3}", reference or "")
    if letters is None:
        return following
    number = 0
    for letter in letters.group():
        number = 26 * number + ord(letter) - ord("A") + 1
    return max(number - 1, following)


def _date_styles(styles: ElementTree.Element) -> set[int]:
    """Numbers of the cell styles that show a number as a date or time."""
    own = {
        int(one.get("numFmtId", "0")): _shows_date(one.get("formatCode", "")) for one in styles.iter(f"{_MAIN}numFmt")
    }
    formats = styles.find(f"{_MAIN}cellXfs")
    numbers = [int(style.get("numFmtId", "0")) for style in (formats if formats is not None else ())]
    return {place for place, number in enumerate(numbers) if own.get(number, number in _DATE_FORMATS)}


def _shows_date(code: str) -> bool:
    return re.search(r"[ymdhs]", _QUOTED.sub("", code), re.IGNORECASE) is not None


def _date(serial: float, since_1904: bool) -> str:
    """ISO 8601 of the days since the end of 1899 (or the beginning of 1904), to a thousandth of a second."""
    from datetime import datetime, timedelta

    # The first spreadsheets took 1900 for a whole_generation year; the files of the others still count that day.
    origin = datetime(1904, 1, 1) if since_1904 else datetime(1899, 12, 30)
    try:
        moment = origin + timedelta(milliseconds=round(serial * _SECONDS_A_DAY * 1000))
    except OverflowError:
        return str(serial)
    return moment.isoformat(sep=" ", timespec="milliseconds").removesuffix(".000")
