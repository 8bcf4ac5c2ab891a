"""Measured points of an observation's section, inside the problem or in a file, prepared as the section says."""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.problem.issues import number, validated
from geoswarm.solver.problem.observation_section import ObservationSection
from geoswarm.solver.problem.questions import columns_question, further_doubts, sign_question
from geoswarm.solver.problem.readings.joined import BlockError, BlockSection, joined
from geoswarm.solver.problem.readings.preparation import Preparation, PreparationError, Readings, prepared
from geoswarm.solver.problem.readings.units import UNSTATED
from geoswarm.solver.problem.stages import by_stage, stage_times
from geoswarm.solver.problem.tables.blocks import shown
from geoswarm.solver.problem.tables.cells import read_cells
from geoswarm.solver.problem.tables.columns import Columns, Table, table_of
from geoswarm.solver.problem.tables.dates import moment_in
from geoswarm.solver.problem.tables.headings import Heading, unclear_unit
from geoswarm.solver.problem.tables.reading import DoubtError, TableError, UnnamedColumnsError, file_content
from geoswarm.solver.problem.text.reading import read_document
from geoswarm.solver.sentences import Key, relative
from geoswarm.solver.units import UnitError, convert

__all__ = [
    "Points",
    "columns_of",
    "known_spec",
    "measured_points",
    "points_of_file",
    "read_points",
    "units_found",
]


@dataclass(frozen=True, slots=True)
class Points:
    """Measured points in the user's units, lists of one length.

    ``weight`` None means not given: points count by the ``readings`` of which they are means (None: 1 each).
    ``independent`` is the number of independent readings that these are worth, ``range`` the largest less the smallest
    of them; None: not known. ``inputs`` are further quantities at the points, by name. ``gross_errors`` are the places
    of those that are shown and do not count, ``notes`` say what was done to the readings. ``x_heading`` and
    ``y_heading`` are those of the file that they were read from; ``by_load``: it had loads instead of stages.
    """

    x: list[float]
    y: list[float]
    weight: list[float] | None = None
    readings: list[float] | None = None
    independent: float | None = None
    range: float | None = None
    inputs: dict[str, list[float]] = field(default_factory=dict)
    gross_errors: tuple[int, ...] = ()
    notes: tuple[str, ...] = ()
    x_heading: Heading | None = field(default=None, compare=False)
    y_heading: Heading | None = field(default=None, compare=False)
    by_load: bool = field(default=False, compare=False)

    @property
    def counts(self) -> FloatArray:
        """Number of readings behind each point."""
        return np.ones(len(self.x)) if self.readings is None else np.array(self.readings, dtype=np.float64)

    def share_of(self, chosen: BoolArray) -> float:
        """Share of the readings behind the chosen points in all but the gross errors."""
        count = self.counts
        return float(count[chosen].sum() / np.delete(count, self.gross_errors).sum())

    def mean_error(self, chosen: BoolArray) -> float:
        """Standard deviation of a chosen point over that of a reading: a point may be a mean."""
        if self.independent is None:
            return 1.0
        return math.sqrt(int(chosen.sum()) / max(self.independent * self.share_of(chosen), 1.0))

    def range_of(self, chosen: BoolArray) -> float | None:
        """Range of the readings behind the chosen points: as much wider than that of the points as that of all."""
        if self.range is None:
            return None
        y = np.array(self.y)
        whole = float(np.ptp(np.delete(y, self.gross_errors)))
        return self.range * (float(np.ptp(y[chosen])) / whole if whole > 0.0 else 1.0)

    def chosen(self, chosen: BoolArray) -> Points:
        """Some of the points, in the same order."""
        places = np.flatnonzero(chosen).tolist()

        def of(values: list[float] | None) -> Any:
            return None if values is None else [values[place] for place in places]

        return replace(
            self,
            x=of(self.x),
            y=of(self.y),
            weight=of(self.weight),
            readings=of(self.readings),
            inputs={name: of(values) for name, values in self.inputs.items()},
            gross_errors=tuple(new for new, place in enumerate(places) if place in self.gross_errors),
        )

    def document(self) -> dict[str, Any]:
        """The ``points`` section."""
        lists = {"x": self.x, "y": self.y, "weight": self.weight, "readings": self.readings}
        document: dict[str, Any] = {
            name: [float(value) for value in values] for name, values in lists.items() if values is not None
        }
        known = {"independent": self.independent, "range": self.range}
        document |= {name: value for name, value in known.items() if value is not None}
        return document | ({"inputs": self.inputs} if self.inputs else {})


