"""Numbers, tables and JSON as the user reads them: results on stdout, everything else on stderr."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console

__all__ = [
    "duration",
    "echo_facts",
    "echo_json",
    "echo_table",
    "note",
    "number",
    "progress_console",
    "reasons_in_words",
]

_PIPED_WIDTH = 120

_REASONS = {
    "max_evaluations": "maximum number of evaluations reached",
    "max_seconds": "maximum time reached",
    "target_objective": "objective at or below the target",
    "stagnation_generations": "objective no longer lowered",
    "samples_completed": "all samples evaluated",
    "polished": "best parameters polished",
}


def number(value: float | None, digits: int = 4) -> str:
    """Return a number with the given significant digits; ``-`` for None."""
    if value is None:
        return "-"
    if isinstance(value, int):
        return str(value)
    text = f"{value:.{digits}g}"
    mantissa, exponent, power = text.partition("e")
    if exponent and 0 <= int(power) < 7:
        return f"{float(text):.0f}"
    return f"{mantissa}e{int(power)}" if exponent else text


def duration(seconds: float | None) -> str:
    """Return a time span [s] in words: ``0.8 s``, ``2 min 05 s``, ``3 h 02 min``; ``-`` for None."""
    if seconds is None:
        return "-"
    if seconds < 0.1:
        return f"{seconds * 1000.0:.3g} ms"
    if seconds < 59.95:
        return f"{seconds:.1f} s"
    minutes, rest = divmod(round(seconds), 60)
    if minutes < 60:
        return f"{minutes} min {rest:02d} s"
    hours, minutes = divmod(minutes, 60)
    return f"{hours} h {minutes:02d} min"


def reasons_in_words(stop_reasons: Sequence[str]) -> str:
    """Return stop reasons as a phrase; ``-`` when there are none."""
    return ", ".join(_REASONS.get(reason, reason) for reason in stop_reasons) or "-"


def echo_json(data: Any) -> None:
    """Write JSON to stdout; a value that JSON lacks (NaN) is an error, never written."""
    click.echo(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False))


def note(message: str) -> None:
    """Write a remark to stderr."""
    click.echo(message, err=True)


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
        table.add_row(*(Text(cell) for cell in row))
    console.print(table)


def echo_facts(title: str | None, facts: Mapping[str, str]) -> None:
    """Write names and values, one a line, values aligned."""
    if title is not None:
        click.secho(title, bold=True)
    width = max((len(name) for name in facts), default=0)
    for name, value in facts.items():
        click.echo(f"  {name:<{width}}  {value}")


def progress_console() -> Console:
    """Return the console of progress bars: stderr."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)
