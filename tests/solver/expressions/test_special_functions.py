"""erf, erfc, exp1 and where."""

from __future__ import annotations

import math

import numpy as np
import pytest

from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import parse_expression


@pytest.mark.parametrize(
    ("text", "x", "value"),
    [  # Abramowitz and Stegun (1964), tables 7.1 and 5.1
        ("erf(x)", 0.5, 0.5204998778),
        ("erf(x)", 2.0, 0.9953222650),
        ("erfc(x)", 0.5, 1.0 - 0.5204998778),
        ("exp1(x)", 0.5, 0.5597735948),
        ("exp1(x)", 2.0, 0.0489005107),
    ],
)
def test_published_values(text: str, x: float, value: float) -> None:
    expression = parse_expression(text)
    assert expression.value({"x": x}) == pytest.approx(value, abs=2e-10)
    np.testing.assert_allclose(expression.value({"x": np.array([x, x])}), [value, value], atol=2e-10)


def test_exp1_where_it_is_not_defined() -> None:
    expression = parse_expression("exp1(x)")
    assert expression.value({"x": 0.0}) == math.inf
    assert math.isnan(float(expression.value({"x": -1.0})))
    assert parse_expression("erfc(x)").value({"x": 10.0}) == pytest.approx(2.088487583762545e-45, rel=1e-12)


def test_where_takes_one_of_two_numbers() -> None:
    hinge = parse_expression("where(x < a, 1 / x, 2 * x)")
    assert hinge.value({"x": 0.5, "a": 1.0}) == 2.0
    assert hinge.value({"x": 3.0, "a": 1.0}) == 6.0
    assert hinge.value({"x": 0.0, "a": -1.0}) == 0.0  # 1 / 0 stands in the other branch
    assert hinge.value({"x": 0.0, "a": 1.0}) == math.inf
    x = np.array([0.5, 3.0, 0.0])
    np.testing.assert_array_equal(hinge.value({"x": x, "a": 1.0}), [2.0, 6.0, np.inf])
    assert hinge.names == {"x", "a"}
    assert not hinge.is_comparison
    nested = parse_expression("where(x > 0 and not x > 2, where(x == 1, 10, 20), 30) + 1")
    np.testing.assert_array_equal(nested.value({"x": np.array([1.0, 2.0, 3.0, -1.0])}), [11, 21, 31, 31])


def test_where_over_something_undefined_is_undefined() -> None:
    expression = parse_expression("where(ln(x) > 0, 1, 2)")
    assert math.isnan(float(expression.value({"x": -1.0})))
    np.testing.assert_array_equal(expression.value({"x": np.array([-1.0, 3.0, 0.5])}), [np.nan, 1.0, 2.0])
    assert isinstance(expression.value({"x": -1.0}), float)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("where(x, 1, 2)", "'where' needs comparisons such as a > b, but got a number"),
        ("where(x > 1, 2)", "takes a comparison and two numbers"),
        ("where(x > 1, 2, 3, 4)", "takes a comparison and two numbers"),
        ("where(x > 1, x > 2, 3)", "'where' needs numbers, but got a comparison"),
        ("if(x > 1, 2, 3)", r"write where\(a > b, c, d\)"),
        ("E1(x)", "write exp1"),
        ("erf(x, 2)", "takes one argument, got 2"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(ExpressionError, match=message):
        parse_expression(text)