def read_points(
    section: ObservationSection, path: str, folder: Path | None, spec: ForwardModelSpec | None = None
) -> tuple[Points | None, list[Issue]]:
    """Points of a section, read from its file if it names one.

    Parameters
    ----------
    folder
        Where relative files lie; None when no files may be read (problems that came over the network).
    spec
        Of the forward model, as far as it is known: it says when loads are applied.
    """
    if section.points is not None:
        given = section.points
        points = Points(
            given.x,
            given.y,
            given.weight,
            given.readings,
            given.independent,
            given.range,
            given.inputs or {},
            notes=tuple(section.notes),
        )
        issues = _length_issues(points, f"{path}.points")
        return (points, issues) if issues else _prepared(points, section, path, spec)
    assert section.file is not None
    if folder is None:
        key = Key("files", "give the points themselves (points: {x: [..], y: [..]})", "readings")
        return None, [Issue.about(f"{path}.file", ("files can only be read beside a problem file; ", key))]
    file = folder / section.file
    try:
        content = file_content(file)
    except TableError as error:
        return None, error.issues(f"{path}.file")
    return points_of_file(section, path, content, file.name, spec)


def measured_points(
    observation: str, content: bytes, name: str, forward_model: str | None = None
) -> tuple[Points, dict[str, str]]:
    """Points of a file that is not part of a problem yet, and ``x_unit`` and ``y_unit`` that they are in.

    A unit is the one that the observation gives, or that the file names; ``unstated`` where there is neither.

    Parameters
    ----------
    observation
        Which of it they are, as JSON: an observation of a problem file but for ``file`` and ``points``.
    content, name
        The file, and what it is called in messages.
    forward_model
        Of the problem, as JSON, as far as it is known: it says when loads are applied.

    Raises
    ------
    ProblemError
        The observation has mistakes, or the file cannot be read so; paths are those within the observation.
    """
    given = {**read_document(observation, "json"), "file": name}
    section, issues = validated(ObservationSection, given, "")
    if section is None:
        raise ProblemError(issues)
    spec = None if forward_model is None else known_spec(read_document(forward_model, "json"))
    points, issues = points_of_file(section, "", content, name, spec)
    if points is None or issues:
        sentences = [(issue.path.removeprefix("."), issue.parts or (issue.message,)) for issue in issues]
        raise ProblemError([Issue.about(path, relative(sentence)) for path, sentence in sentences])
    units = {"x_unit": section.x_unit, "y_unit": section.y_unit}
    if points.by_load:
        units["x_unit"] = "dimensionless"
    return points, units_found(points) | {axis: unit for axis, unit in units.items() if unit is not None}


def units_found(points: Points) -> dict[str, str]:
    """``x_unit`` and ``y_unit`` of points from a file, by its headings and cells."""
    units = {}
    for axis, heading in (("x_unit", points.x_heading), ("y_unit", points.y_heading)):
        if heading is not None:
            units[axis] = UNSTATED if unclear_unit(heading.named) else heading.unit or UNSTATED
    return units


def points_of_file(
    section: ObservationSection, path: str, content: bytes, name: str, spec: ForwardModelSpec | None = None
) -> tuple[Points | None, list[Issue]]:
    """Points of a section from the content of its file, called ``name`` in messages."""
    table, done, issues = _table(section, path, content, name, spec)
    if table is None:
        return None, issues
    if (sign := sign_question(section, table.y_heading)) is not None:
        return None, [Issue.about(f"{path}.y_column", sign, f"{path}.")]
    table, wrong = by_stage(table, section, spec)
    if wrong is not None:
        return None, [Issue.about(f"{path}.x_column", wrong, f"{path}.")]
    points = Points(
        table.x,
        table.y,
        table.weight,
        inputs=table.inputs,
        gross_errors=tuple(table.gross_errors),
        notes=(*section.notes, *done, *_reading_notes(section, table, name)),
        by_load=table.by_load,
        x_heading=table.x_heading,
        y_heading=table.y_heading,
    )
    issues = _weight_issues(points, f"{path}.file")
    return (points, issues) if issues else _prepared(points, section, path, spec)


