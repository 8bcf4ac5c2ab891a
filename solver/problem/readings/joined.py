"""Several blocks of a file as one table: the stages of a test, side by side or each on a sheet of its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from pydantic import Field

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem.issues import number
from geoswarm.solver.problem.readings.zero import ZeroReading, zero_reading
from geoswarm.solver.problem.tables.columns import Table
from geoswarm.solver.problem.tables.headings import Heading, unclear_unit
from geoswarm.solver.section import Section
from geoswarm.solver.sentences import Key, plain, setting
from geoswarm.solver.units import UnitError, convert

__all__ = ["BlockError", "BlockSection", "joined"]

_ROUNDING = 1e-9
_UNKNOWN = "no unit"  # no other unit has its dimension


class BlockSection(Section):
    """A block of a file: what differs from the keys of the observation."""

    sheet: str | None = Field(None, min_length=1, description="sheet of a workbook; that of the observation if absent")
    x_column: str | None = Field(None, min_length=1, description="column of x; that of the observation if absent")
    y_column: str | None = Field(None, min_length=1, description="column of y; that of the observation if absent")
    where: dict[str, str | float] | None = Field(
        None, min_length=1, max_length=10, description="only rows with these entries, beside those of the observation"
    )
    stage: int | None = Field(
        None,
        ge=1,
        description="number of the stage, from 1, since whose load x counts; if absent, x is that of the test",
    )
    y_zero: Literal["first"] | ZeroReading | None = Field(
        None, description="the zero reading of this block, as that of the observation; x is that of the block"
    )
    y_adds: bool = Field(False, description="y counts from the last reading of the block before, which is added")


class BlockError(Exception):
    """Blocks cannot be joined; ``place`` is that of the block, ``key`` its key."""

    def __init__(self, place: int, key: str, *message: str | Key) -> None:
        super().__init__(plain(message))
        self.place, self.key, self.sentence = place, key, message


@dataclass(frozen=True, slots=True)
class _Axis:
    """Values of the blocks along x or y, in ``unit``: that of all headings, or None."""

    values: list[FloatArray]
    unit: str | None


def joined(
    blocks: Sequence[BlockSection],
    tables: Sequence[Table],
    units: tuple[str | None, str | None],
    starts: FloatArray,
) -> tuple[Table, str]:
    """One table of all blocks, and what was done, in words.

    Parameters
    ----------
    tables
        Of the blocks, each as it was read.
    units
        Of x and y, where the observation gives them.
    starts
        Times [day] at which the loads of the stages are applied; empty where x is no time of a test in stages.

    Raises
    ------
    BlockError
        Blocks do not fit each other or the stages.
    """
    x = _axis("x", [table.x for table in tables], [table.x_heading for table in tables], units[0])
    y = _axis("y", [table.y for table in tables], [table.y_heading for table in tables], units[1])
    for role in tables[0].input_headings:
        headings = [table.input_headings[role] for table in tables]
        if len({heading.unit for heading in headings}) > 1:
            raise BlockError(0, "x_column", f"the columns of input {role} have several units; give them one")
    if len({table.weight is None for table in tables}) > 1:
        raise BlockError(0, "x_column", "some blocks have a column weight and others none; all or none have one")
    parts: list[Table] = []
    for place, (block, table) in enumerate(zip(blocks, tables, strict=True)):
        own = replace(table, x=x.values[place].tolist(), y=_zeroed(place, block, table, x, y, parts).tolist())
        if block.stage is not None:
            own = replace(own, x=_since_start(place, block.stage, x, starts).tolist())
        elif own.zero is not None and tables[0].zero is not None:
            days = (own.zero - tables[0].zero).total_seconds() / 86400
            own = replace(own, x=[value + days for value in own.x])
        parts.append(_without_repeated(parts[-1], own) if parts else own)
    return _together(parts), _in_words(blocks)


def _axis(name: str, values: Sequence[list[float]], headings: Sequence[Heading], given: str | None) -> _Axis:
    """Values of all blocks in the unit of the first, where the headings name it."""
    first = headings[0]
    found = [np.array(values[0], dtype=np.float64)]
    for place, (heading, own) in enumerate(zip(headings[1:], values[1:], strict=True), 1):
        array = np.array(own, dtype=np.float64)
        fixed = first.dates or heading.dates or first.in_cells or heading.in_cells
        if (given is None or fixed) and _unit(heading) != _unit(first):
            own_unit, unit = _unit(heading), _unit(first)
            try:
                array = convert(array, own_unit or _UNKNOWN, unit or _UNKNOWN)
            except UnitError:
                told = f"'{heading.name}' is in {own_unit or 'no known unit'}, '{first.name}' of block 1 in"
                told += f" {unit or 'no known unit'}; "
                remedy = setting(f"{name}_unit"), " says what all of them are in"
                raise BlockError(place, f"{name}_column", told, *remedy) from None
        found.append(array)
    return _Axis(found, given or _unit(first))


def _unit(heading: Heading) -> str | None:
    return None if unclear_unit(heading.named) else heading.unit


def _zeroed(place: int, block: BlockSection, table: Table, x: _Axis, y: _Axis, before: Sequence[Table]) -> FloatArray:
    """y of a block less its zero reading, plus the last reading of the block before."""
    values = y.values[place]
    counted = np.ones(len(values), dtype=np.bool_)
    counted[table.gross_errors] = False
    if block.y_zero is not None:
        if not counted.any():
            raise BlockError(place, "y_zero", "all readings of the block are gross errors")
        zero, told = zero_reading(block.y_zero, x.values[place], values, counted)
        if zero is None:
            raise BlockError(place, "y_zero", told)
        values = values - zero
    if block.y_adds:
        sure = [i for i in range(len(before[-1].y)) if i not in before[-1].gross_errors] if before else []
        if not sure:
            raise BlockError(place, "y_adds", "there is no block before with a reading from which y could count")
        values = values + before[-1].y[sure[-1]]
    return values


def _since_start(place: int, stage: int, x: _Axis, starts: FloatArray) -> FloatArray:
    """x of a block as a time of the test: the start of its stage is added."""
    if not starts.size:
        raise BlockError(
            place, "stage", "needs a series over the time of a test in stages, and its complete forward model"
        )
    if stage > starts.size:
        raise BlockError(place, "stage", f"there is no stage {stage}; the forward model has {starts.size}")
    if x.unit is None:
        what = "has no unit, in which the start of the stage is added; give "
        raise BlockError(place, "x_column", what, setting("x_unit"))
    try:
        times = np.asarray(convert(starts, "day", x.unit), dtype=np.float64)
    except UnitError as error:
        raise BlockError(place, "stage", str(error)) from None
    since = x.values[place]
    slack = _ROUNDING * float(np.abs(times).max(initial=1.0))
    length = float(times[stage] - times[stage - 1]) if stage < times.size else np.inf
    beyond = (since < -slack) | (since > length + slack)
    if beyond.any():
        what = f"x = {number(float(since[np.argmax(beyond)]))} {x.unit} is not in stage {stage}, which lasts"
        remedy = "x of a block with stage counts from the load of that stage"
        raise BlockError(place, "stage", f"{what} {number(length)} {x.unit}; {remedy}")
    return np.asarray(since + times[stage - 1], dtype=np.float64)


def _without_repeated(before: Table, table: Table) -> Table:
    """A block without its first reading where that is the last of the block before once more."""
    slack = _ROUNDING * max(abs(before.x[-1]), 1.0)
    if abs(table.x[0] - before.x[-1]) > slack or table.y[0] != before.y[-1] or len(table.x) < 2:
        return table
    return replace(
        table,
        x=table.x[1:],
        y=table.y[1:],
        weight=None if table.weight is None else table.weight[1:],
        inputs={name: values[1:] for name, values in table.inputs.items()},
        gross_errors=[i - 1 for i in table.gross_errors if i],
    )


def _together(parts: Sequence[Table]) -> Table:
    lengths = np.cumsum([0, *(len(part.x) for part in parts)]).tolist()
    weights = [part.weight for part in parts if part.weight is not None]
    return replace(
        parts[0],
        x=[value for part in parts for value in part.x],
        y=[value for part in parts for value in part.y],
        weight=[value for own in weights for value in own] if weights else None,
        inputs={name: [value for part in parts for value in part.inputs[name]] for name in parts[0].inputs},
        gross_errors=[before + i for before, part in zip(lengths, parts, strict=False) for i in part.gross_errors],
        left_out=sum(part.left_out for part in parts),
    )


def _in_words(blocks: Sequence[BlockSection]) -> str:
    told = ["1 block was read" if len(blocks) == 1 else f"{len(blocks)} blocks were joined"]
    if blocks[0].stage is not None:
        told.append("x of each from the start of its stage")
    if any(block.y_zero is not None for block in blocks):
        told.append("less the zero readings of the blocks")
    if any(block.y_adds for block in blocks):
        told.append("y from the last reading of the block before")
    return ", ".join(told)
