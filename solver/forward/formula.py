"""Forward model given by expressions: for teaching, for tests of the method and for quick curve fits.

::

    forward_model:
      kind: formula
      series:
        decay: a * exp(-b * x)
        settlement: {expression: "s0 * ln(1 + x / t0)", x_unit: day, y_unit: m}

Every name in an expression other than ``x`` is a parameter.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, field_validator, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import Expression, parse_expression
from geoswarm.solver.forward.base import ForwardModelSpec, ForwardRun, ParameterInfo, SeriesInfo

__all__ = ["FormulaModel", "FormulaSeries", "FormulaSpec"]

VARIABLE = "x"
GRID_POINTS = 201


class FormulaSeries(BaseModel):
    """One series of a formula."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    expression: str = Field(description="y as an expression of x and the parameters")
    x_unit: str = Field("dimensionless", description="unit of x inside the expression")
    y_unit: str = Field("dimensionless", description="unit of the expression's value")
    x_lower: float | None = Field(None, description="lowest x that may be asked for")
    x_upper: float | None = Field(None, description="highest x that may be asked for")
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
            raise ValueError(f"x_lower {self.x_lower:g} must be below x_upper {self.x_upper:g}")
        return self


def _long_form(value: Any) -> Any:
    return {"expression": value} if isinstance(value, str) else value


class FormulaSpec(ForwardModelSpec):
    """Series given as expressions of x and the parameters."""

    kind: Literal["formula"] = "formula"
    series: dict[
        Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=100)],
        Annotated[FormulaSeries, BeforeValidator(_long_form, json_schema_input_type=str | FormulaSeries)],
    ] = Field(min_length=1, description="series by name: an expression, or a mapping with expression and units")

    @property
    def quick(self) -> bool:
        """A formula always is."""
        return True

    def build(self) -> FormulaModel:
        """Build the forward model."""
        return FormulaModel(self)


@dataclass(frozen=True, slots=True)
class _Series:
    info: SeriesInfo
    expression: Expression


class FormulaModel:
    """Series given as expressions."""

    def __init__(self, spec: FormulaSpec) -> None:
        self._series = {name: _series(name, section) for name, section in spec.series.items()}
        users: dict[str, list[str]] = {}
        for name, series in self._series.items():
            for parameter in sorted(series.expression.names - {VARIABLE}):
                users.setdefault(parameter, []).append(name)
        self._parameters = tuple(
            ParameterInfo(name, name, "", f"Used by {', '.join(names)}.") for name, names in users.items()
        )

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """All names in the expressions but x."""
        return self._parameters

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
        prepared = [(name, self._series[name].expression, np.array(x, dtype=np.float64)) for name, x in points.items()]

        def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            return {
                name: np.array(np.broadcast_to(expression.value({**parameters, VARIABLE: x}), x.shape))
                for name, expression, x in prepared
            }

        return run


def _base(unit: str) -> str:
    return "" if unit in ("dimensionless", "1", "-") else unit


def _series(name: str, section: FormulaSeries) -> _Series:
    info = SeriesInfo(
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
    return _Series(info, parse_expression(section.expression))
