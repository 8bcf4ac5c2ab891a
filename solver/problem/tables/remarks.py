"""What a file says beside its readings: lines and columns of factors, offsets and units, notes between the rows."""

from __future__ import annotations

import functools
import itertools
import re
from collections.abc import Callable, Collection, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

from geoswarm.solver.problem.tables.alterations import Alteration, change_in, is_switch
from geoswarm.solver.problem.tables.blocks import is_heading, is_reading, is_unit_column, key, shown, unit_of_cell
from geoswarm.solver.problem.tables.cells import Sheet, number_in
from geoswarm.solver.problem.tables.headings import BASES, Heading, Named, best_unit, guess_unit, known_unit, units_of
from geoswarm.solver.problem.tables.packed import Cell, column_letters
from geoswarm.solver.problem.tables.picking import Picked
from geoswarm.solver.problem.tables.quantities import factor_in, is_column_of_factors, offset_in, quantities_of
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.sentences import Sentence, setting

__all__ = ["Beside", "factors_beside", "refuse_changes", "refuse_headings", "with_factors"]

_OTHER_CHANNEL = re.compile(r"kraft|force|load ?(?:cell|ring)|proving|temperat", re.IGNORECASE)
_WORD = re.compile(r"[^\W\d_]{3}")
_LONGEST_LINE = 200
_FIRST_FACTORS = 20
_FEW_WORDS = 6
_BEFORE_UNIT = re.compile(r"(?<!\w)(?:in|en|w|i)\s|[\[(]", re.IGNORECASE)
_IN_OTHERS = re.compile(r"(?<!\w)(?:en|w|i)\s(?=\S{1,8}\W*$)")
_OF_ALL = re.compile(
    r"[\W\d]*(?:(?:alle[rns]?|all|(?:mess)?werte?|values?|readings?|data|daten|angaben|längen|lengths?|longueurs?|einheit(?:en)?|units?"
    r"|sind|are|in|unités?|unidad(?:es)?|jednostki?|enhet(?:er)?)[\W\d]*)*",
    re.IGNORECASE,
)
_IN_FIRST = re.compile(r"\W*(?:in\s|[\[(])", re.IGNORECASE)
_NOTE = re.compile(r"[^\W\d_]{2}|[×x*]\s?\d")
_PLACED = re.compile(
    r"(?<![^\W\d_])(?:ab|von|nach|bei|seit|from|at|after|since|à partir|après|depuis|a partir|desde|después|od|po|från"
    r"|efter|vid)(?![^\W\d_])\D{0,30}(?:\d|hier|here)|^\W*(?:[*†‡#]+|\(?\w{1,2}\))\s*:?\s*(?=[^\W\d_])",
    re.IGNORECASE,
)
_LISTED = re.compile(r"[,;|]\s*|\s-\s")
_LIST_OF = re.compile(
    r"^\W*(?:units?|einheit(?:en)?|unités?|unidad(?:es)?|jednostki?|enheter|columns?|spalten?|channels?|kanäle)\s*[:=]",
    re.IGNORECASE,
)
_UNIT_AT_END = re.compile(r"\s*(?:[µmc]m|m|[kM]Pa|inch|in|%)\s*\W?$")


@dataclass(frozen=True, slots=True)
class Beside:
    """A line or column that names a factor, an offset or a ``unit`` of quantities; of all where ``of`` is empty.

    ``against``: its unit counts only where a heading names another one of that dimension.
    """

    text: str
    of: frozenset[str]
    unit: Named | None = None
    alters: Alteration = "factor"
    against: bool = False


@dataclass(frozen=True, slots=True)
class Note:
    """A text of a file that may change what the numbers of the readings are, and its line."""

    line: int
    text: str


