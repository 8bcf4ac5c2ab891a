"""Forward model given by expressions: for teaching, for tests of the method and for quick curve fits.

::

    forward_model:
      kind: formula
      series:
        decay: a * exp(-b * x)
        settlement: {expression: "s0 * ln(1 + x / t0)", x_unit: day, y_unit: m}

Every name in an expression other than ``x`` is a parameter, or an input that the observation of the series gives beside
x (``inputs: {T: temperature}``).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, ClassVar, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import Expression, parse_expression
from geoswarm.solver.forward.base import ForwardModelSpec, ForwardRun, ParameterInfo, SeriesInfo
from geoswarm.solver.sentences import SentenceError, setting

__all__ = ["FormulaModel", "FormulaSeries", "FormulaSpec"]

VARIABLE = "x"
GRID_POINTS = 201


class FormulaSeries(BaseModel):
    """One series of a formula."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    expression: str = Field(description="y as an expression of x and the parameters")
    x_unit: str = Field("dimensionless", description="unit of x inside the expression")
    y_unit: str = Field("dimensionless", description="unit of the expression's value")
    x_lower: float | None = Field(None, description="lowest x that may be requested")
    x_upper: float | None = Field(None, description="highest x that may be requested")
    description: str = Field("", max_length=200, description="what the series is")

    @field_validator("expression")
    @classmethod
    def _is_number(cls, text: str) -> str:
        try:
            expression = parse_expression(text)
        except ExpressionError as error:
            raise ValueError(str(error)) from error
        if expression.is_comparison:
            raise ValueError("a series is a number over x, not a comparison")
        return expression.text

    @model_validator(mode="after")
    def _ordered(self) -> FormulaSeries:
        if self.x_lower is not None and self.x_upper is not None and self.x_lower >= self.x_upper:
            raise SentenceError(
                *(setting("x_lower"), f" {self.x_lower:g} must be below "), setting("x_upper"), f" {self.x_upper:g}"
            )
        return self


def _long_form(value: Any) -> Any:
    return {"expression": value} if isinstance(value, str) else value


class FormulaSpec(ForwardModelSpec):
    """Series given as expressions of x and the parameters."""

    depends_on_section: ClassVar[bool] = True

    kind: Literal["formula"] = "formula"
    series: dict[
        Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=100)],
        Annotated[FormulaSeries, BeforeValidator(_long_form, json_schema_input_type=str | FormulaSeries)],
    ] = Field(min_length=1, description="series by name: an expression, or a mapping with expression and units")

    @classmethod
    def example(cls) -> dict[str, Any]:
        """A settlement that slows down."""
        return {"kind": "formula", "series": {"settlement": {"expression": "a * (1 - exp(-b * x))"}}}

    @property
    def quick(self) -> bool:
        """A formula always is."""
        return True

    def build(self) -> FormulaModel:
        """Build the forward model."""
        return FormulaModel(self)


@dataclass(frozen=True, slots=True)
class _Series:
    """``inputs`` are those at the points ``x``, shape (m,), in rising order of x."""

    info: SeriesInfo
    expression: Expression
    x: FloatArray
    inputs: Mapping[str, FloatArray]

    def inputs_at(self, x: FloatArray) -> dict[str, FloatArray]:
        """Inputs at x, shape (n,): those of the observed points, linear between them elsewhere."""
        if not self.inputs:
            return {}
        if np.array_equal(x, self.x):
            return dict(self.inputs)
        order = np.argsort(self.x, kind="stable")
        return {name: np.interp(x, self.x[order], values[order]) for name, values in self.inputs.items()}


class FormulaModel:
    """Series given as expressions.

    Parameters
    ----------
    inputs
        By series: the points x, shape (m,), base units, and what else is known there, each of shape (m,).
    """

    def __init__(
        self, spec: FormulaSpec, inputs: Mapping[str, tuple[FloatArray, Mapping[str, FloatArray]]] | None = None
    ) -> None:
        self._spec = spec
        nothing = (np.empty(0), dict[str, FloatArray]())
        self._series = {
            name: _Series(
                _info(name, section), parse_expression(section.expression), *(inputs or {}).get(name, nothing)
            )
            for name, section in spec.series.items()
        }
        users: dict[str, list[str]] = {}
        for name, series in self._series.items():
            for parameter in sorted(series.expression.names - {VARIABLE} - series.inputs.keys()):
                users.setdefault(parameter, []).append(name)
        self._parameters = tuple(
            ParameterInfo(name, name, "", f"Used by {', '.join(names)}.") for name, names in users.items()
        )

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """All names in the expressions but x and the inputs."""
        return self._parameters

    def with_inputs(self, inputs: Mapping[str, tuple[FloatArray, Mapping[str, FloatArray]]]) -> FormulaModel:
        """Return the model that knows further quantities at the observed points.

        Raises
        ------
        ValueError
            When the expression of a series does not use one of its inputs.
        """
        for name, (_, given) in inputs.items():
            unused = [i for i in given if i == VARIABLE or i not in self._series[name].expression.names]
            if unused:
                raise ValueError(
                    f"input {unused[0]} is not used in '{self._series[name].expression.text}' of series '{name}'"
                )
        return FormulaModel(self._spec, inputs)

    @property
    def open_parameters(self) -> bool:
        """True: a problem may declare helpers for linked parameters and constraints."""
        return True

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Series in the order of the problem file."""
        return tuple(series.info for series in self._series.values())

    def grid(self, series: str) -> FloatArray:
        """Points x, shape (201,) between ``x_lower`` and ``x_upper``; shape (0,) when the formula has no such range."""
        info = self._series[series].info
        if info.x_lower is None or info.x_upper is None:
            return np.empty(0)
        return np.linspace(info.x_lower, info.x_upper, GRID_POINTS)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """Nothing is inadmissible: the value of an expression shows it."""
        del parameters
        return None

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of the given series at x, each of shape (m_g,), in the units of the formula.

        Where an expression has no value, the response is nan or inf.
        """
        prepared = [
            (name, self._series[name].expression, {VARIABLE: x, **self._series[name].inputs_at(x)})
            for name, x in ((name, np.array(x, dtype=np.float64)) for name, x in points.items())
        ]

        def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            return {
                name: np.array(np.broadcast_to(expression.value({**parameters, **known}), known[VARIABLE].shape))
                for name, expression, known in prepared
            }

        return run


def _base(unit: str) -> str:
    return "" if unit in ("dimensionless", "1", "-") else unit


def _info(name: str, section: FormulaSeries) -> SeriesInfo:
    return SeriesInfo(
        name=name,
        description=section.description or section.expression,
        x_quantity=VARIABLE,
        x_unit=_base(section.x_unit),
        y_quantity=name,
        y_unit=_base(section.y_unit),
        x_lower=section.x_lower,
        x_upper=section.x_upper,
        x_increasing=False,
    )
