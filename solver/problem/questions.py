"""The questions that a file leaves open: its columns and their units, with an answer to copy; the sign of a heave."""

from __future__ import annotations

import itertools
import re

from geoswarm.solver.errors import SolverError
from geoswarm.solver.forward.base import ForwardModelSpec, SeriesInfo
from geoswarm.solver.forward.registry import built
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.readings.units import USUAL
from geoswarm.solver.problem.tables.blocks import key
from geoswarm.solver.problem.tables.headings import Heading
from geoswarm.solver.problem.tables.measurements import Column, Measurements, read_measurements
from geoswarm.solver.problem.tables.quantities import is_heave
from geoswarm.solver.problem.tables.reading import TableError
from geoswarm.solver.sentences import Key, Sentence, setting
from geoswarm.solver.units import same_unit
from geoswarm.solver.words import listed

__all__ = ["columns_question", "sign_question"]

_MOST_SHOWN = 20
_MOST_RANKED = 50
_FIRST = 3
_NO_PLAIN_SCALAR = re.compile(
    r"^[\s\[\]{}&*!|>%@#,?\-`'\"]|:(?:\s|$)|\s#|\s$|^[\d.+]+$|^(?:true|false|null|yes|no|on|off|~)$", re.IGNORECASE
)
_DOWNWARDS = re.compile(r"settle|(?<!radial_)(?:displacement|strain)|setzung|verschiebung|verformung|dehnung")
_PREFIX = re.compile(r"^(?:stage|time|path|consolidation)_")


def columns_question(section: ObservationSection, content: bytes, name: str, spec: ForwardModelSpec | None) -> Sentence:
    """Ask for all that an observation does not say of the columns of x and y: lines to add, with the likely columns.

    Empty for blocks, and where the file, called ``name`` in messages, has no columns of numbers. ``spec``, as far as it
    is known, says which quantities are meant, and in what dimension.
    """
    if section.blocks is not None:
        return ()
    try:
        found = read_measurements(content, name, section.sheet)
    except TableError:
        return ()
    given = {key: getattr(section, key) for key in ("x_column", "x_unit", "y_column", "y_unit")}
    info, series = _info(section.series, spec), section.series
    quantities = {"x": "", "y": ""} if info is None else {"x": info.x_quantity, "y": info.y_quantity}
    bases = {"x": None, "y": None} if info is None else {"x": info.x_unit, "y": info.y_unit}
    names = {"x": "", "y": _PREFIX.sub("", series.rpartition(".")[2])}
    ranks = {
        axis: [_rank(one, {named, quantities[axis].replace(" ", "_")}, bases[axis]) for one in found.columns]
        for axis, named in names.items()
    }
    pairs = list(itertools.permutations(range(len(found.columns[:_MOST_RANKED])), 2)) or [(0, 0)]
    x, y = min(pairs, key=lambda pair: (*map(sum, zip(ranks["x"][pair[0]], ranks["y"][pair[1]], strict=True)), pair))
    asked = [(axis, found.columns[place]) for axis, place in (("x", x), ("y", y)) if given[f"{axis}_column"] is None]
    lines: list[str | Key] = []
    units = ""
    for axis, column in asked:
        lines += ["\n    ", _line(f"{axis}_column", _reference(found, column)), f"  # {_values(column)}"]
        if given[f"{axis}_unit"] is None and _lacks_unit(column, bases[axis], quantities[axis]):
            usual = re.split(r", | or ", USUAL.get(bases[axis] or "", "% or dimensionless"))
            lines += ["\n    ", _line(f"{axis}_unit", usual[0]), f"  # or {', '.join(usual[1:])}"]
            units = ", and in what unit"
        lines += _in_doubt(column, axis)
    lines += _specimen(found)
    if section.sheet is None and found.sheet is not None and found.alike:
        others = ", ".join(one for one in found.alike if one != found.sheet)
        lines += ["\n    ", _line("sheet", found.sheet), f"  # or {others}"]
    what = listed([axis if quantities[axis] in ("", axis) else f"{axis} ({quantities[axis]})" for axis, _ in asked])
    columns = [f"{_reference(found, one)} ({_values(one)})" for one in found.columns[:_MOST_SHOWN]]
    more = len(found.columns) - _MOST_SHOWN
    columns += [f"{more} more"] if more > 0 else []
    of = name if found.sheet is None else f"{name}, sheet '{found.sheet}'"
    question = f"{of}: which {'columns hold' if len(asked) > 1 else 'column holds'} {what}{units}? Add, for example,"
    return question, *lines, f"\n  columns: {'; '.join(columns)}"


