"""Symbols, units and scales of parameters, for axes and tables."""

from __future__ import annotations

from dataclasses import dataclass

from geoswarm.solver.problem import Problem

__all__ = ["ParameterLabel", "parameter_labels"]


@dataclass(frozen=True, slots=True)
class ParameterLabel:
    """How a parameter is written.

    Parameters
    ----------
    name
        As in the problem file.
    symbol
        As in equations; the name where there is no symbol.
    unit
        Base unit, ``-`` for a pure number.
    """

    name: str
    symbol: str
    unit: str

    @property
    def axis(self) -> str:
        """Symbol and unit."""
        return f"{self.symbol} [{self.unit}]"


def parameter_labels(problem: Problem) -> dict[str, ParameterLabel]:
    """Return the label of every parameter of a problem by name.

    Two parameters with one symbol (those of two tests calibrated at once) are distinguished by their names.
    """
    infos = {info.name: info for info in problem.model.parameters}
    symbols = [infos[name].symbol for name in problem.parameters if name in infos]
    labels = {}
    for name in problem.parameters:
        info = infos.get(name)
        symbol = name if info is None or not info.symbol or symbols.count(info.symbol) > 1 else info.symbol
        unit = "-" if info is None or info.unit in ("", "1", "dimensionless") else info.unit
        unit = "°" if unit == "degree" else unit
        labels[name] = ParameterLabel(name, symbol, unit)
    return labels
