"""Values of expressions, compared with Python's own arithmetic and NumPy's."""

from __future__ import annotations

import math
import pickle
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import FUNCTIONS, parse_expression

VALUES = {"a": 2.5, "b": -0.75, "c": 3.0}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("-2 ** 2", -4.0),
        ("2 ** -1", 0.5),
        ("2 ** 3 ** 2", 512.0),
        ("8 / 4 / 2", 1.0),
        ("8 - 4 - 2", 2.0),
        ("1 + 2 * 3", 7.0),
        ("(1 + 2) * 3", 9.0),
        ("- -2", 2.0),
        ("+.5e1", 5.0),
        ("2*pi", 2 * math.pi),
        ("max(1, a, b)", 2.5),
        ("min(a)", 2.5),
        ("abs(b)", 0.75),
        ("ln(exp(1.5))", 1.5),
        ("log10(1000)", 3.0),
        ("sin(pi / 6)", 0.5),
        ("atan(1)", math.pi / 4),
    ],
)
def test_numbers(text: str, value: float) -> None:
    result = parse_expression(text).value(VALUES)
    assert type(result) is float
    assert result == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("a > b", True),
        ("b > a", False),
        ("b < a < c", True),
        ("b < a < 2", False),
        ("a > b or a / 0 > 1", True),
        ("a > b and c > a", True),
        ("not a > b", False),
        ("not (a > b and c < a)", True),
        ("not (a < b or c < a)", True),
        ("not not a > b", True),
        ("not b < a < 2", True),
        ("a == 2.5", True),
        ("a != 2.5", False),
        ("a >= 2.5 and a <= 2.5", True),
    ],
)
def test_truth(text: str, value: bool) -> None:
    assert parse_expression(text).value(VALUES) is value
    arrays = parse_expression(text).value({name: np.full(3, number) for name, number in VALUES.items()})
    np.testing.assert_array_equal(arrays, np.full(3, value))


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("1 / 0", math.inf),
        ("-1 / 0", -math.inf),
        ("0 / 0", math.nan),
        ("ln(0)", -math.inf),
        ("ln(-1)", math.nan),
        ("sqrt(-1)", math.nan),
        ("exp(1000)", math.inf),
        ("(-8) ** (1 / 3)", math.nan),
        ("0 ** -1", math.inf),
        ("10 ** 400", math.inf),
        ("sin(1 / 0)", math.nan),
        ("asin(2)", math.nan),
        ("max(1, 0 / 0)", math.nan),
        ("max(nan, 1)", math.nan),
        ("min(1, nan)", math.nan),
    ],
)
def test_what_has_no_finite_value_raises_nothing(text: str, value: float) -> None:
    expression = parse_expression(text)
    np.testing.assert_array_equal(expression.value({"nan": math.nan}), value)
    np.testing.assert_array_equal(expression.value({"nan": np.array([math.nan])}), np.asarray(value))


@pytest.mark.parametrize(
    "text", ["n > 1", "n < 1", "n == n", "n != n", "not n > 1", "not n != 1", "not (n > 1 or n < 1)"]
)
def test_a_comparison_with_nan_never_holds(text: str) -> None:
    expression = parse_expression(text)
    assert expression.value({"n": math.nan}) is False
    np.testing.assert_array_equal(expression.value({"n": np.array([math.nan, math.nan])}), [False, False])


def test_arrays_and_numbers_mix() -> None:
    x = np.array([0.0, 1.0, 2.0])
    result = parse_expression("a * x ** 2 + c").value({**VALUES, "x": x})
    np.testing.assert_array_equal(result, 2.5 * x**2 + 3.0)
    assert parse_expression("a + c").value({**VALUES, "x": x}) == 5.5


@pytest.mark.parametrize("value", [2, np.float64(2.0), np.int64(2), np.array(2.0)])
def test_every_kind_of_number_gives_a_float(value: float) -> None:
    result = parse_expression("1 / (a - 2) + a").value({"a": value})
    assert type(result) is float
    assert result == math.inf


def test_a_name_without_value_is_an_error() -> None:
    with pytest.raises(ExpressionError, match="no value for 'b' in 'a > b'"):
        parse_expression("a > b").value({"a": 1.0})


def test_equal_and_picklable() -> None:
    expression = parse_expression("a > b")
    assert pickle.loads(pickle.dumps(expression)) == expression  # noqa: S301
    assert {expression, parse_expression(" a > b ")} == {expression}
    assert expression != parse_expression("b < a")
    assert repr(expression) == "Expression('a > b')"


@pytest.mark.parametrize("name", list(FUNCTIONS))
def test_functions_of_floats_and_of_arrays_agree(name: str) -> None:
    expression = parse_expression("where(v > 0.3, v, 2)" if name == "where" else f"{name}(v)")
    values = np.array([-1.5, -0.5, 0.0, 0.3, 0.9, 1.0, 2.5, 700.0])
    one_by_one = [expression.value({"v": float(value)}) for value in values]
    np.testing.assert_allclose(expression.value({"v": values}), one_by_one, rtol=4e-16, atol=0)


_atoms = st.sampled_from(["a", "b", "c", "1", "2.5", "0.125", "1e-3"])
_sums = st.recursive(
    _atoms,
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from(["+", "-", "*", "/", " - -"]), inner).map("".join),
        st.tuples(st.just("("), inner, st.sampled_from(["+", "-", "*", "/"]), inner, st.just(")")).map("".join),
        st.tuples(st.just("-"), inner).map("".join),
        st.tuples(st.just("("), inner, st.sampled_from([")**2", ")**-1", ")**-2**2"])).map("".join),
        st.tuples(st.just("abs("), inner, st.just(")")).map("".join),
        st.tuples(st.just("min("), inner, st.just(","), inner, st.just(")")).map("".join),
    ),
    max_leaves=7,
)
_truths = st.recursive(
    st.tuples(_sums, st.sampled_from(["<", "<=", ">", ">=", "==", "!="]), _sums).map("".join),
    lambda inner: st.one_of(
        st.tuples(inner, st.sampled_from([" and ", " or "]), inner).map("".join),
        st.tuples(st.just("not ("), inner, st.just(")")).map("".join),
        st.tuples(st.just("not "), inner).map("".join),
    ),
    max_leaves=4,
)


def _by_python(text: str) -> float | bool | None:
    """The value that Python gives, None where it raises."""
    try:
        value = eval(text, {"__builtins__": {}, "abs": abs, "min": min}, VALUES)  # noqa: S307  the reference
    except (ZeroDivisionError, OverflowError):
        return None
    return value if isinstance(value, bool) else float(value)


@given(_sums | _truths)
def test_the_value_is_that_of_python(text: str) -> None:
    expected = _by_python(text)
    expression = parse_expression(text)
    result = expression.value(VALUES)
    if expected is None:
        assert isinstance(result, float | bool)
    else:
        assert type(result) is type(expected)
        assert result == expected or (math.isnan(result) and math.isnan(expected))
    arrays = expression.value({name: np.full(2, value) for name, value in VALUES.items()})
    if not expression.is_comparison:
        np.testing.assert_allclose(arrays, np.full_like(arrays, result), rtol=1e-13)


def test_nothing_is_compiled_or_evaluated_by_python() -> None:
    code = (
        "import sys\n"
        "from geoswarm.solver.expressions import parse_expression\n"
        "events = []\n"
        "sys.addaudithook(lambda event, args: events.append(event))\n"
        "parse_expression('a * exp(b) > 1').value({'a': 1.0, 'b': 2.0})\n"
        "print([event for event in events if event in ('compile', 'exec')])\n"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"