def sign_question(section: ObservationSection, heading: Heading) -> Sentence | None:
    """Whether a heave is read as a settlement or a strain, which has the other sign, and nobody said so."""
    if "y_factor" in section.model_fields_set or not is_heave(heading.name):
        return None
    if _DOWNWARDS.search(section.series) is None:
        return None
    told = f"column '{heading.name}' is a heave, which {section.series} has with the other sign; give "
    return told, setting("y_factor", "-1"), ", or 1 where the numbers of the column have the sign of the series"


def _info(series: str, spec: ForwardModelSpec | None) -> SeriesInfo | None:
    try:
        infos = () if spec is None else built(spec).series
    except (SolverError, ValueError):  # said elsewhere
        return None
    return next((one for one in infos if one.name == series), None)


def _line(name: str, value: str) -> Key:
    quoted = "'" + value.replace("'", "''") + "'" if _NO_PLAIN_SCALAR.search(value) else value
    return Key(name, f"{name}: {quoted}", value)


def _values(column: Column) -> str:
    return ", ".join([" ".join(cell.split()) for cell in column.first if cell != ""][:_FIRST])


def _reference(found: Measurements, column: Column) -> str:
    """How a problem file calls a column: by its heading where no other has it, else by its letters or cells."""
    if ":" in column.letters:
        return column.letters
    alone = sum(key(one.name) == key(column.name) for one in found.columns) == 1
    named = alone and re.fullmatch(r"column \d+", column.name) is None and column.name.isprintable()
    return column.name if named else f"{column.letters}:{column.letters}"


def _lacks_unit(column: Column, base: str | None, quantity: str) -> bool:
    if base is None or column.kind != "number":
        return False
    pure = same_unit(base, "1") and "strain" not in quantity
    return column.unit is None and (column.unclear is not None or not pure)


def _in_doubt(column: Column, axis: str) -> list[str | Key]:
    """How numbers, dates or times of a column are written, where that is to be said."""
    shown = f"{column.doubt or next(filter(None, column.first), '')}"
    if column.kind == "number" and column.doubt is not None:
        return ["\n    ", _line("decimal_sign", "point"), f"  # or comma: {shown} may be read in two ways"]
    if axis == "x" and column.kind == "time" and column.doubt is not None:
        return ["\n    ", _line("x_dates", "day_first"), f"  # or month_first, year_first: {shown} may be either"]
    if axis == "x" and column.kind == "clock":
        return ["\n    ", _line("x_dates", "hh:mm:ss"), "  # the time since the start, or mm:ss, hh:mm"]
    return []


def _specimen(found: Measurements) -> list[str | Key]:
    """Which of several specimens."""
    for column in found.columns:
        if "specimen" in column.quantities and 1 < len(column.entries) < found.rows:
            first, *others = column.entries
            where = f"{{{_line('', _reference(found, column)).text[2:]}: {_line('', first).text[2:]}}}"
            return ["\n    ", Key("where", f"where: {where}", where), f"  # or {', '.join(others[:_MOST_SHOWN])}"]
    return []


def _rank(column: Column, names: set[str], base: str | None) -> tuple[int, int]:
    """How well a column suits an axis, 0 best: by its words, else by a word like these, else by its dimension."""
    places = [place for place, one in enumerate(column.quantities) if one in names or f"mean_{one}" in names]
    if places:
        return 0, places[0]
    if any("strain" in name for name in names) and any("strain" in one for one in column.quantities):
        return 1, 0
    if base is not None and column.base == (base or "dimensionless") and column.quantities != ("heave",):
        return 2, 0
    return 3, 2 if column.kind in ("text", "clock") else int(column.base is not None or column.quantities != ())
