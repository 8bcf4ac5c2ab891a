"""Names, symbols and units of parameters and series in tables."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from geoswarm.cli.words.output import number

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.problem.weighting import SeriesShare

__all__ = ["parameter_rows", "root_mean_square", "symbol_and_unit", "with_unit"]


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
