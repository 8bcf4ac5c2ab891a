"""Points from tables that a listing repeats, each under a heading that matches a regular expression."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field

from geoswarm.solver.external.outputs.base import Point
from geoswarm.solver.external.outputs.numbers import number_of, reason_of
from geoswarm.solver.external.outputs.tables.rows import Chosen, TableShape, has_number, split_row

__all__ = ["block_points"]


@dataclass(slots=True)
class _Block:
    """Where a heading stands, the values of its groups, and what was read below it."""

    line: int
    text: str
    given: dict[str, float]
    lines: int = 0
    found: int = 0
    rows: int = 0
    done: bool = field(default=False)


def block_points(
    lines: Iterable[tuple[int, str]], shape: TableShape, heading: re.Pattern[str], row: int | None
) -> Iterator[Point]:
    """Give the points of all blocks.

    With ``row`` a block gives that row alone, counted over the lines after the heading that are neither blank nor
    comments. Otherwise it gives all rows of numbers, or those that ``where`` takes, from the first one to the next
    blank line, line without numbers, or heading.

    Parameters
    ----------
    heading
        Named groups become names beside ``columnN``, ``row`` (in the block) and ``block``, both from 1.

    Raises
    ------
    OutputError
        There is no heading, a block has no such row, or a number cannot be read.
    """
    chosen = Chosen(shape, (), (*heading.groupindex, "row", "block"), 0)
    block: _Block | None = None
    blocks = points = last = 0
    for number, line in lines:
        last = number
        if (match := heading.search(line)) is not None:
            _finish(shape, block, row)
            blocks += 1
            block = _Block(number, line.strip(), _groups(shape, match, number) | {"block": float(blocks)})
            continue
        if block is None or block.done:
            continue
        if shape.is_comment(line):
            block.done = block.rows > 0 and row is None and not line.strip()
            continue
        point = _wanted_row(shape, chosen, block, row, number, line)
        if point is not None:
            yield point
            points += 1
            if points == shape.rows:
                return
    _finish(shape, block, row)
    if block is None:
        raise shape.wrong(last, f"the file ends, but no line matches each: {heading.pattern[:100]}")
    if shape.rows is not None:
        raise shape.wrong(last, f"the file ends after {points} points; {shape.rows} expected")


def _wanted_row(
    shape: TableShape, chosen: Chosen, block: _Block, row: int | None, number: int, line: str
) -> Point | None:
    block.lines += 1
    cells = split_row(shape, line)(line)
    if row is not None:
        if block.lines < row:
            return None
        block.done = True
    elif not has_number(cells):
        block.done = block.rows > 0
        return None
    block.rows += 1
    given = block.given | {"row": float(block.lines if row is not None else block.rows)}
    if not chosen.may_count(cells) or not chosen.counts(cells, given, number):
        return None
    block.found += 1
    return chosen.point(cells, given, number, line)


def _groups(shape: TableShape, match: re.Match[str], number: int) -> dict[str, float]:
    values = {}
    for name in match.re.groupindex:
        text = match[name]
        try:
            values[name] = number_of(text or "", shape.decimal)
        except ValueError as error:
            if name in (shape.x, shape.y):
                raise shape.wrong(number, f"group {name} of the heading: {error}", reason_of(error)) from None
            values[name] = float("nan")  # a group that only helps to find the heading
    return values


def _finish(shape: TableShape, block: _Block | None, row: int | None) -> None:
    if block is None or block.found:
        return
    if row is not None:
        message = f"the heading '{block.text[:80]}' has {block.lines} rows below it; row {row} expected"
    elif shape.where is not None:
        message = f"no row below the heading '{block.text[:80]}' fulfils where: {shape.where}"
    else:
        message = f"there is no row of numbers below the heading '{block.text[:80]}'"
    raise shape.wrong(block.line, message)
