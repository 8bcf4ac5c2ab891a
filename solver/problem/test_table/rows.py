"""The rows of a table of tests, with the words of their headings and cells understood."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, TypeAlias, get_args

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem.issues import describe, number, validated
from geoswarm.solver.problem.tables.cells import number_in, read_cells
from geoswarm.solver.problem.tables.headings import guess_unit
from geoswarm.solver.problem.tables.reading import TableError, file_content
from geoswarm.solver.problem.test_table.section import SpecimenRow, SpecimenTable, TestKind
from geoswarm.solver.sentences import Key
from geoswarm.solver.units import UnitError, convert
from geoswarm.solver.words import listed

__all__ = ["Files", "Row", "content_of", "rows_of", "said_once"]

Files: TypeAlias = Path | Mapping[str, bytes] | None
"""Where files are: a folder, what was sent by name, or nowhere (problems that came over the network)."""

FILES_REFUSED = (
    "files can only be read beside a problem file; ",
    Key(
        "files",
        "geoswarm inline PROBLEM writes the problem with its readings inside; POST /api/v1/problems/tests makes it of "
        "files that are sent",
        "tests",
    ),
)
_MOST_ROWS = 100
_MOST_NAMED = 5
_KINDS: dict[str, tuple[str, str | None]] = {
    "isotropic": ("isotropic_compression", None),
    "triaxial drained": ("triaxial", "drained"),
    "drained triaxial": ("triaxial", "drained"),
    "triaxial undrained": ("triaxial", "undrained"),
    "undrained triaxial": ("triaxial", "undrained"),
    "cd": ("triaxial", "drained"),
    "cid": ("triaxial", "drained"),
    "cu": ("triaxial", "undrained"),
    "ciu": ("triaxial", "undrained"),
}
"""Further words for a kind, and the drainage that they say."""
_HEADINGS = {
    "test": "name",
    "specimen": "name",
    "type": "kind",
    "e0": "initial_void_ratio",
    "e_0": "initial_void_ratio",
}
_BASES = {
    **dict.fromkeys(("cell_pressure", "initial_stress", "back_pressure", "water_bulk_modulus"), "kPa"),
    **dict.fromkeys(("height", "diameter"), "m"),
    "stage_duration": "day",
    "rate": "1/day",
    "initial_void_ratio": "1",
}
"""Numbers of a row in these units; the heading of a table's column names its own."""
_TEXT = ("name", "file", "sheet", "kind", "drainage", "material", "x", "x_unit")


@dataclass(frozen=True, slots=True)
class Row:
    """A row: its values by key, and where it is.

    ``path`` is that of all rows. ``number`` is its line in the ``table``, or its place in the list of the problem file
    where that is empty; ``headings`` are the columns of its keys.
    """

    values: Mapping[str, Any]
    path: str
    number: int
    table: str = ""
    headings: Mapping[str, str] = field(default_factory=dict)

    @property
    def section(self) -> SpecimenRow:
        """The row as a section, whose further keys are extra."""
        return SpecimenRow.model_validate(self.values)

    def issue(self, key: str, message: str) -> RowIssue:
        """A mistake in one of its values."""
        return self.issue_of_all([self.number], key, message)

    def issue_of_all(self, numbers: Sequence[int], key: str, message: str) -> RowIssue:
        """A mistake that rows with these numbers share."""
        first = re.split(r"[.\[]", key, maxsplit=1)[0]
        if self.table:
            column = f", column '{self.headings[first]}'" if first in self.headings else f", {key}" if key else ""
            lines = f"line {numbers[0]}" if len(numbers) == 1 else f"lines {listed(_named(numbers))}"
            path, said = self.path, f"{self.table} {lines}{column}: {message}"
        else:
            path = f"{self.path}[{numbers[0]}]" + (f".{key}" if key else "")
            others = [f"{self.path}[{number}]" for number in numbers[1:]]
            said = f"{message} (also {listed(_named(others))})" if others else message
        return RowIssue(path, said, row=self, key=key, own=message)


@dataclass(frozen=True, slots=True)
class RowIssue(Issue):
    """A mistake in a row: its ``key`` and ``own`` message, without the place of the row."""

    row: Row = field(kw_only=True)
    key: str = field(kw_only=True)
    own: str = field(kw_only=True)


def said_once(issues: Iterable[Issue]) -> list[Issue]:
    """Mistakes, those that rows share once with all their rows, in the order of the first."""
    found: dict[object, list[Issue]] = {}
    for issue in issues:
        shared = (issue.row.path, issue.row.table, issue.key, issue.own) if isinstance(issue, RowIssue) else issue
        found.setdefault(shared, []).append(issue)
    return [_together(alike) for alike in found.values()]


def _together(alike: Sequence[Issue]) -> Issue:
    first = alike[0]
    if not isinstance(first, RowIssue):
        return first
    numbers = list(dict.fromkeys(one.row.number for one in alike if isinstance(one, RowIssue)))
    return first.row.issue_of_all(numbers, first.key, first.own)


def _named(rows: Sequence[object]) -> list[str]:
    more = len(rows) - _MOST_NAMED
    return [*map(str, rows)] if more <= 1 else [*map(str, rows[:_MOST_NAMED]), f"{more} others"]


def content_of(files: Files, name: str) -> bytes:
    """What a file holds; of files that were sent, the one with this name, wherever it lay.

    Raises
    ------
    TableError
        There is no such file, or no file can be read.
    """
    if files is None:
        raise TableError(FILES_REFUSED)
    if isinstance(files, Path):
        return file_content(files / name)
    own = re.split(r"[\\/]", name)[-1]
    if own not in files:
        raise TableError(f"no such file: {name}; sent: {listed(list(files)[:_MOST_ROWS]) if files else 'none'}")
    return files[own]


