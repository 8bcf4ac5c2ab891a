"""Numbers of a problem's section that may be given as expressions of parameters: ``30``, or ``"1.2 * depth"``."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated, Any, TypeAlias

from pydantic import BaseModel, GetCoreSchemaHandler, GetJsonSchemaHandler
from pydantic_core import CoreSchema, core_schema

from geoswarm.solver.errors import ExpressionError, InfeasibleError
from geoswarm.solver.expressions import Expression, parse_expression

__all__ = [
    "Amount",
    "Length",
    "ValueRange",
    "LineValueRange",
    "Number",
    "Positive",
    "Quantity",
    "quantities_in",
    "value_of",
]

_MOST_POINTS = 500


@dataclass(frozen=True)
class ValueRange:
    """Annotation of a field whose value is a number within a range, or an expression of parameters for one."""

    unit: str = ""
    lower: float = -math.inf
    lower_open: bool = False
    upper: float = math.inf
    upper_open: bool = False

    def parse(self, value: Any) -> Any:
        """Return a float, or a Quantity for an expression with names."""
        if isinstance(value, Quantity):
            return value
        if isinstance(value, str):
            try:
                expression = parse_expression(value)
            except ExpressionError as error:
                raise ValueError(str(error)) from error
            if expression.is_comparison:
                raise ValueError(f"'{expression.text}' is a comparison; give a number or an expression")
            if expression.names:
                return Quantity(expression, self)
            value = expression.value({})
        if isinstance(value, bool) or not isinstance(value, int | float):
            raise ValueError("must be a number, or an expression of parameters as text")
        fault = self.fault(float(value))
        if fault is not None:
            raise ValueError(fault)
        return float(value)

    def fault(self, value: float) -> str | None:
        """What is wrong with a value, and what is accepted, or None."""
        above = value > self.lower or (value == self.lower and not self.lower_open)
        below = value < self.upper or (value == self.upper and not self.upper_open)
        if math.isfinite(value) and above and below:
            return None
        parts = []
        if self.lower > -math.inf:
            parts.append(f"{'above' if self.lower_open else 'at least'} {self.lower:g}")
        if self.upper < math.inf:
            parts.append(f"{'below' if self.upper_open else 'at most'} {self.upper:g}")
        return f"must be {' and '.join(parts) or 'a finite number'}, got {f'{value:g} {self.unit}'.strip()}"

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        del source, handler
        written = core_schema.plain_serializer_function_ser_schema(_written)
        return core_schema.no_info_plain_validator_function(self.parse, serialization=written)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        del schema, handler
        limits: dict[str, Any] = {}
        if self.lower > -math.inf:
            limits["exclusiveMinimum" if self.lower_open else "minimum"] = self.lower
        if self.upper < math.inf:
            limits["exclusiveMaximum" if self.upper_open else "maximum"] = self.upper
        return {"anyOf": [{"type": "number", **limits}, {"type": "string"}]}


@dataclass(frozen=True)
class LineValueRange(ValueRange):
    """As :class:`ValueRange`, or points [place, value], the places increasing, whose values are within the limits."""

    fewest: int = 1
    number: bool = True

    def parse(self, value: Any) -> Any:
        """Return a number as :class:`ValueRange` does, or a list of pairs of such numbers."""
        if self.number and not isinstance(value, list | tuple):
            return super().parse(value)
        if not isinstance(value, list | tuple) or not self.fewest <= len(value) <= _MOST_POINTS:
            raise ValueError(f"must be a list of {self.fewest} to {_MOST_POINTS} points")
        if not all(isinstance(point, list | tuple) and len(point) == 2 for point in value):
            raise ValueError("each point is a list of two numbers (or expressions of parameters)")
        points = [(ValueRange("m").parse(place), super(LineValueRange, self).parse(inner)) for place, inner in value]
        for (before, _), (after, _) in pairwise(points):
            if isinstance(before, float) and isinstance(after, float) and after <= before:
                raise ValueError(f"{after:g} m follows {before:g} m; places must increase")
        return points

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        inner = super().__get_pydantic_json_schema__(schema, handler)
        anything = {"anyOf": [{"type": "number"}, {"type": "string"}]}
        point = {"type": "array", "prefixItems": [anything, inner], "minItems": 2, "maxItems": 2}
        line = {"type": "array", "items": point, "minItems": self.fewest, "maxItems": _MOST_POINTS}
        return {"anyOf": [*inner["anyOf"], line]} if self.number else line


def _written(value: Any) -> Any:
    if isinstance(value, Quantity):
        return value.expression.text
    return [list(map(_written, point)) for point in value] if isinstance(value, list) else value


@dataclass(frozen=True)
class Quantity:
    """An expression of parameters, and the limits of its value."""

    expression: Expression
    limits: ValueRange

    def value(self, values: Mapping[str, float]) -> float:
        """Value for parameters by name.

        Raises
        ------
        InfeasibleError
            The value is outside its limits.
        """
        found = float(self.expression.value(values))
        fault = self.limits.fault(found)
        if fault is not None:
            raise InfeasibleError(f"'{self.expression.text}' {fault}")
        return found


def value_of(number: Number, values: Mapping[str, float]) -> float:
    """Value of a number for parameters by name.

    Raises
    ------
    InfeasibleError
        The value of an expression is outside its limits.
    """
    return number.value(values) if isinstance(number, Quantity) else float(number)


def quantities_in(part: Any) -> Iterator[Quantity]:
    """All quantities in a section of a problem, whatever it is made of."""
    if isinstance(part, Quantity):
        yield part
    elif isinstance(part, BaseModel):
        for name in type(part).model_fields:
            yield from quantities_in(getattr(part, name))
    elif isinstance(part, Mapping):
        for inner in part.values():
            yield from quantities_in(inner)
    elif isinstance(part, list | tuple):
        for inner in part:
            yield from quantities_in(inner)


Number: TypeAlias = Any
"""A float or a :class:`Quantity`."""
Amount: TypeAlias = Annotated[Any, ValueRange()]
"""Any number."""
Length: TypeAlias = Annotated[Any, ValueRange("m")]
"""A coordinate, m."""
Positive: TypeAlias = Annotated[Any, ValueRange("m", 0.0, lower_open=True)]
"""A length above 0, m."""
