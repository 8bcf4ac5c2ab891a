"""The forward model that a Python function is: one call of it for each evaluation."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Collection, Mapping
from contextlib import nullcontext
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.python.answers import Wanted, responses_of
from geoswarm.solver.external.python.failures import failure_of
from geoswarm.solver.external.python.loading import folder_importable, function_of_session, load_function
from geoswarm.solver.external.python.signature import POINTS, Signature
from geoswarm.solver.forward.base import ForwardRun, ParameterInfo
from geoswarm.solver.forward.programs.foreign import ForeignModel, series_in_base_units

if TYPE_CHECKING:
    from geoswarm.solver.forward.programs.python_function import PythonSpec

__all__ = ["PythonModel"]


class PythonModel(ForeignModel):
    """A Python function as a forward model.

    Its parameters are the arguments, but x and those whose default is not a number.

    Parameters
    ----------
    spec
        Its section, with its signature.

    Raises
    ------
    ProblemError
        The unit of a series is unknown.
    """

    def __init__(self, spec: PythonSpec) -> None:
        self._spec = spec
        self._signature = spec.signature or Signature()
        arguments = (
            ParameterInfo(name, name, "", f"Argument of {spec.function}.", default)
            for name, default in self._signature.parameters.items()
        )
        returned = f"Returned by {spec.function}."
        super().__init__(arguments, series_in_base_units(spec.series, lambda section: section.description or returned))

    @property
    def open_parameters(self) -> bool:
        """Whether the function takes ``**kwargs``."""
        return self._signature.open

    def incomplete(self, declared: Collection[str]) -> str | None:
        """Name the argument for the observed points, if another one may be meant for them."""
        needed = {name for name, default in self._signature.parameters.items() if default is None}
        if self._signature.points or needed <= set(declared):
            return None
        return f"if {self._spec.function} needs the observed points, name their argument x"

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of series at x, each of shape (m_g,), base units; nothing is imported yet."""
        wanted = {
            name: Wanted(np.array(x, dtype=np.float64), self._spec.series[name].x_unit, self._spec.series[name].y_unit)
            for name, x in points.items()
        }
        return _Calls(self._spec, self._signature, wanted)


class _Calls:
    """Calls the function."""

    def __init__(self, spec: PythonSpec, signature: Signature, wanted: Mapping[str, Wanted]) -> None:
        self._spec = spec
        self._signature = signature
        self._wanted = wanted
        self._x = {name: one.own_x for name, one in wanted.items()} if signature.points else {}
        self._folder = None if spec.folder is None or spec.session else Path(spec.folder)
        self._function: Callable[..., Any] | None = None

    def make_ready(self) -> None:
        """Import the file before the first evaluation; errors are reported by that evaluation."""
        try:
            self._found()
        except RunFailedError:
            return

    def __call__(self, parameters: Mapping[str, float]) -> dict[str, FloatArray]:
        """Return the responses; raises ForwardError."""
        function = self._found()
        signature = self._signature
        given: dict[str, Any] = {
            name: value for name, value in parameters.items() if signature.open or name in signature.parameters
        }
        if signature.points:
            x = {name: x.copy() for name, x in self._x.items()}
            given[POINTS] = next(iter(x.values())) if len(self._spec.series) == 1 else x
        called = self._spec.function
        try:
            with nullcontext() if self._folder is None else folder_importable(self._folder):
                returned = function(**given)
        except (MemoryError, KeyboardInterrupt):
            raise
        except (Exception, SystemExit) as error:  # noqa: BLE001  anybody's function: its bug is one failed evaluation
            raise failure_of(error, self._file(function), called, self._hint(error)) from None
        return responses_of(returned, self._wanted, self._spec.series, called)

    def _found(self) -> Callable[..., Any]:
        if self._function is None:
            spec = self._spec
            if spec.session is not None:
                self._function = function_of_session(spec.session, spec.function)
            else:
                self._function = load_function(
                    Path(spec.folder or "."), spec.file or "", spec.version or "", spec.function
                )
        return self._function

    def _file(self, function: Callable[..., Any]) -> str:
        """The file of the function, as its code names it."""
        if self._folder is not None:
            return str((self._folder / (self._spec.file or "")).resolve())
        plain = inspect.unwrap(getattr(function, "func", function))  # of a partial
        code = getattr(plain, "__code__", None) or getattr(vars(type(plain)).get("__call__"), "__code__", None)
        return "" if code is None else str(code.co_filename)

    def _hint(self, error: BaseException) -> str:
        if isinstance(error, NameError) and self._folder is not None:
            return "(its file is imported: the part below if __name__ == '__main__' does not run)"
        return ""
