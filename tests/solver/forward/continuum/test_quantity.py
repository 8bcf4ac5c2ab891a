"""Numbers of a section that may be expressions of parameters."""

from __future__ import annotations

import json
from typing import Annotated, Any

import pytest
from pydantic import BaseModel, ValidationError

from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.continuum.quantity import (
    Length,
    LineValueRange,
    Positive,
    Quantity,
    ValueRange,
    quantities_in,
    value_of,
)


class Part(BaseModel):
    depth: Positive
    line: Annotated[Any, LineValueRange("m", 0.0)] | None = None


class Whole(BaseModel):
    parts: list[Part]
    x: Length = 0.0


def parsed(**fields: object) -> Part:
    return Part.model_validate_json(json.dumps(fields), strict=True)


def test_numbers_and_expressions_have_values() -> None:
    assert parsed(depth=3).depth == 3.0
    assert parsed(depth="2 * 3").depth == 6.0
    part = parsed(depth="1.5 * d", line=[[0, 1], ["w", "d"], [20, 0]])
    assert value_of(part.depth, {"d": 2.0}) == 3.0
    assert [[value_of(number, {"d": 2.0, "w": 9.0}) for number in point] for point in part.line] == [
        [0.0, 1.0],
        [9.0, 2.0],
        [20.0, 0.0],
    ]


def test_what_was_written_is_written_again() -> None:
    given = {"depth": "1.5 * d", "line": [[0.0, 1.0], ["w", "d"]]}
    assert parsed(**given).model_dump(mode="json") == given
    assert Part.model_validate(parsed(**given).model_dump()) == parsed(**given)


def test_quantities_are_found_wherever_they_are() -> None:
    whole = Whole(parts=[parsed(depth="a"), parsed(depth=1, line=[[0, "b"], ["c", 1]])], x="d + a")
    found = [quantity.expression.text for quantity in quantities_in(whole)]
    assert found == ["a", "b", "c", "d + a"]
    assert all(isinstance(quantity, Quantity) for quantity in quantities_in(whole))
    assert [quantity.limits.unit for quantity in quantities_in(whole)] == ["m"] * 4


@pytest.mark.parametrize(
    ("fields", "words"),
    [
        ({"depth": 0}, "must be above 0, got 0 m"),
        ({"depth": "1 - 2"}, "must be above 0, got -1 m"),
        ({"depth": True}, "must be a number, or an expression of parameters as text"),
        ({"depth": "2 *"}, "expression ends"),
        ({"depth": "a > 2"}, "'a > 2' is a comparison"),
        ({"depth": 1, "line": []}, "must be a list of 1 to 500 points"),
        ({"depth": 1, "line": [[0, 1, 2]]}, "each point is a list of two numbers"),
        ({"depth": 1, "line": [[0, 1], [0, 2]]}, "0 m follows 0 m; places must increase"),
        ({"depth": 1, "line": [[0, -1]]}, "must be at least 0, got -1 m"),
    ],
)
def test_what_is_no_such_number_is_refused(fields: dict[str, object], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        parsed(**fields)


def test_a_value_beyond_its_limits_is_infeasible() -> None:
    limits = ValueRange("kPa", 1.0, upper=5.0)
    quantity = limits.parse("2 * a")
    assert quantity.value({"a": 2.5}) == 5.0
    for value in (0.4, 3.0, float("nan")):
        with pytest.raises(InfeasibleError, match=r"'2 \* a' must be at least 1 and at most 5, got .* kPa"):
            quantity.value({"a": value})


def test_the_schema_tells_both_forms() -> None:
    properties = Part.model_json_schema()["properties"]
    assert properties["depth"]["anyOf"] == [{"type": "number", "exclusiveMinimum": 0.0}, {"type": "string"}]
    assert [form.get("type") for form in properties["line"]["anyOf"]] == ["number", "string", "array", "null"]
