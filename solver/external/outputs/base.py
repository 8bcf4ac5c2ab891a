"""What all readers of series have in common."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from array import array
from collections.abc import Iterator
from pathlib import Path
from typing import Any, ClassVar, NamedTuple

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.external.errors import OutputError, place
from geoswarm.solver.external.outputs.fields import RelativePath
from geoswarm.solver.words import did_you_mean

__all__ = ["FROM_LIST", "OutputReader", "Point", "ScaledReader"]


def _tuple_of_list(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


FROM_LIST = BeforeValidator(_tuple_of_list)
"""For tuples in sections: the look at the keys makes lists of JSON's arrays, which strict validation would refuse."""

_LONGEST_TRACE = 200


class Point(NamedTuple):
    """One point of a series in the units of the file, its line (0: there are none), and what stands there."""

    x: float
    y: float
    line: int
    text: str


class OutputReader(BaseModel, ABC):
    """How one series is read from what a run wrote: a section of ``series``."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    told_by: ClassVar[str] = ""
    """In words: what sort of reader this is, and which fields tell it from others."""

    file: RelativePath = Field(description="File in the folder of the run, such as results.csv.")
    x_unit: str = Field("dimensionless", max_length=50, description="Unit of x in the file.")
    y_unit: str = Field("dimensionless", max_length=50, description="Unit of y in the file.")

    @model_validator(mode="before")
    @classmethod
    def _known_keys(cls, section: Any) -> Any:
        if isinstance(section, dict):
            fields = [field.alias or name for name, field in cls.model_fields.items()]
            for key in section:
                if key not in fields:
                    hint = did_you_mean(str(key), fields)
                    raise ValueError(f"unknown key {key}{hint}; {cls.told_by} takes {', '.join(fields)}")
        return section

    @property
    def files(self) -> tuple[str, ...]:
        """The files that a run must have written."""
        return (self.file,)

    @property
    def sources(self) -> tuple[str, ...]:
        """Files next to the problem file that say how to read."""
        return ()

    def with_sources(self, folder: Path) -> OutputReader:
        """Return the same reader with the contents of its :attr:`sources` instead of their names.

        Parameters
        ----------
        folder
            Where the sources lie.

        Raises
        ------
        TemplateError
            A source cannot be read or understood.
        """
        del folder
        return self

    @property
    def lacks(self) -> str | None:
        """What is not installed here and needed to read, in words; None when nothing is missing."""
        return None

    @abstractmethod
    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the points in the order of the file; raises :class:`OutputError`."""

    def read(self, folder: Path) -> tuple[FloatArray, FloatArray]:
        """Read the series.

        Returns
        -------
        x and y, each of shape (n,), n at least 1, all finite, in the file's units and order.

        Raises
        ------
        OutputError
            ``no_output``: a file is missing or empty. ``bad_output``: it cannot be read as the section says.
            ``not_finite``: a number in it is NaN or infinite.
        """
        x, y = array("d"), array("d")
        for point in self.scan(folder):
            if not (math.isfinite(point.x) and math.isfinite(point.y)):
                raise self._not_finite(point)
            x.append(point.x)
            y.append(point.y)
        if not x:
            raise OutputError("bad_output", f"{self.file}: no point was found; at least one is expected")
        return np.array(x, dtype=np.float64), np.array(y, dtype=np.float64)

    def traced(self, folder: Path) -> list[tuple[int, str]]:
        """Number and text of the line of each point of :meth:`read`; 0 if a file has no lines.

        Raises
        ------
        OutputError
            As :meth:`read`.
        """
        return [(point.line, point.text[:_LONGEST_TRACE]) for point in self.scan(folder)]

    def _not_finite(self, point: Point) -> OutputError:
        what = f"x = {point.x}" if not math.isfinite(point.x) else f"y = {point.y}"
        where = place(self.file, point.line or None)
        return OutputError("not_finite", f"{where}: {what} is not finite in '{point.text[:80]}'")


class ScaledReader(OutputReader, ABC):
    """A reader whose y may be multiplied, for formats that have no expressions."""

    y_factor: float = Field(1.0, description="Factor for y: -1 changes the sign, 1000 converts m to mm.")
