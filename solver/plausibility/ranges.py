"""Values far outside the usual ranges: those of fields (``x-typical`` of their schema) and parameters (``typical``).

The ranges stand beside the fields themselves; a form shows the same ones. Nothing is said of what is merely unusual:
only of a value more than ten times beyond an end, or of stages whose middle one is more than twice beyond it. A value
of a stage to which others lead from the usual range, each at most ten times the one before, is no slip. A default may
mean something else, such as a value that is derived, and is usual.
"""

from __future__ import annotations

import statistics
from collections.abc import Iterator
from itertools import pairwise
from typing import Any

from pydantic import BaseModel

from geoswarm.solver.forward.base import ParameterInfo
from geoswarm.solver.problem import FixedParameter, FreeParameter, Problem
from geoswarm.solver.sentences import Key, Sentence
from geoswarm.solver.units import meant_unit, with_unit

__all__ = ["unusual_values"]

_FAR = 10.0
_FAR_OF_MOST = 2.0

Range = tuple[float, float]


def unusual_values(problem: Problem) -> Iterator[Sentence]:
    """Fields of the forward model and parameters with values far outside their usual ranges."""
    yield from _fields(problem.forward_model, "forward_model")
    for info in problem.model.parameters:
        parameter = problem.parameters.get(info.name)
        if info.typical is None or parameter is None:
            continue
        if isinstance(parameter, FixedParameter):
            if parameter.value != info.default and _far(parameter.value, info.typical):
                yield _sentence(f"parameters.{info.name}.value", parameter.value, info.unit, info.typical)
        elif isinstance(parameter, FreeParameter):
            yield from _bounds(parameter, info, info.typical)


def _bounds(parameter: FreeParameter, info: ParameterInfo, usual: Range) -> Iterator[Sentence]:
    """A search range that lies far outside as a whole."""
    if _far(parameter.upper, usual) and parameter.upper < usual[0]:
        yield _sentence(f"parameters.{info.name}.upper", parameter.upper, info.unit, usual)
    elif _far(parameter.lower, usual) and parameter.lower > usual[1]:
        yield _sentence(f"parameters.{info.name}.lower", parameter.lower, info.unit, usual)


def _fields(section: BaseModel, path: str) -> Iterator[Sentence]:
    """All fields of a section and of the sections inside it."""
    for name, field in type(section).model_fields.items():
        value, place = getattr(section, name), f"{path}.{name}"
        extra = field.json_schema_extra
        hint: dict[str, Any] = extra if isinstance(extra, dict) else {}
        if isinstance(value, BaseModel):
            yield from _fields(value, place)
        elif isinstance(value, dict):
            for key, inner in value.items():
                if isinstance(inner, BaseModel):
                    yield from _fields(inner, f"{place}.{key}")
        elif isinstance(value, tuple) and value and all(isinstance(one, BaseModel) for one in value):
            yield from _entries(value, place)
        elif "x-typical" in hint and isinstance(value, int | float):
            low, high = hint["x-typical"]
            if value != field.default and _far(value, (low, high)):
                yield _sentence(place, value, hint["x-unit"], (low, high))


def _entries(entries: tuple[BaseModel, ...], path: str) -> Iterator[Sentence]:
    """Entries of a list: what is unusual in most of them once, else each value that is far outside."""
    for name, field in type(entries[0]).model_fields.items():
        extra = field.json_schema_extra
        values = [getattr(one, name, None) for one in entries]
        numbers = [float(value) for value in values if isinstance(value, int | float)]
        if not isinstance(extra, dict) or "x-typical" not in extra or len(numbers) < len(values):
            continue
        hint: dict[str, Any] = extra
        low, high = hint["x-typical"]
        middle = statistics.median_low(numbers)
        if _far(middle, (low, high)) or middle > _FAR_OF_MOST * high:
            yield _sentence(f"{path}[].{name}", middle, hint["x-unit"], (low, high), "in the middle of all")
            continue
        far = (number for number in numbers if _far(number, (low, high)) and not _led_to(number, numbers, (low, high)))
        for value in dict.fromkeys(far):
            places = ", ".join(str(index) for index, number in enumerate(numbers) if number == value)
            yield _sentence(f"{path}[{places}].{name}", value, hint["x-unit"], (low, high))


def _led_to(value: float, numbers: list[float], usual: Range) -> bool:
    """Whether some of the numbers lead from the usual range to a value, each at most ten times the one before."""
    low, high = usual
    below = value < low
    way = sorted({one for one in numbers if (one >= value if below else one <= value)}, reverse=not below)
    for one, following in pairwise(way):
        if not max(one, following) <= _FAR * min(one, following):
            return False
        if low <= following <= high:
            return True
    return False


def _far(value: float, usual: Range) -> bool:
    low, high = usual
    return value > _FAR * high or (low > 0.0 and value < low / _FAR)


def _sentence(path: str, value: float, unit: str, usual: Range, which: str = "") -> Sentence:
    low, high = usual
    shown = with_unit(value, unit) + (f" ({which})" if which else "")
    key, text = Key(path, path), f" = {shown} is far from what is usual, {low:g} to {with_unit(high, unit)}"
    meant = meant_unit(value, unit, lambda moved: low <= moved <= high)
    if meant is None:
        return key, f"{text}; check the value" + (f" and its unit, {unit}" if unit not in ("", "1") else "")
    return key, f"{text}; if {value:g} {meant[0]} is meant, give {meant[1]:.4g}, because the unit here is {unit or '1'}"
