"""Common parts of forward models that we did not write: only their declared series are known."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping
from typing import Protocol, TypeVar

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.forward.base import ForwardRun, ParameterInfo, SeriesInfo
from geoswarm.solver.units import UnitError, base_unit

__all__ = ["ForeignModel", "series_in_base_units"]


class _InUnits(Protocol):
    """Section of a series."""

    @property
    def x_unit(self) -> str: ...

    @property
    def y_unit(self) -> str: ...


Section = TypeVar("Section", bound=_InUnits)


class ForeignModel(ABC):
    """A forward model that is known by its parameters and series alone.

    Parameters
    ----------
    parameters, series
        In the order in which they are shown.
    """

    def __init__(self, parameters: Iterable[ParameterInfo], series: Iterable[SeriesInfo]) -> None:
        self._parameters = {info.name: info for info in parameters}
        self._series = tuple(series)

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Those that it takes."""
        return tuple(self._parameters.values())

    @property
    def open_parameters(self) -> bool:
        """False: a problem has those of :attr:`parameters`."""
        return False

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Series in the order of the section."""
        return self._series

    def grid(self, series: str) -> FloatArray:
        """No points, shape (0,): a curve has those that were observed."""
        del series
        return np.empty(0)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """Nothing is inadmissible; only a run can show it."""
        del parameters
        return None

    @abstractmethod
    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of series at x, each of shape (m_g,), base units; nothing is started or read yet."""


def series_in_base_units(
    sections: Mapping[str, Section], described: Callable[[Section], str]
) -> tuple[SeriesInfo, ...]:
    """Return the series of some sections, which name the units of x and y.

    Parameters
    ----------
    described
        Gives the description of a series.

    Raises
    ------
    ProblemError
        Units are unknown; each issue has the path of one, such as ``forward_model.series.crest.x_unit``.
    """
    found, issues = [], list[Issue]()
    for name, section in sections.items():
        bases = []
        for axis, unit in (("x_unit", section.x_unit), ("y_unit", section.y_unit)):
            try:
                bases.append(_base(unit))
            except UnitError as error:
                issues.append(Issue(f"forward_model.series.{name}.{axis}", str(error)))
        if len(bases) == 2:
            x_unit, y_unit = bases
            found.append(SeriesInfo(name, described(section), "x", x_unit, name, y_unit, x_increasing=False))
    if issues:
        raise ProblemError(issues)
    return tuple(found)


def _base(unit: str) -> str:
    """The base unit as series tell it: empty for plain numbers."""
    found = base_unit(unit)
    return "" if found == "dimensionless" else found
