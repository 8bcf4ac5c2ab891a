"""The questions that a file leaves open: its columns and their units, with an answer to copy; the sign of a heave."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from geoswarm.solver.errors import Issue, SolverError
from geoswarm.solver.forward.base import ForwardModelSpec, SeriesInfo
from geoswarm.solver.forward.registry import built
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.readings.units import USUAL, divided_by_size, unit_of_axis
from geoswarm.solver.problem.stages import section_of_test
from geoswarm.solver.problem.tables.blocks import key
from geoswarm.solver.problem.tables.columns import Columns, Table
from geoswarm.solver.problem.tables.headings import Heading, without_brackets
from geoswarm.solver.problem.tables.measurements import Column, Measurements, read_measurements
from geoswarm.solver.problem.tables.quantities import dimension_of, is_heave, is_load, quantities_of
from geoswarm.solver.problem.tables.reading import DoubtError, TableError
from geoswarm.solver.sentences import Key, Sentence, setting
from geoswarm.solver.units import convert, same_unit
from geoswarm.solver.words import listed

__all__ = ["columns_question", "further_doubts", "sign_question"]

_MOST_SHOWN = 20
_MOST_RANKED = 50
_FIRST = 3
_ALIKE, _UNTOLD, _OTHER, _NOTHING = 1, 4, 6, 7
"""Ranks of columns: words of another strain, no word or unit that says what they hold, words or units of another
quantity, no numbers."""
_SLACK = 1.0 + 1e-9
_ROUNDED = 0.01
"""Part of a load that a file may round."""
_NO_PLAIN_SCALAR = re.compile(
    r"^[\s\[\]{}&*!|>%@#,?\-`'\"]|:(?:\s|$)|\s#|\s$|^[\d.+]+$|^(?:true|false|null|yes|no|on|off|~)$", re.IGNORECASE
)
_EFFECTIVE = re.compile(r"['’′]|eff|wirks", re.IGNORECASE)
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
    info = _info(section.series, spec)
    axes = [_Axis.of("x", section, info), _Axis.of("y", section, info)]
    columns = found.columns[:_MOST_RANKED]
    ranks = [[axis.rank(one) for one in columns] for axis in axes]
    pairs = list(itertools.permutations(range(len(columns)), 2)) or [(0, 0)]
    best = min(pairs, key=lambda pair: (*map(sum, zip(ranks[0][pair[0]], ranks[1][pair[1]], strict=True)), pair))
    less = _difference(axes[1], columns, ranks[1][best[1]][0]) if section.y_minus is None else None
    best = best if less is None else (best[0], less[0])
    asked = [(axis, place, own) for axis, place, own in zip(axes, best, ranks, strict=True) if axis.column is None]
    lines: list[str | Key] = []
    units = ""
    for axis, place, own in asked:
        column = columns[place]
        alike = [] if own[place][0] < _UNTOLD else [one for i, one in enumerate(columns) if own[i] == own[place]]
        others = [
            _reference(found, one) for one in alike if one is not column and one not in (columns[i] for i in best)
        ]
        told = f"; or {', '.join(others[:_FIRST])}: no heading says so" if others else ""
        if own[place][0] == _ALIKE and axis.quantity.replace(" ", "_") not in column.quantities:
            told = f"; its heading says {column.quantities[0].replace('_', ' ')}"
        minus: list[str | Key] = []
        if axis.name == "y" and less is not None:
            told = ""
            minus = ["\n    ", _line("y_minus", _reference(found, columns[less[1]])), "  # q is their difference"]
        elif own[place][0] > _UNTOLD:
            told = f"; no heading says {axis.quantity or axis.name}"
        lines += [
            "\n    ",
            _line(f"{axis.name}_column", _reference(found, column)),
            f"  # {_shown(found, column)}{told}",
        ]
        lines += minus
        further = axis.unit_lines(column)
        units = ", and in what unit" if further else units
        lines += further + _in_doubt(column, axis.name)
    stresses = _stresses(section.series, spec)
    lines += _rows_lines(found, columns[best[0]], columns[best[1]], axes[0], section, stresses)
    lines += _specimen(found) if section.where is None else []
    lines += _sheet_lines(found, [columns[place] for _, place, _ in asked]) if section.sheet is None else []
    what = listed(
        [axis.name if axis.quantity in ("", axis.name) else f"{axis.name} ({axis.quantity})" for axis, *_ in asked]
    )
    listing = [f"{_reference(found, one)} ({_shown(found, one)})" for one in found.columns[:_MOST_SHOWN]]
    more = len(found.columns) - _MOST_SHOWN
    listing += [f"{more} more"] if more > 0 else []
    of = name if found.sheet is None else f"{name}, sheet '{found.sheet}'"
    question = f"{of}: which {'columns hold' if len(asked) > 1 else 'column holds'} {what}{units}? Add, for example,"
    return question, *lines, f"\n  columns: {'; '.join(listing)}"


@dataclass(frozen=True, slots=True)
class _Axis:
    """An axis of a series: ``names`` of what it may be called, its dimension ``base``, None where it is not known.

    ``column`` and ``unit`` are those of the observation; ``low`` and ``high`` bound the values, base unit.
    """

    name: str
    quantity: str
    names: frozenset[str]
    base: str | None
    column: str | None
    unit: str | None
    low: float = -math.inf
    high: float = math.inf
    increasing: bool = False

    @classmethod
    def of(cls, name: str, section: ObservationSection, info: SeriesInfo | None) -> _Axis:
        given = getattr(section, f"{name}_column"), getattr(section, f"{name}_unit")
        series = _PREFIX.sub("", section.series.rpartition(".")[2])
        own = "" if name == "x" else series
        if info is None:
            return cls(name, "", frozenset({own}), None, *given)
        quantity, base = getattr(info, f"{name}_quantity"), getattr(info, f"{name}_unit")
        names = frozenset({own, quantity.replace(" ", "_")})
        if name == "y":
            return cls(name, quantity, names, base, *given)
        low = -math.inf if info.x_lower is None else info.x_lower
        high = math.inf if info.x_upper is None else info.x_upper
        return cls(name, quantity, names, base, *given, low, high, info.x_increasing)

    @property
    def by_load(self) -> bool:
        """Whether loads may stand instead of the numbers of stages."""
        return self.name == "x" and self.quantity == "stage"

    def rank(self, column: Column) -> tuple[int, int]:
        """How well a column suits, 0 best: by its words, by words like these, by its dimension; last by other words."""
        values = [value for value in column.values if value is not None]
        if column.kind in ("text", "clock") or not (values or column.doubt):
            return _NOTHING, 0
        places = [i for i, one in enumerate(column.quantities) if one in self.names or f"mean_{one}" in self.names]
        repeated = self.by_load and len(set(values)) < len(values)  # stage numbers that choose a part of the table
        if places and not repeated:
            return 0, places[0]
        if any("strain" in one for one in self.names) and any("strain" in one for one in column.quantities):
            return _ALIKE, 0
        if self.by_load and column.base in ("kPa", None) and column.other_unit is None and is_load(column.quantities):
            return 0, 1
        meant = self.base or "dimensionless"
        said = {dimension_of(one) for one in column.quantities} - {None}
        own = self.name == "x" and meant in said
        other = bool(column.quantities) and not own and self.base is not None
        if column.base is not None or column.other_unit is not None:
            if column.base == meant and "heave" not in column.quantities:
                return (_OTHER - 1 if other else 2), 0
            return (3 if self._divided(column) is not None else _OTHER), 0
        if said and self.base is not None:
            return (2 if own else _OTHER), 0
        numbered = self.name == "y" and values in ([*range(len(values))], [*range(1, len(values) + 1)])
        few = len(values) * 2 < len(column.values)
        return _UNTOLD, int(other) + 2 * int(not self._fits(values)) + 4 * int(numbered) + 8 * int(
            few or column.bad > 0
        )

    def _divided(self, column: Column) -> tuple[str, str, str] | None:
        """What makes a strain of a length and a stress of a force, see :func:`divided_by_size`."""
        if self.base != "kPa" and (self.base != "" or "strain" not in self.quantity):
            return None
        return divided_by_size(column.unit or column.other_unit or "", self.base)

    def _fits(self, values: Sequence[float]) -> bool:
        """Whether numbers without a unit may be those of this axis: they rise or fall, and some usual unit suits."""
        rising = all(one <= other for one, other in itertools.pairwise(values))
        falling = all(one >= other for one, other in itertools.pairwise(values))
        return (rising or falling or not self.increasing) and self._unit_of(values) is not None

    def _unit_of(self, values: Sequence[float]) -> str | None:
        """Of the usual units the one in which numbers come closest to the end of the series, as an example."""
        usual = _usual(self.base)
        if self.base is None or not math.isfinite(self.high):
            return usual[0]
        largest = max(map(abs, values), default=0.0)
        ends = {unit: float(convert(largest, unit, self.base or "1")) for unit in usual}
        within = [unit for unit in usual if ends[unit] <= self.high * _SLACK]
        return max(within, key=lambda unit: ends[unit], default=None)

    def unit_lines(self, column: Column) -> list[str | Key]:
        """The line that says the unit of a column, where that is to be said."""
        if self.unit is not None or self.base is None or column.kind != "number":
            return []
        key = f"{self.name}_unit"
        if self.by_load:
            if column.base is not None or not is_load(column.quantities):
                return []
            return ["\n    ", _line(key, "kPa"), "  # or MPa, kg/cm2: of the loads, by which the stages are found"]
        if column.base != (self.base or "dimensionless") and (factor := self._divided(column)) is not None:
            amount, size, unit = factor
            lines: list[str | Key] = ["\n    ", _line(key, self.base or "dimensionless")]
            return [*lines, "\n    ", _line(f"{self.name}_factor", amount), f"  # the {size} [{unit}] of the specimen"]
        pure = same_unit(self.base, "1") and "strain" not in self.quantity
        if column.unit is not None or (pure and column.unclear is None):
            return []
        usual = _usual(self.base)
        first = self._unit_of([value for value in column.values if value is not None]) or usual[0]
        others = ", ".join(one for one in usual if one != first)
        told = f"  # its heading {column.unclear}" if column.unclear else f"  # or {others}" if others else ""
        return ["\n    ", _line(key, first), told]


def further_doubts(
    section: ObservationSection,
    path: str,
    read: Callable[[Columns], Table],
    columns: Columns,
    doubt: DoubtError,
    spec: ForwardModelSpec | None,
) -> list[Issue]:
    """What else of a column is open, once the doubt is answered in one of the ways."""
    assumed = replace(columns, **doubt.assumed)
    try:
        table = read(assumed)
    except DoubtError as other:
        issues = other.issues(f"{path}.file", f"{path}.")
        return issues + further_doubts(section, path, read, assumed, other, spec)
    except TableError:
        return []
    info = _info(section.series, spec)
    if info is None:
        return []
    asked = []
    for axis, given, heading in (("x", section.x_unit, table.x_heading), ("y", section.y_unit, table.y_heading)):
        wrong = unit_of_axis(axis, given, info, heading)[1] if getattr(info, f"{axis}_quantity") != "stage" else None
        if wrong is not None:
            asked.append(Issue.about(f"{path}.{axis}_{'unit' if given else 'column'}", wrong, f"{path}."))
    return asked


def sign_question(section: ObservationSection, heading: Heading) -> Sentence | None:
    """Whether a heave or a height is read as a settlement or a strain, and nobody said so."""
    if "y_factor" in section.model_fields_set or _DOWNWARDS.search(section.series) is None:
        return None
    if "height" in quantities_of(without_brackets(heading.name)):
        zero = setting("y_factor", "-1"), " and ", setting("y_zero", "first")
        return f"column '{heading.name}' is a height, and {section.series} is the loss of it; give ", *zero
    if not is_heave(heading.name):
        return None
    told = f"column '{heading.name}' is a heave, which {section.series} has with the other sign; give "
    return told, setting("y_factor", "-1"), ", or 1 where the numbers of the column have the sign of the series"


def _info(series: str, spec: ForwardModelSpec | None) -> SeriesInfo | None:
    """What is known of a series; None where the forward model is not complete, or has none of this name."""
    try:
        infos = () if spec is None else built(spec).series
    except (SolverError, ValueError):  # said elsewhere
        return None
    return next((one for one in infos if one.name == series), None)


def _usual(base: str | None) -> list[str]:
    """Units that laboratories write, as examples."""
    return re.split(r", | or ", USUAL.get(base or "", base or "% or dimensionless"))


def _line(name: str, value: str) -> Key:
    return Key(name, f"{name}: {_quoted(value)}", value)


def _quoted(value: str) -> str:
    return "'" + value.replace("'", "''") + "'" if _NO_PLAIN_SCALAR.search(value) else value


def _shown(found: Measurements, column: Column) -> str:
    """The heading of a column that is called by its letters, and its first values."""
    named = _reference(found, column) == column.name or re.fullmatch(r"column \d+", column.name) is not None
    heading = "" if named or not column.name.isprintable() else f"{' '.join(column.name.split())}: "
    return heading + ", ".join([" ".join(cell.split()) for cell in column.first if cell != ""][:_FIRST])


def _reference(found: Measurements, column: Column) -> str:
    """How a problem file calls a column: by its heading where no other has it, else by its letters or cells."""
    if ":" in column.letters:
        return column.letters
    alone = sum(key(one.name) == key(column.name) for one in found.columns) == 1
    named = alone and re.fullmatch(r"column \d+", column.name) is None and column.name.isprintable()
    return column.name if named else f"{column.letters}:{column.letters}"


def _difference(axis: _Axis, columns: Sequence[Column], rank: int) -> tuple[int, int] | None:
    """Places of an axial and a radial stress of which a deviator stress is the difference, where no column holds it."""
    if "q" not in axis.names or axis.column is not None or rank < _UNTOLD:
        return None
    axial, radial = (
        [i for i, one in enumerate(columns) if word in one.quantities and one.base in ("kPa", None)]
        for word in ("axial_stress", "radial_stress")
    )
    kinds = [(one.base, _EFFECTIVE.search(one.name) is None) for one in columns]
    return next(((i, j) for i in axial for j in radial if kinds[i] == kinds[j]), None)


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


def _rows_lines(
    found: Measurements, x: Column, y: Column, axis: _Axis, section: ObservationSection, stresses: Sequence[float]
) -> list[str | Key]:
    """Which rows take part: of one stage, with a number in every column; and x that begin before the series or fall.

    ``stresses`` are the loads of the stages, where x may be such loads.
    """
    if ":" in x.letters + y.letters:
        return []
    rows = list(range(min(len(x.values), len(y.values))))
    lines: list[str | Key] = []
    if section.where is None and not axis.by_load and _falls([x.values[row] for row in rows]):
        lines, rows = _stage(found, x, rows)
    alone = sum((x.values[row] is None) != (y.values[row] is None) for row in rows)
    if section.incomplete_rows is None and x.doubt is None and y.doubt is None and alone:
        count = "1 row has" if alone == 1 else f"{alone} rows have"
        lines += _added("incomplete_rows", "leave_out", f"{count} no number in one of the columns")
    given = [x.values[row] for row in rows if y.values[row] is not None]
    values = [value for value in given if value is not None]
    if x.doubt is not None or not values or {"x_factor", "x_from"} & section.model_fields_set:
        return lines
    if axis.by_load:
        loads = x.base == "kPa" or is_load(x.quantities)
        first = float(convert(values[0], x.unit or "kPa", "kPa")) if loads else values[0]
        low = max(stresses[:1], default=0.0) * (1.0 - _ROUNDED) if loads else axis.low
        early = f"x begins at {values[0]:g}, before the first stage"
        return lines + (_added("x_from", "1", early) if first < low else [])
    if axis.low == 0.0 and min(values) < 0.0 and x.kind == "number":
        if max(values) <= 0.0:
            return lines + _added("x_factor", "-1", "no x is above 0")
        lines += _added("x_from", "0", f"x begins at {min(values):g}")
        values = [value for value in values if value >= 0.0]
    if axis.increasing and not section.sort and _falls(values):
        lines += _added("sort", "true", "x does not always rise")
    if axis.increasing and section.repeated_x is None and len(set(values)) < len(values):
        lines += _added("repeated_x", "average", "or shift: several rows have the same x")
    return lines


def _stresses(series: str, spec: ForwardModelSpec | None) -> list[float]:
    """Loads of the stages, kPa, of the test that a series belongs to."""
    stages = () if spec is None else getattr(section_of_test(spec, series)[1], "stages", ())
    return [stage.stress for stage in stages if hasattr(stage, "stress")]


def _stage(found: Measurements, x: Column, rows: list[int]) -> tuple[list[str | Key], list[int]]:
    """The stage in which x changes most, where a column has several, and its rows; else all of them."""
    for column in found.columns:
        entries = [column.values[row] for row in rows] if "stage" in column.quantities and column.values else []
        if column is x or None in entries or not 1 < len(set(entries)) <= min(_MOST_SHOWN, len(rows) - 1):
            continue
        of = {entry: [row for row, one in zip(rows, entries, strict=True) if one == entry] for entry in entries}
        spans = {entry: _span([x.values[row] for row in own]) for entry, own in of.items()}
        best = max(spans, key=lambda entry: spans[entry])
        where = f"{{{_quoted(_reference(found, column))}: {best:.15g}}}"
        others = ", ".join(f"{entry:.15g}" for entry in of if entry != best)
        return ["\n    ", Key("where", f"where: {where}", where), f"  # or {others}"], of[best]
    return [], rows


def _span(values: Sequence[float | None]) -> float:
    known = [value for value in values if value is not None]
    return max(known) - min(known) if known else 0.0


def _falls(values: Sequence[float | None]) -> bool:
    known = [value for value in values if value is not None]
    return any(one > other for one, other in itertools.pairwise(known))


def _added(name: str, value: str, why: str) -> list[str | Key]:
    return ["\n    ", Key(name, f"{name}: {value}", value), f"  # {why}"]


def _sheet_lines(found: Measurements, columns: Sequence[Column]) -> list[str | Key]:
    """Which sheet, where others have the same headings, or columns that letters name."""
    lettered = any(":" in _reference(found, one) for one in columns)
    others = found.alike or (found.sheets if lettered and len(found.sheets) > 1 else ())
    if found.sheet is None or not others:
        return []
    return ["\n    ", _line("sheet", found.sheet), f"  # or {', '.join(one for one in others if one != found.sheet)}"]
