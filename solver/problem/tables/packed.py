"""The parts of a packed workbook (XLSX, ODS): unpacked no further than is safe, without document types."""

from __future__ import annotations

import zipfile
from xml.etree import ElementTree
from xml.parsers import expat

from geoswarm.solver.problem.tables.reading import MAX_CELL_CHARACTERS, TableError

__all__ = [
    "FORMULA",
    "MAX_CELLS",
    "MAX_COLUMNS",
    "Cell",
    "Covered",
    "PackedParts",
    "column_letters",
    "column_number",
    "formula_text",
]

Cell = str | float
"""Text or a number; a date is text in ISO 8601."""


class Covered(str):
    """An empty cell below a merged one; ``text`` is what that one shows."""

    text: str

    def __new__(cls, text: str) -> Covered:
        cell = super().__new__(cls)
        cell.text = text
        return cell


FORMULA = "="
"""With what a formula begins that stands for a cell without a stored value."""

_LONGEST_FORMULA = 60

MAX_PART_BYTES = 32 * 2**20
MAX_UNPACKED_BYTES = 4 * MAX_PART_BYTES
MAX_CELLS = 2_000_000
MAX_COLUMNS = 500


def column_number(letters: str) -> int:
    """Number of a column from its letters, from 0.

    >>> column_number("AB")
    27
    """
    number = 0
    for letter in letters.upper():
        number = 26 * number + ord(letter) - ord("A") + 1
    return number - 1


def column_letters(number: int) -> str:
    """Letters of a column from its number, from 0.

    >>> column_letters(27)
    'AB'
    """
    letters = ""
    number += 1
    while number > 0:
        number, place = divmod(number - 1, 26)
        letters = chr(ord("A") + place) + letters
    return letters


def formula_text(formula: str) -> str:
    """Marks a cell whose formula has no stored value; blank it would look like no reading."""
    return FORMULA + " ".join(formula.split())[:_LONGEST_FORMULA]


class PackedParts:
    """Parts of one file; ``name`` is that of the file, for messages."""

    def __init__(self, archive: zipfile.ZipFile, name: str) -> None:
        self.archive = archive
        self.name = name
        self._left = MAX_UNPACKED_BYTES

    def part(self, place: str, optional: bool = False) -> ElementTree.Element:
        """Root of a part; an empty one for what is optional and missing."""
        if optional and place not in self.archive.namelist():
            return ElementTree.Element("none")
        size = self.archive.getinfo(place).file_size
        if size > MAX_PART_BYTES:
            raise TableError(f"{self.name}: {place} is larger than {MAX_PART_BYTES} bytes")
        self._left -= size  # many sheets may be one and the same large part
        if self._left < 0:
            raise TableError(f"{self.name} unpacks to more than {MAX_UNPACKED_BYTES} bytes before its first cell")
        with self.archive.open(place) as part:
            content = part.read(size + 1)  # no more than it says: read() unpacks all before it finds too much
        _refuse_definitions(content, self.name)
        return ElementTree.fromstring(content)

    def short(self, text: str) -> str:
        """Refuse long texts: any number of cells may show one."""
        if len(text) > MAX_CELL_CHARACTERS:
            raise TableError(
                f"{self.name} has a cell of {len(text)} characters; at most {MAX_CELL_CHARACTERS} are accepted"
            )
        return text

    def too_many(self) -> TableError:
        """What to raise beyond the largest number of cells."""
        return TableError(f"{self.name} has more than {MAX_CELLS} cells")


def _refuse_definitions(content: bytes, name: str) -> None:
    """Refuse document types: no workbook has one, and their entities could stand for any amount of text."""
    parser = expat.ParserCreate()

    def found(*_: object) -> None:
        raise TableError(f"{name} has a document type, which no workbook needs")

    parser.StartDoctypeDeclHandler = found
    parser.Parse(content, True)