def factors_beside(sheet: Sheet, used: Container[int], body: Iterable[Sequence[Cell]]) -> list[Beside]:
    """Columns of factors, and lines outside the table, comments too, that name one, or the unit of a quantity.

    ``used`` are the lines of the readings, ``body`` is their rows.
    """
    first = sheet.rows[0][0] if sheet.rows else sheet.header_line + 1
    lines = [("comment", line) for _, line in _comments(sheet)]
    lines += [
        (f"line {line}", " ".join(shown(cell) for cell in row if cell != "")[:_LONGEST_LINE])
        for line, row in sheet.grid.items()
        if line not in used and not sheet.header_line <= line < first
    ]
    remarks = _remarks(sheet)
    lines += [("remark", text) for text in remarks]
    found: tuple[tuple[Alteration, Callable[[str], str | None]], ...] = ("factor", factor_in), ("offset", offset_in)
    named = [
        Beside(f"{where}: {text}", _meant(text), None, alters)
        for where, text in lines
        for alters, named_in in found
        if named_in(text)
    ]
    notes = [(text, False) for where, text in lines if where == "comment"] + [(text, True) for text in remarks]
    notes += [] if sheet.sheet is None else [(sheet.sheet, False)]
    for line, row in sheet.grid.items():
        if line > first and line not in used:
            text = _joined(row)
            if _UNIT_AT_END.search(text) and factor_in(_UNIT_AT_END.sub("", text)):
                named.append(Beside(f"line {line}: {text}", frozenset()))
            else:
                notes.append((text, False))
    named += [one for text, beside in dict.fromkeys(notes) if (one := _unit_beside(text, beside)) is not None]
    for row in (row for line, row in sheet.grid.items() if line < sheet.header_line):
        if any(map(is_reading, row)):
            named += _unit_of_channel(row)
        else:
            title = _unit_beside(text := _joined(row), False)
            named += _units_listed(text) if title is None else [replace(title, against=True)]
    named += [one for _, text in _comments(sheet) for one in _units_listed(text)]
    return named + _factor_columns(sheet.header, body)


def _joined(row: Iterable[Cell]) -> str:
    return " ".join(shown(cell) for cell in row if cell != "")[:_LONGEST_LINE]


def _comments(sheet: Sheet) -> Iterator[tuple[int, str]]:
    """Lines of comments and what they say."""
    for line, text in enumerate(sheet.comments.splitlines(), 1):
        if text:
            yield line, text.strip().lstrip("# \t")[:_LONGEST_LINE]


def _unit_beside(text: str, beside: bool) -> Beside | None:
    """The unit that a text names for a quantity, or for all; ``beside`` the readings it may say so in any words."""
    if _NOTE.search(text) is None or (_BEFORE_UNIT.search(text) is None and len(text.split()) > _FEW_WORDS):
        return None
    text = _IN_OTHERS.sub("in ", text)
    unit = best_unit(one for one in units_of(text) if one.certain or len(one.text) > 1)
    if unit is None or factor_in(text) or _is_value(text, unit):
        return None
    of_all = _OF_ALL.fullmatch(text.replace(unit.text, " ", 1)) is not None
    of = frozenset(quantities_of(unit.label))
    if not of_all and not (unit.certain and (of or beside) and _BEFORE_UNIT.search(text) is not None):
        return None
    return Beside(text, of, unit, against=not of)


def _units_listed(text: str) -> list[Beside]:
    """Units of a list, ``units: min, µm`` or ``t: min, s: µm``, which count against those of headings."""
    found = []
    for piece in _LISTED.split(_LIST_OF.sub("", text)):
        unit = best_unit(one for one in units_of(piece) if one.certain or len(one.text) > 1)
        if unit is None or factor_in(piece) or _is_value(piece, unit):
            continue
        of_all = _OF_ALL.fullmatch(piece.replace(unit.text, " ", 1)) is not None
        named = unit.certain or re.search(rf"[:=]\s*{re.escape(unit.text)}\W*$", piece) is not None
        if of_all or (named and quantities_of(unit.label)):
            of = frozenset() if of_all else frozenset(quantities_of(unit.label))
            found.append(Beside(text, of, unit, against=True))
    return found


def _unit_of_channel(row: Sequence[Cell]) -> list[Beside]:
    """The unit of a quantity in a list of channels, ``1;Displacement;µm``."""
    cells = [shown(cell) for cell in row if cell != ""]
    for name, unit in itertools.pairwise(cells):
        if _is_long_unit(unit) and (of := quantities_of(name)):
            named = best_unit(units_of(f"{name} [{unit}]"))
            return [] if named is None else [Beside(_joined(row), frozenset(of), named, against=True)]
    return []


def _is_long_unit(text: str) -> bool:
    unit = unit_of_cell(text)
    return unit is not None and len(unit) > 1 and unit[0] not in "0-–—" and known_unit(unit)[0] is not None


def _is_value(text: str, unit: Named) -> bool:
    """Whether a text gives a value with its unit, ``Stufe 2: 100 kPa``."""
    number = re.match(r"[×x*·]?\s*(?:1\s?[/:e]|10\^?[-−]|0?[.,]0*1(?!\d))", unit.text) is None
    before = re.search(rf"\d\s?[\[(]?\s*{re.escape(unit.text)}", text)
    return before is not None or (unit.text[:1].isdigit() and number)


