"""Series from files of NumPy: ``.npy`` with columns, ``.npz`` with named arrays.

::

    crest: {file: results.npy, x: 1, y: "-column4"}
    toe: {file: results.npz, x: time, y: uy_toe * 1000}
"""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from pathlib import Path
from tokenize import TokenError
from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import Field

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.external.errors import OutputError
from geoswarm.solver.external.outputs.base import OutputReader, Point
from geoswarm.solver.external.outputs.fields import below
from geoswarm.solver.external.outputs.lines import opened
from geoswarm.solver.external.outputs.tables.quantities import ColumnName, Quantity, column_number, column_of

__all__ = ["NumpyReader"]

_UNREADABLE = (
    *(ValueError, TypeError, OSError, EOFError, KeyError, SyntaxError, TokenError, NotImplementedError, Warning),
    *(zipfile.BadZipFile, zlib.error),
)


class NumpyReader(OutputReader):
    """x and y from columns of an array, shape (n, columns) or with named fields, or from arrays by name, each (n,).

    Arrays of Python objects are refused: to load them is to run them. A ``.npy`` file is read in place, not as a whole.
    """

    told_by: ClassVar[str] = "NumPy (a file .npy or .npz, x and y)"

    format: Literal["numpy"] = Field("numpy", description="May be left out for files named .npy or .npz.")
    x: ColumnName = Field(description="Column by number (from 1), array by name, or an expression; row counts from 1.")
    y: ColumnName = Field(description="Column by number (from 1), array by name, or an expression such as -column4.")

    def scan(self, folder: Path) -> Iterator[Point]:
        """Give the points row by row."""
        try:
            with opened(folder, self.file) as stream:
                if stream.read(2) == b"PK":
                    stream.seek(0)
                    archive = np.load(stream, allow_pickle=False)
                    x, y = self._series(dict.fromkeys(archive.files, archive))
                else:
                    array = np.load(below(folder, self.file), mmap_mode="r", allow_pickle=False)
                    x, y = self._series(dict.fromkeys(_names(array), array))
        except _UNREADABLE as error:
            raise OutputError("bad_output", f"{self.file}: cannot be read as NumPy's: {error}") from None
        for row, (one_x, one_y) in enumerate(zip(x.tolist(), y.tolist(), strict=True)):
            yield Point(one_x, one_y, 0, f"row {row + 1}: x = {one_x!r}, y = {one_y!r}")

    def _series(self, sources: dict[str, Any]) -> tuple[FloatArray, FloatArray]:
        header = [*sources, "row"]
        try:
            wanted = [column_of(self.x, header), column_of(self.y, header)]
            columns = {name: self._column(name, sources) for one in wanted for name in one.names if name != "row"}
        except ValueError as error:
            raise OutputError("bad_output", f"{self.file}: {error}") from None
        lengths = {name: len(column) for name, column in columns.items()}
        if len(set(lengths.values())) != 1:
            listed = ", ".join(f"{name} has {length}" for name, length in lengths.items()) or "no array is used"
            raise OutputError("bad_output", f"{self.file}: {listed}; arrays of the same length are expected")
        count = next(iter(lengths.values()))
        columns["row"] = np.arange(1.0, count + 1.0)
        return _value(wanted[0], columns, count), _value(wanted[1], columns, count)

    def _column(self, name: str, sources: dict[str, Any]) -> FloatArray:
        if name not in sources:
            listed = ", ".join(list(sources)[:20]) or "none"
            raise ValueError(f"{name} does not exist; there are {listed}")
        source = sources[name]
        number = column_number(name)
        if isinstance(source, np.ndarray) and source.dtype.names is None:
            column = source if source.ndim == 1 else source[:, (number or 1) - 1]
        else:
            column = source[name]
        if column.ndim != 1 or column.dtype.kind not in "fiu":
            raise ValueError(
                f"{name} has shape {column.shape} and type {column.dtype}; real numbers in one row expected"
            )
        return np.asarray(column, dtype=np.float64)


def _names(array: np.ndarray[Any, Any]) -> list[str]:
    if array.dtype.names is not None:
        return list(array.dtype.names)
    if array.ndim not in (1, 2):
        raise ValueError(f"the array has shape {array.shape}; (rows,) or (rows, columns) is expected")
    return [f"column{at}" for at in range(1, (array.shape[1] if array.ndim == 2 else 1) + 1)]


def _value(wanted: Quantity, columns: dict[str, FloatArray], count: int) -> FloatArray:
    if wanted.expression is None:
        return columns[wanted.names[0]]
    return np.broadcast_to(np.asarray(wanted.expression.value(columns), dtype=np.float64), (count,))