def _table(
    section: ObservationSection, path: str, content: bytes, name: str, spec: ForwardModelSpec | None
) -> tuple[Table | None, list[str], list[Issue]]:
    """The table of a section, of all its blocks if it has some; what was done, and what is wrong."""
    read = functools.cache(read_cells)  # blocks of one sheet
    tables: list[Table] = []
    blocks: Sequence[BlockSection | None] = section.blocks or [None]
    parts = [columns_of(_of_block(section, block)) for block in blocks]
    for place, part in enumerate(parts):
        at = f"{path}.file" if section.blocks is None else f"{path}.blocks[{place}]"
        alike = parts.count(part)
        turn = (parts[:place].count(part), alike) if alike > 1 and part.where else None
        try:
            tables.append(_settled(table_of(content, name, replace(part, turn=turn), read), section))
        except UnnamedColumnsError as error:
            asked = columns_question(section, content, name, spec)
            return None, [], [Issue.about(at, asked, f"{path}.")] if asked else error.issues(at, f"{path}.")
        except DoubtError as error:
            read_again = functools.partial(table_of, content, name, read=read)
            return None, [], error.issues(at, f"{path}.") + further_doubts(section, path, read_again, part, error, spec)
        except TableError as error:
            return None, [], error.issues(at, f"{path}.")
    if section.blocks is None:
        return tables[0], [], []
    starts = np.empty(0) if spec is None else stage_times(spec, section.series)
    try:
        table, done = joined(section.blocks, tables, (section.x_unit, section.y_unit), starts)
    except BlockError as error:
        return None, [], [Issue.about(f"{path}.blocks[{error.place}].{error.key}", error.sentence, f"{path}.")]
    return table, [f"{name}: {done}"], []


def _settled(table: Table, section: ObservationSection) -> Table:
    """The table without the factors and offsets of its headings about which the section says what is done."""
    x, y, given = table.x_heading, table.y_heading, section.model_fields_set
    x = x.without("factor", "sign") if "x_factor" in given else x
    y = y.without("factor", "sign") if "y_factor" in given else y
    return replace(table, x_heading=x, y_heading=y.without("offset") if {"y_zero", "y_minus"} & given else y)


def _of_block(section: ObservationSection, block: BlockSection | None) -> ObservationSection:
    if block is None:
        return section
    given = {key: getattr(block, key) for key in ("sheet", "x_column", "y_column") if getattr(block, key) is not None}
    return section.model_copy(update=given | {"where": {**(section.where or {}), **(block.where or {})}})


def columns_of(section: ObservationSection) -> Columns:
    """Which columns of its file a section reads."""
    return Columns(
        section.x_column,
        section.y_column,
        section.weight_column,
        section.sheet,
        None if section.x_origin is None else moment_in(section.x_origin),
        section.inputs or {},
        section.y_minus,
        section.where or {},
        section.x_dates,
        section.x_time_column,
        section.gross_error_column,
        section.decimal_sign,
        section.incomplete_rows,
        no_reading=None if section.no_reading is None else tuple(section.no_reading),
        gross=tuple(section.gross_errors),
        units=(section.x_unit, section.y_unit),
    )


def _reading_notes(section: ObservationSection, table: Table, name: str) -> list[str]:
    """What of a file was read, where that is more than columns of numbers."""
    notes = []
    if section.where:
        notes.append(
            f"rows of {name} with {', '.join(f'{key} = {shown(value)}' for key, value in section.where.items())}"
        )
    if section.y_minus is not None:
        notes.append(f"y is the difference of two columns: {table.y_heading.name} less {section.y_minus}")
    for key, heading in table.input_headings.items():
        if heading.named:
            unit = heading.unit or heading.named[0].text
            notes.append(f"{key} is in {unit}, as its column says: the formula takes its numbers unchanged")
    if table.by_load:
        notes.append(f"x is the number of the stage with the load of column {table.x_heading.name}")
    if table.zero is not None:
        notes.append(f"x counts from {table.zero.isoformat(sep=' ', timespec='seconds')}")
    if table.left_out:
        rows = "1 row" if table.left_out == 1 else f"{table.left_out} rows"
        notes.append(
            f"{rows} of {name} without a number in every column {'was' if table.left_out == 1 else 'were'} left out"
        )
    return [note if note.isprintable() else repr(note) for note in notes]


