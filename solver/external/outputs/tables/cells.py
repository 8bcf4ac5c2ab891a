"""Cells of a line: separated by signs or blanks, or in fixed columns."""

from __future__ import annotations

import csv
from collections.abc import Callable, Sequence
from typing import Literal, TypeAlias

__all__ = ["Separator", "cell_splitter", "guessed_separator"]

Separator: TypeAlias = Literal["auto", ",", ";", "tab", "blanks"]
"""What stands between cells; ``auto`` decides by the first row of numbers."""

_SIGNS = {",": ",", ";": ";", "tab": "\t"}


def guessed_separator(line: str, decimal: str) -> Separator:
    """Return the separator that a line seems to have: semicolon, tab, comma, else blanks."""
    if ";" in line:
        return ";"
    if "\t" in line.strip():
        return "tab"
    return "," if "," in line and decimal != "," else "blanks"


def cell_splitter(separator: Separator, fixed: Sequence[tuple[int, int]] | None) -> Callable[[str], list[str]]:
    """Return the function from a line to its cells, without blanks around them.

    Parameters
    ----------
    separator
        Not ``auto``.
    fixed
        First and last character of each column, from 1; None when cells are separated.
    """
    if fixed is not None:
        return lambda line: [line[first - 1 : last].strip() for first, last in fixed]
    if separator == "blanks":
        return lambda line: _quoted(line.strip(), " ") if '"' in line else line.split()
    sign = _SIGNS[separator]
    return lambda line: _quoted(line, sign) if '"' in line else [cell.strip() for cell in line.split(sign)]


def _quoted(line: str, sign: str) -> list[str]:
    try:
        (cells,) = csv.reader([line], delimiter=sign, skipinitialspace=True)
    except (csv.Error, ValueError):  # a cell larger than csv admits
        cells = line.split(sign)
    return [cell.strip() for cell in cells if cell.strip() or sign != " "]