def rows_of(given: Any, files: Files) -> list[Row]:
    """The rows of the section ``tests`` of a problem file.

    Raises
    ------
    ProblemError
        The section, its table or a row has mistakes.
    """
    if isinstance(given, str):
        given = {"table": given}
    elif isinstance(given, list):
        given = {"rows": given}
    section, issues = validated(SpecimenTable, given, "tests")
    if section is None:
        raise ProblemError(issues)
    if (section.table is None) == (section.rows is None):
        found = "neither is given" if section.table is None else "both are given"
        raise ProblemError([Issue("tests", f"give either table (a file) or rows (a list of tests); {found}")])
    common = {key: value for key, value in given.items() if key not in ("table", "table_sheet", "rows")}
    if section.table is not None:
        rows = _of_table(section.table, section.table_sheet, files)
    else:
        at = "tests" if "rows" not in given or len(given) == 1 else "tests.rows"
        rows = [Row(row, at, place) for place, row in enumerate(section.rows or ())]
    checked = [_checked(replace(row, values={**common, **row.values})) for row in rows]
    if issues := [issue for _, found in checked for issue in found]:
        raise ProblemError(issues)
    return [row for row, _ in checked]


def _of_table(table: str, sheet: str | None, files: Files) -> list[Row]:
    try:
        grid = read_cells(content_of(files, table), table, sheet).grid
    except TableError as error:
        raise ProblemError(error.issues("tests")) from None
    named = {line: [_key_of(heading) for heading in cells] for line, cells in grid.items()}
    first = next((line for line, found in named.items() if "file" in dict(found)), None)
    if first is None:
        shown = ", ".join(map(str, next(iter(grid.values()), [])))
        raise ProblemError([Issue("tests", f"{table} has no row of headings with the column file; it begins: {shown}")])
    keys, units = zip(*named[first], strict=True)
    twice = sorted({key for key in keys if key and keys.count(key) > 1})
    if twice:
        raise ProblemError([Issue("tests", f"{table} has the column {twice[0]} twice; leave one out")])
    below = [(line, cells) for line, cells in grid.items() if line > first and any(cell != "" for cell in cells)]
    if not 1 <= len(below) <= _MOST_ROWS:
        raise ProblemError([Issue("tests", f"{table} has {len(below)} rows; 1 to {_MOST_ROWS} are accepted")])
    headings = {key: str(heading) for key, heading in zip(keys, grid[first], strict=True)}
    rows = []
    for line, cells in below:
        row = Row({}, "tests", line, table, headings)
        values = {}
        for key, unit, cell in zip(keys, units, cells, strict=False):
            if key and cell != "":
                values[key] = _value(row, key, unit, cell)
                if unit is not None and key not in _BASES:  # the column of a series, with the unit that it has there
                    values.setdefault(f"{key}_unit", unit)
        rows.append(replace(row, values=values))
    return rows


def _key_of(heading: str | float) -> tuple[str, str | None]:
    """The key that a heading means, and its unit."""
    label, unit, _ = guess_unit(str(heading))
    key = re.sub(r"\W+", "_", label.strip()).strip("_")
    key = key if key == "K0" else key.casefold()
    return _HEADINGS.get(key, key), unit


def _value(row: Row, key: str, unit: str | None, cell: str | float) -> str | float:
    found = number_in(cell)
    if found is None or key in _TEXT or key.endswith("_unit"):
        return f"{cell:.15g}" if isinstance(cell, float) else cell
    base = _BASES.get(key)
    if base is None or (unit is None and base == "1"):
        return found
    if unit is None:
        raise ProblemError([row.issue(key, f"has no unit; name it in the heading, such as {key} [{base}]")])
    try:
        return float(convert(found, unit, base))
    except UnitError as error:
        raise ProblemError([row.issue(key, str(error))]) from None


def _checked(row: Row) -> tuple[Row, list[Issue]]:
    """The row with the kind in the word of the forward model, and what is wrong with it."""
    values = dict(row.values)
    kind = values.get("kind")
    if isinstance(kind, str):
        word = re.sub(r"[\W_]+", " ", kind).strip().casefold()
        plain = word.replace(" ", "_")
        values["kind"], drainage = _KINDS.get(word, (plain if plain in get_args(TestKind) else kind, None))
        if drainage is not None and values.setdefault("drainage", drainage) != drainage:
            return row, [row.issue("drainage", f"is {describe(values['drainage'])}, but kind is '{kind}'; give one")]
    section, issues = validated(SpecimenRow, values, "")
    found: list[Issue] = [row.issue(issue.path.removeprefix("."), issue.message) for issue in issues]
    if section is not None:
        needed: dict[str, object] = {"kind": section.kind, "file": section.file}
        needed |= {"material": values.get("material")}
        if section.kind == "triaxial":
            needed |= {"cell_pressure": section.cell_pressure}
        accepted = {"kind": "oedometer, isotropic_compression or triaxial", "file": "a file of readings"}
        accepted |= {"material": "the law, such as hypoplastic_sand", "cell_pressure": "a stress above 0 kPa"}
        found += [row.issue(key, f"is missing; {accepted[key]} is accepted") for key in needed if needed[key] is None]
        if section.kind != "triaxial":
            wrong = [key for key in ("cell_pressure", "drainage", "rate") if values.get(key) is not None]
            found += [row.issue(key, f"is for kind: triaxial; leave it out for {section.kind}") for key in wrong]
        elif section.stage_duration is not None:
            text = f"is for loads in stages, got {number(section.stage_duration)}; a triaxial test has a rate"
            found.append(row.issue("stage_duration", text))
    return replace(row, values=values), found
