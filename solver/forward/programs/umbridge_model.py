"""The forward model that a server is: one request for each evaluation."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.interpolation import at_points
from geoswarm.solver.external.umbridge import Server, checked_info, checked_sizes, vectors
from geoswarm.solver.forward.base import ForwardRun, ParameterInfo
from geoswarm.solver.forward.programs.foreign import ForeignModel, series_in_base_units
from geoswarm.solver.units import base_unit, convert

if TYPE_CHECKING:
    from geoswarm.solver.forward.programs.umbridge import UmbridgeSpec

__all__ = ["UmbridgeModel"]


class UmbridgeModel(ForeignModel):
    """A model behind the UM-Bridge protocol as a forward model; its parameters are those of ``inputs``.

    Parameters
    ----------
    spec
        Its section.

    Raises
    ------
    ProblemError
        The unit of a series is unknown.
    """

    def __init__(self, spec: UmbridgeSpec) -> None:
        self._spec = spec
        inputs = (
            ParameterInfo(name, name, "", f"Input {place} of {spec.name}.")
            for place, vector in enumerate(spec.inputs)
            for name in vector
        )
        super().__init__(
            inputs,
            series_in_base_units(
                spec.series, lambda section: section.description or f"Output {section.output} of {spec.name}."
            ),
        )
        self._x = {
            name: convert(section.x, section.x_unit, base_unit(section.x_unit)) for name, section in spec.series.items()
        }

    def grid(self, series: str) -> FloatArray:
        """The points of the section, shape (n,), base unit, in rising order."""
        return np.sort(self._x[series])

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of series at x, each of shape (m_g,), base units; the server is not called yet."""
        wanted = {name: np.array(x, dtype=np.float64) for name, x in points.items()}
        return _Requests(self._spec, {name: self._x[name] for name in wanted}, wanted)


class _Requests:
    """Asks the server."""

    def __init__(self, spec: UmbridgeSpec, x: Mapping[str, FloatArray], wanted: Mapping[str, FloatArray]) -> None:
        self._spec = spec
        self._x, self._wanted = x, wanted
        self._server = Server(spec.url, spec.seconds, spec.tries, spec.pause)
        self._about: dict[str, Any] = {"name": spec.name, "config": spec.config}
        self._sizes: list[int] | None = None

    def __call__(self, parameters: Mapping[str, float]) -> dict[str, FloatArray]:
        """Return the responses; raises ForwardError."""
        spec = self._spec
        if self._sizes is None:
            self._sizes = self._checked()
        values = [[float(parameters[name]) for name in vector] for vector in spec.inputs]
        answer = self._server.call("/Evaluate", {**self._about, "input": values})
        output = vectors(answer, self._sizes, spec.url)
        found = {}
        for name, x in self._wanted.items():
            section = spec.series[name]
            y = convert(output[section.output], section.y_unit, base_unit(section.y_unit))
            found[name] = at_points(name, self._x[name], y, x)
        return found

    def _checked(self) -> list[int]:
        """Sizes of the output vectors, when model, inputs and series fit the section."""
        spec, server = self._spec, self._server
        checked_info(server.call("/Info"), spec.name, spec.url)
        support = server.call("/ModelInfo", {"name": spec.name})
        if not (isinstance(support, dict) and isinstance(support.get("support"), dict)):
            raise RunFailedError("bad_output", f"{spec.url} answered no ModelInfo: {str(support)[:100]}")
        if support["support"].get("Evaluate") is not True:
            raise RunFailedError("bad_output", f"{spec.url}: model {spec.name} does not support Evaluate")
        inputs = checked_sizes(server.call("/InputSizes", self._about), "inputSizes", spec.url)
        given = [len(vector) for vector in spec.inputs]
        if inputs != given:
            raise RunFailedError(
                "bad_output",
                f"{spec.url}: model {spec.name} takes input vectors of {inputs} numbers, but inputs has {given}",
            )
        outputs = checked_sizes(server.call("/OutputSizes", self._about), "outputSizes", spec.url)
        for name, section in spec.series.items():
            if section.output >= len(outputs):
                message = f"series.{name}.output is {section.output}, but the model has outputs 0 to {len(outputs) - 1}"
                raise RunFailedError("bad_output", f"{spec.url}: {message}")
            if outputs[section.output] != len(section.x):
                message = f"has {outputs[section.output]} numbers, but series.{name}.x has {len(section.x)} points"
                raise RunFailedError("bad_output", f"{spec.url}: output {section.output} {message}")
        return outputs