def _prepared(
    points: Points, section: ObservationSection, path: str, spec: ForwardModelSpec | None
) -> tuple[Points, list[Issue]]:
    """The readings as the section wants them; the canonical problem has what comes of it."""
    count = len(points.x)
    beyond = [place for place in section.gross_errors if place > count]
    if beyond:
        return points, [Issue(f"{path}.gross_errors", f"there is no reading {beyond[0]}; there are {count}")]
    marked = tuple(sorted({*points.gross_errors, *(place - 1 for place in section.gross_errors)}))
    more = points.readings, points.independent, points.range
    given = Readings(points.x, points.y, points.weight, points.inputs, marked, *more)
    wanted = Preparation(
        zero=section.y_zero,
        x_factor=section.x_factor,
        y_factor=section.y_factor,
        sort=section.sort,
        repeated_x=section.repeated_x,
        resample=section.resample,
        error=section.error,
        loads=_loads(points, section, spec),
    )
    try:
        found, done = prepared(given, wanted)
    except PreparationError as error:
        return points, [Issue.about(f"{path}.{error.key}", error.sentence, f"{path}.")]
    # A factor makes another quantity of what the heading names, such as a stress of a force.
    other_x, other_y = (
        unit is not None and abs(factor) != 1.0
        for unit, factor in ((section.x_unit, section.x_factor), (section.y_unit, section.y_factor))
    )
    return replace(
        points,
        x_heading=None if other_x else points.x_heading,
        y_heading=None if other_y else points.y_heading,
        x=found.x,
        y=found.y,
        weight=found.weight,
        readings=found.count,
        independent=found.independent,
        range=found.range,
        inputs=found.inputs,
        gross_errors=found.gross_errors,
        notes=(*points.notes, *done),
    ), []


def _loads(points: Points, section: ObservationSection, spec: ForwardModelSpec | None) -> tuple[float, ...]:
    """The x, in the unit of the points, at which the loads of a test in stages are applied."""
    starts = np.empty(0) if spec is None else stage_times(spec, section.series)
    found = None if points.x_heading is None else points.x_heading.unit
    try:
        return tuple(convert(starts, "day", section.x_unit or found or "day").tolist())
    except UnitError:  # refused elsewhere
        return ()


def _length_issues(points: Points, path: str) -> list[Issue]:
    n = len(points.x)
    lists = {"y": points.y, "weight": points.weight, "readings": points.readings}
    lists |= {f"inputs.{name}": v for name, v in points.inputs.items()}
    issues = [
        Issue(f"{path}.{name}", f"has {len(values)} values, but x has {n}; give one for each x")
        for name, values in lists.items()
        if values is not None and len(values) != n
    ]
    issues = issues or _weight_issues(points, f"{path}.weight")
    count = float(n if points.readings is None else sum(points.readings))
    if not issues and points.independent is not None and points.independent > count * (1.0 + 1e-9):  # sums are rounded
        given = number(points.independent)
        message = f"is {given}, but there are {number(count)} readings; at most as many can be independent"
        issues.append(Issue(f"{path}.independent", message))
    return issues


def _weight_issues(points: Points, path: str) -> list[Issue]:
    if points.weight is None:
        return []
    negative = [index for index, weight in enumerate(points.weight) if weight < 0]
    if negative:
        first = negative[0]
        return [Issue(path, f"weight of point {first + 1} is {number(points.weight[first])}; weights are 0 or above")]
    if not any(points.weight):
        return [Issue(path, "all weights are 0; at least one must be above 0")]
    return []


def known_spec(section: Any) -> ForwardModelSpec | None:
    """The forward model, where it is complete; others are judged where it is calculated."""
    try:
        return parse_spec(section)
    except (TypeError, ValueError):
        return None
