"""The history of a calibration as columns."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.system.extras import has, needs_extra

if TYPE_CHECKING:
    import pandas

__all__ = ["Runs"]

_TEXT = ("state", "reason", "message")
_WHOLE = ("generation", "particle")


class Runs(Mapping[str, npt.NDArray[Any]]):
    """Every evaluation, in the order of generation and particle: columns by name, each of shape (n,).

    ``generation``, ``particle``, ``state``, ``objective``, the free parameters, ``misfit.SERIES``, ``reason`` and
    ``message`` of a failure, ``seconds``: those of ``evaluations.csv`` (``geoswarm run --output``). A parameter with
    the name of another column is ``parameter.NAME``. Missing numbers of failed evaluations are nan, missing texts are
    empty. The arrays are read-only; change a ``copy()``.

    Examples
    --------
    >>> import geoswarm as gs
    >>> def line(x, a, b):
    ...     return a + b * x
    >>> result = gs.calibrate(
    ...     line,
    ...     parameters={"a": gs.free(0, 10), "b": gs.free(0, 10)},
    ...     observations=gs.observed([0, 1, 2, 3], [1.1, 2.9, 5.1, 6.9], error=0.1),
    ...     stopping={"max_evaluations": 100},
    ...     seed=1,
    ... )
    >>> runs = result.runs
    >>> good = runs["objective"] < 0.1
    >>> bool(good.any()), runs["a"].shape == (runs.size,), runs.responses["y"].shape == (runs.size, 4)
    (True, True, True)
    """

    def __init__(self, problem: Problem, result: CalibrationResult) -> None:
        self._problem = problem
        self._history = result.history

    @cached_property
    def _columns(self) -> dict[str, npt.NDArray[Any]]:
        from geoswarm.solver.report.folder.tables import evaluation_header, evaluation_row

        header = evaluation_header(self._problem)
        rows = [evaluation_row(self._problem, r.generation, r.particle, r.evaluation) for r in self._history]
        values = zip(*rows, strict=True) if rows else ([] for _ in header)
        return {name: _fixed(_column(name, list(column))) for name, column in zip(header, values, strict=True)}

    @cached_property
    def responses(self) -> dict[str, FloatArray]:
        """Calculated values by series, shape (n, m_g), base units; nan where an evaluation failed."""
        return {
            o.series: _fixed(
                np.array(
                    [r.evaluation.responses.get(o.series, np.full(o.x.size, np.nan)) for r in self._history],
                    dtype=np.float64,
                ).reshape(-1, o.x.size)
            )
            for o in self._problem.observations
        }

    @property
    def size(self) -> int:
        """Number of evaluations n."""
        return len(self._history)

    def __getitem__(self, name: str) -> npt.NDArray[Any]:
        try:
            return self._columns[name]
        except KeyError:
            raise KeyError(f"{name}: the columns are {', '.join(self._columns)}") from None

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __len__(self) -> int:
        return len(self._columns)

    def __repr__(self) -> str:
        return f"<Runs: {self.size} evaluations; columns {', '.join(self._columns)}>"

    def to_dataframe(self) -> pandas.DataFrame:
        """Return the columns as a data frame.

        Raises
        ------
        ImportError
            pandas is not installed.
        """
        if not has("pandas"):
            raise ImportError(needs_extra("to_dataframe()", "pandas"))
        import pandas

        return pandas.DataFrame(self._columns)


def _fixed(array: npt.NDArray[Any]) -> npt.NDArray[Any]:
    """A read-only array: all callers share it."""
    array.flags.writeable = False
    return array


def _column(name: str, values: list[Any]) -> npt.NDArray[Any]:
    if name in _TEXT:
        return np.array([value or "" for value in values], dtype=object)
    if name in _WHOLE:
        return np.array(values, dtype=np.int64)
    return np.array([np.nan if value is None else value for value in values], dtype=np.float64)
