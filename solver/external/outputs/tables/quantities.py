"""x and y as columns of a table: by number, by name, or as an expression of columns."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated, TypeAlias

from pydantic import AfterValidator, Field

from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import Expression, parse_expression
from geoswarm.solver.words import did_you_mean

__all__ = ["ColumnName", "Quantity", "bound", "column_of", "column_number"]

_COLUMN = re.compile(r"column([1-9]\d{0,5})", re.ASCII)


def _usable(value: int | str) -> int | str:
    if isinstance(value, int):
        if not 1 <= value <= 999_999:
            raise ValueError(f"column {value} does not exist; columns count from 1")
        return value
    if not value.strip():
        raise ValueError("is empty; write the name or number of a column, or an expression such as -column4")
    return value


ColumnName: TypeAlias = Annotated[int | Annotated[str, Field(max_length=1000)], AfterValidator(_usable)]
"""A column in a section: number from 1, name, or expression."""


def column_number(name: str) -> int | None:
    """Return 4 for ``column4``, None for other names."""
    found = _COLUMN.fullmatch(name)
    return int(found[1]) if found else None


@dataclass(frozen=True, slots=True)
class Quantity:
    """What is wanted of each row: one column, or an expression of several. ``names`` are what it uses.

    Parameters
    ----------
    expression
        None for a column alone.
    """

    text: str
    names: tuple[str, ...]
    expression: Expression | None


def column_of(wanted: int | str, header: Sequence[str]) -> Quantity:
    """Find out what is meant by a number, a name or an expression.

    A heading that is the whole text wins, so that ``settlement [mm]`` or ``uy-A`` may be names.

    Parameters
    ----------
    header
        Names of the columns and whatever else has a value in each row.

    Raises
    ------
    ValueError
        A name is none of the header, nor ``columnN``; the message lists what there is.
    """
    if isinstance(wanted, int):
        return Quantity(f"column{wanted}", (f"column{wanted}",), None)
    text = wanted.strip()
    if text in header:
        return Quantity(text, (text,), None)
    if text.isdigit() and text.isascii():
        return column_of(int(text), header)
    try:
        expression = parse_expression(text)
    except ExpressionError as error:
        raise ValueError(f"'{text}' is neither a heading nor an expression: {error}; {_there_are(header)}") from None
    unknown = [name for name in sorted(expression.names) if name not in header and column_number(name) is None]
    if unknown:
        raise ValueError(f"no column {unknown[0]}{did_you_mean(unknown[0], header)}; {_there_are(header)}")
    if not expression.names:
        raise ValueError(f"'{text}' uses no column; write the name or number of a column, or -column4")
    names = tuple(sorted(expression.names))
    return Quantity(text, names, None if expression.text in expression.names else expression)


def _there_are(header: Sequence[str]) -> str:
    return (
        f"there are {', '.join(list(header)[:20])}" if header else "columns without headings are column1, column2, ..."
    )


def bound(quantity: Quantity) -> Callable[[Mapping[str, float]], float]:
    """Return the function from the values of a row, by name, to the quantity."""
    expression = quantity.expression
    if expression is None:
        (name,) = quantity.names
        return lambda values: values[name]
    return lambda values: float(expression.value(values))
