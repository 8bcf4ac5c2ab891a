"""Forward model given by expressions."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from geoswarm.solver.forward.formula import FormulaModel, FormulaSpec


def _model(**series: Any) -> FormulaModel:
    return FormulaSpec.model_validate({"kind": "formula", "series": series}).build()


def test_parameters_are_all_names_but_x() -> None:
    model = _model(decay="a * exp(-b * x)", line="a + c.d * x")
    assert [info.name for info in model.parameters] == ["a", "b", "c.d"]
    assert [info.description for info in model.parameters] == [
        "Used by decay, line.",
        "Used by decay.",
        "Used by line.",
    ]
    assert all(info.default is None for info in model.parameters)
    assert model.open_parameters


def test_series_with_units() -> None:
    section = {"expression": "a * x", "x_unit": "day", "y_unit": "m", "x_lower": 0, "x_upper": 2, "description": "way"}
    way, plain = _model(way=section, plain="a").series
    assert (way.name, way.description, way.x_unit, way.y_unit) == ("way", "way", "day", "m")
    assert (way.x_lower, way.x_upper, way.x_increasing, way.x_integer) == (0.0, 2.0, False, False)
    assert (plain.x_unit, plain.y_unit, plain.x_lower) == ("", "", None)


def test_responses() -> None:
    run = _model(decay="a * exp(-b * x)", constant="a").prepare(
        {"decay": np.array([0.0, 1.0, 2.0]), "constant": np.array([5.0, 5.0])}
    )
    responses = run({"a": 3.0, "b": 0.7})
    np.testing.assert_array_equal(responses["decay"], 3.0 * np.exp(-0.7 * np.array([0.0, 1.0, 2.0])))
    np.testing.assert_array_equal(responses["constant"], [3.0, 3.0])
    responses["constant"][0] = 7.0
    np.testing.assert_array_equal(run({"a": 3.0, "b": 0.7})["constant"], [3.0, 3.0])


def test_what_has_no_value_is_left_to_the_guard_of_the_objective() -> None:
    run = _model(y="ln(a - x) / x").prepare({"y": np.array([0.0, 1.0, 2.0])})
    np.testing.assert_array_equal(run({"a": 1.0})["y"], [np.nan, -np.inf, np.nan])


def test_points_are_kept_although_the_caller_changes_its_own() -> None:
    x = np.array([1.0, 2.0])
    run = _model(y="a * x").prepare({"y": x})
    x[:] = 9.0
    np.testing.assert_array_equal(run({"a": 1.0})["y"], [1.0, 2.0])


def test_grid_and_check() -> None:
    model = _model(y={"expression": "a * x", "x_lower": 1, "x_upper": 3}, z="a")
    assert model.grid("y").shape == (201,)
    assert model.grid("y")[[0, 100, -1]].tolist() == [1.0, 2.0, 3.0]
    assert model.grid("z").shape == (0,)
    assert model.check({"a": float("nan")}) is None


@pytest.mark.parametrize(
    ("series", "message"),
    [
        ({}, "at least 1 item"),
        ({"y": "a *"}, "expression ends where a number"),
        ({"y": "a > x"}, "a series is a number over x, not a comparison"),
        ({"1y": "a"}, "should match pattern"),
        ({"a.b": "a"}, "should match pattern"),
        ({"y": {"expression": "a", "x_lower": 2, "x_upper": 1}}, "x_lower 2 must be below x_upper 1"),
        ({"y": {"expression": "a", "colour": "red"}}, "Extra inputs are not permitted"),
        ({"y": 3}, "valid dictionary"),
    ],
)
def test_refused(series: dict[str, Any], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        FormulaSpec.model_validate({"kind": "formula", "series": series})


def test_short_and_long_form_are_the_same() -> None:
    short = FormulaSpec.model_validate({"series": {"y": "a * x"}})
    long = FormulaSpec.model_validate({"series": {"y": {"expression": " a * x "}}})
    assert short == long
    assert FormulaSpec.model_validate(short.model_dump(mode="json")) == short
