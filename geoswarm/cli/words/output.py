"""Numbers, tables and JSON as the user reads them: results on stdout, everything else on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from datetime import datetime
from typing import TYPE_CHECKING, Any

import click

from geoswarm.solver import words

if TYPE_CHECKING:
    from rich.console import Console

    from geoswarm.solver.problem import Problem
    from geoswarm.solver.problem.weighting import SeriesShare

__all__ = [
    "duration",
    "echo_facts",
    "echo_json",
    "echo_table",
    "ends",
    "note",
    "number",
    "parameter_rows",
    "progress_console",
    "reasons_in_words",
    "record_json",
    "root_mean_square",
    "symbol_and_unit",
    "with_unit",
]

_PIPED_WIDTH = 120


def number(value: float | None, digits: int = 4) -> str:
    """Return a number with the given significant digits; ``-`` for None."""
    return words.number(value, digits, plain=True)


def ends(low: float, high: float) -> tuple[str, str]:
    """Return the ends of an interval with four significant digits, or as many more as its width needs."""
    return words.ends(low, high, digits=4, plain=True)


def duration(seconds: float | None) -> str:
    """Return a time span [s] in words: ``0.8 s``, ``2 min 05 s``, ``3 h 02 min``; ``-`` for None."""
    return words.duration(seconds, plain=True)


def reasons_in_words(stop_reasons: Sequence[str]) -> str:
    """Return stop reasons as a phrase; ``-`` when there are none."""
    return words.reasons_in_words(stop_reasons, plain=True)


def record_json(record: Any) -> Any:
    """Return a record of the client as JSON values; times in ISO 8601."""
    return _plain(asdict(record))


def _plain(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(item) for item in value]
    return value.isoformat().replace("+00:00", "Z") if isinstance(value, datetime) else value


def echo_json(data: Any) -> None:
    """Write JSON to stdout; a value that JSON lacks (NaN) is an error, never written."""
    click.echo(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))


def note(message: str) -> None:
    """Write a remark to stderr."""
    click.echo(words.visible(message, lines=True), err=True)


def echo_table(
    title: str | None, columns: Sequence[str], rows: Sequence[Sequence[str]], *, right: Sequence[int] = ()
) -> None:
    """Write a table to stdout.

    Parameters
    ----------
    title
        Line above the table, or None.
    columns, rows
        Headings and cells.
    right
        Indices of the columns to align to the right.
    """
    from rich import box
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    terminal = sys.stdout.isatty()
    console = Console(file=sys.stdout, width=None if terminal else _PIPED_WIDTH, highlight=False)
    table = Table(
        title=None if title is None else Text(title),
        title_justify="left",
        title_style="bold",
        header_style="bold",
        box=box.SIMPLE_HEAD,
        pad_edge=False,
    )
    for index, column in enumerate(columns):
        table.add_column(column, justify="right" if index in right else "left", overflow="fold")
    for row in rows:
        table.add_row(*(Text(words.visible(cell, lines=True)) for cell in row))
    console.print(table)


def echo_facts(title: str | None, facts: Mapping[str, str]) -> None:
    """Write names and values, one a line, values aligned."""
    if title is not None:
        click.secho(words.visible(title), bold=True)
    width = max((len(name) for name in facts), default=0)
    for name, value in facts.items():
        click.echo(f"  {name:<{width}}  {words.visible(value, lines=True)}")


def progress_console() -> Console:
    """Return the console of progress bars: stderr."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


def with_unit(text: str, unit: str) -> str:
    """Append a unit to a number; nothing for a pure number."""
    return f"{text} {unit}" if unit and unit not in ("dimensionless", "1", "-") and text != "-" else text


def root_mean_square(share: SeriesShare) -> str:
    """Write the root mean square of a series' residuals in the unit of its data."""
    return with_unit(number(share.root_mean_square, 3), share.unit)


def symbol_and_unit(problem: Problem, name: str) -> tuple[str, str]:
    """Return symbol and unit of a parameter; the symbol is empty when it says no more than the name."""
    for info in problem.model.parameters:
        if info.name == name:
            unit = "" if info.unit in ("dimensionless", "1") else info.unit
            return ("" if info.symbol == name else info.symbol), unit
    return "", ""


def parameter_rows(problem: Problem, values: Mapping[str, float]) -> list[tuple[str, str, str, str]]:
    """Return name, symbol, value and unit of every parameter of the problem."""
    rows = []
    for name in problem.parameters:
        symbol, unit = symbol_and_unit(problem, name)
        rows.append((name, symbol, number(values[name], 5), unit))
    return rows