def _meant(text: str) -> frozenset[str]:
    """The quantities that a line names; ``force`` stands for the other channels of a machine."""
    return frozenset(quantities_of(text) or (["force"] if _OTHER_CHANNEL.search(text) else []))


def _remarks(sheet: Sheet) -> list[str]:
    """Texts beside the first readings, and headings without any."""
    rows = [row for _, row in sheet.rows[:_FIRST_FACTORS]]
    filled = {place for row in rows for place, cell in enumerate(row) if cell != ""}
    of_others = {place for place, name in enumerate(sheet.header) if is_unit_column(name)}
    texts = [
        cell
        for row in rows
        for place, cell in enumerate(row)
        if isinstance(cell, str) and place not in of_others and not is_reading(cell)
    ]
    texts += [name for place, name in enumerate(sheet.header) if place not in filled]
    return [
        text[:_LONGEST_LINE]
        for text in dict.fromkeys(texts)
        if _WORD.search(text) is not None or _BEFORE_UNIT.search(text) is not None or _is_long_unit(text)
    ]


def _factor_columns(header: Sequence[str], body: Iterable[Sequence[Cell]]) -> list[Beside]:
    """Columns of factors other than 1, with their first values, and the quantities that they name."""
    places = [place for place, name in enumerate(header) if is_column_of_factors(name)]
    found = []
    rows = list(body) if places else []
    for place in places:
        values = [value for row in rows if place < len(row) and (value := number_in(row[place])) is not None]
        if any(value != 1.0 for value in values):
            first = ", ".join(f"{value:g}" for value in dict.fromkeys(values[:_FIRST_FACTORS]))
            found.append(Beside(f"column {header[place]}: {first}", frozenset(quantities_of(header[place]))))
    return found


def with_factors(heading: Heading, lines: Iterable[Beside]) -> Heading:
    """A heading with the factors and units that lines name for its quantity; factors for none are not of times."""
    meant = frozenset(quantities_of(guess_unit(heading.name)[0]))
    if heading.dates or heading.in_cells:
        return heading
    time = "time" in meant or any(one.base == "day" for one in heading.named)
    further = [
        one.unit or Named(None, None, True, one.text, heading.name, alters=one.alters)
        for one in lines
        if (one.of & meant or not (time or one.unit or (one.of and meant)) or (one.unit is not None and not one.of))
        and not (one.against and one.unit is not None and not _contradicts(one.unit, heading))
    ]
    return replace(heading, named=(*heading.named, *further))


def _contradicts(unit: Named, heading: Heading) -> bool:
    """Whether a heading names a unit of this dimension, and none that is this one."""
    known = {one.unit for one in heading.named if one.base == unit.base and one.unit is not None}
    return bool(known) and unit.unit not in known


def _changing_note(
    sheet: Sheet,
    used: Collection[int],
    units: Iterable[tuple[str | None, str | None]],
    *,
    from_first: bool,
) -> Note | None:
    """The first text between the rows that may change unit, scale or zero of the readings from there on; None without.

    Parameters
    ----------
    used
        Lines of the readings.
    units
        Of the columns of readings, each with its base unit; None twice where it is not known.
    from_first
        Whether texts above the first of these lines count, too, as far as they are below the first row of the table.
    """
    if not used or not sheet.rows:
        return None
    first, last, known = sheet.rows[0][0] if from_first else min(used), max(used), frozenset(units)
    first_row = sheet.grid.get(sheet.rows[0][0], [])
    constant = {(place, cell) for place, cell in enumerate(first_row) if isinstance(cell, str)}
    headings = {key(name) for name in sheet.header}
    comments = list(_comments(sheet))
    between = [one for one in comments if first < one[0] <= last]
    for line, row in sheet.grid.items():
        texts = [cell for cell in row if isinstance(cell, str) and cell.rstrip(": ").isalpha()] if line in used else []
        if (label := next(filter(is_column_of_factors, texts), None)) is not None:  # "Faktor;1;0,01"
            return Note(line, label)
        words = [
            str(cell)
            for place, cell in enumerate(row)
            if isinstance(cell, str)
            and _NOTE.search(cell) is not None
            and not is_reading(cell)
            and (place, cell) not in constant
            and key(cell) not in headings
        ]
        if not words or not first < line <= last:
            continue
        if line in used or sum(map(is_reading, row)) > 1:
            found = next((text for text in words if _changes(text[:_LONGEST_LINE], known, beside=True)), None)
            if found is not None:
                return Note(line, found)
        else:
            between.append((line, _joined(row)))
    found_between = next((Note(*one) for one in sorted(between) if _changes(one[1], known, beside=False)), None)
    if found_between is not None:
        return found_between
    elsewhere = [one for one in comments if not first < one[0] <= last]
    elsewhere += [(line, _joined(row)) for line, row in sheet.grid.items() if line > last or line < sheet.header_line]
    placed = (one for one in elsewhere if _PLACED.search(one[1]) is not None)
    return next((Note(*one) for one in placed if _changes(one[1], known, beside=True, certain=True)), None)


@functools.lru_cache(maxsize=4096)
def _changes(
    text: str, known: frozenset[tuple[str | None, str | None]], *, beside: bool, certain: bool = False
) -> bool:
    """Whether a text may change units; ``beside`` a row of readings it may speak of something else.

    ``certain``: a unit behind ``in`` or in brackets counts in any words that are not those of the specimen.
    """
    switch = is_switch(text)
    if change_in(text) or (factor_in(text) is not None and (switch or not beside)):
        return True
    bases = {base for _, base in known}
    bases = {*BASES} if None in bases else bases
    text = _IN_OTHERS.sub("in ", text)
    for one in units_of(text):
        plain = one.certain or len(one.text.rstrip(".")) > 1 or _BEFORE_UNIT.search(text) is not None
        a_day = one.base == "day" and not one.certain and not switch  # "Day 2"
        if one.unit is None or not plain or a_day or _is_value(text, one) or one.base not in bases:
            continue
        other = (one.unit, one.base) not in known
        alone = not beside or _IN_FIRST.match(text) is not None
        named = certain and one.certain and not {"height", "specimen"} & {*quantities_of(one.label)}
        if (switch and not certain) or (other and (alone or named)):
            return True
    return False


def refuse_changes(
    name: str,
    sheet: Sheet,
    columns: Mapping[str, Picked],
    used: Collection[int],
    headings: Sequence[Heading],
    given: Sequence[str | None],
) -> None:
    """Refuse notes that may change the unit, scale or zero of the readings between their rows.

    Parameters
    ----------
    used
        Lines of the readings.
    headings, given
        Of x and y, and the units that somebody gave them.

    Raises
    ------
    TableError
        There is such a note.
    """
    units = [known_unit(unit or heading.unit or "") for unit, heading in zip(given, headings, strict=True)]
    x, y = columns["x"], columns["y"]
    note = _changing_note(sheet, used, units, from_first=x.place is not None)
    if note is None:
        return
    told = f"{name} line {note.line}: '{note.text}' may change the unit, scale or zero of readings from there on; "
    above = [line for line in used if line < note.line]
    one_part: Sentence = ("give the cells of one part",)
    if above and x.place is not None and y.place is not None:
        letters = [f"{column_letters(place)}{{}}".format for place in (x.place, y.place)]
        cells = [f"{of(min(above))}:{of(max(above))}" for of in letters]
        one_part = "give ", setting("x_column", cells[0]), " and ", setting("y_column", cells[1]), " for those above it"
    rest = ", ", setting("blocks"), " for several parts, or delete the note where it changes nothing"
    raise TableError((told, *one_part, *rest))


def refuse_headings(name: str, columns: Sequence[Picked], incomplete: Container[int]) -> None:
    """Refuse to leave out rows of words directly below the names: they may say what the numbers are.

    ``incomplete`` are the places of the rows that are left out.

    Raises
    ------
    TableError
        There are such rows, or other headings further down.
    """
    rows = range(len(columns[0].cells))
    first = next((i for i in rows if i not in incomplete), 0)
    for i in rows:
        cells = [one.cells[i] for one in columns if one.cells[i][1] != ""] if i in incomplete or i < first else []
        told = ", ".join(str(cell)[:50] for _, cell in cells)
        if i < first and not any(is_reading(cell) for _, cell in cells):
            what = f"{name} line {cells[0][0]}: '{told}' stands between the names and the first row of numbers"
            units = setting("x_unit"), " and ", setting("y_unit")
            raise TableError(
                (f"{what}; if these are unknown units, give ", *units, " and delete the row, else delete it")
            )
        if i in incomplete and len(cells) > 1 and all(is_heading(cell) for _, cell in cells):
            raise TableError(
                f"{name} line {cells[0][0]}: '{told}' are other headings or units than above; give the "
                "cells of one table, such as A2:A30, or delete the others"
            )
