"""Parsing: what is accepted, and one clear message for everything else."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions import CONSTANTS, FUNCTIONS, MAX_DEPTH, MAX_LENGTH, Expression, parse_expression


@pytest.mark.parametrize(
    ("text", "names", "is_comparison"),
    [
        ("lambda_star > kappa_star", {"lambda_star", "kappa_star"}, True),
        (" 0.5 * lambda_star ", {"lambda_star"}, False),
        ("oedometer.mu_star + isotropic.mu_star", {"oedometer.mu_star", "isotropic.mu_star"}, False),
        ("2 * pi", set(), False),
        ("λ + 1", {"λ"}, False),
        ("not a > b and (c == 1 or d != 2)", {"a", "b", "c", "d"}, True),
        ("a * exp(-x / t)", {"a", "x", "t"}, False),
        ("android + order + nothing", {"android", "order", "nothing"}, False),
    ],
)
def test_accepted(text: str, names: set[str], is_comparison: bool) -> None:
    expression = parse_expression(text)
    assert expression.names == names
    assert expression.is_comparison is is_comparison
    assert expression.text == text.strip()


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expression is empty; write for example 0.5 * lambda_star"),
        ("  ", "expression is empty"),
        ("a ^ 2", "unexpected '^' at character 3; write a**b for a power"),
        ("a = b", "unexpected '=' at character 3; write == to compare"),
        ("a <> b", "unexpected '<>' at character 3; write != to compare"),
        ("a // b", "unexpected '//' at character 3; only + - * / ** are known"),
        ("a % b", "unexpected '%' at character 3; only + - * / ** are known"),
        ("a > b && b > c", "unexpected '&&' at character 7; write and"),
        ("!a > b", "unexpected '!' at character 1; write not"),
        ("[a]", "unexpected '[' at character 1; write ( )"),
        ("a ; b", "unexpected ';' at character 3"),
        ("a > 'b'", """unexpected "'" at character 5"""),
        (
            "log(a)",
            "unknown function 'log'; write ln for the natural or log10 for the decimal logarithm; known: exp, ln",
        ),
        ("sine(a)", "unknown function 'sine'; did you mean sin?; known: exp, ln"),
        ("zzz(a)", "unknown function 'zzz'; known: exp, ln"),
        ("a.b(1)", "unknown function 'a.b'"),
        ("__import__(1)", "unknown function '__import__'"),
        ("sin", "'sin' at character 1 is a function; write sin(...)"),
        ("sin(a, b)", "'sin' at character 1 takes one argument, got 2"),
        ("max()", "unexpected ')' at character 5; a number, a name or '(' is expected there"),
        ("max(a,)", "unexpected ')' at character 7; a number, a name or '(' is expected there"),
        ("(a + b", "expression ends where an operator or ')' is expected"),
        ("max(a", "expression ends where an operator, ',' or ')' is expected"),
        ("a +", "expression ends where a number, a name or '(' is expected"),
        ("a b", "unexpected 'b' at character 3; an operator is expected there"),
        ("a + b)", "unexpected ')' at character 6; an operator is expected there"),
        ("2a", "'2a' at character 1 is not a number; write * to multiply"),
        ("0x10", "'0x10' at character 1 is not a number; write * to multiply"),
        ("1_000", "'1_000' at character 1 is not a number; write * to multiply"),
        ("1e999", "number '1e999' at character 1 is too large; the largest is 1.79e308"),
        ("a. b", "unexpected '.' at character 2"),
        ("a and b > c", "'and' needs comparisons such as a > b, but got a number"),
        ("not a", "'not' needs comparisons such as a > b, but got a number"),
        ("(a > b) + 1", "'+' needs numbers, but got a comparison"),
        ("(a > b) > c", "'>' needs numbers, but got a comparison"),
        ("-(a > b)", "'-' needs numbers, but got a comparison"),
        ("(a > b) ** 2", "'**' needs numbers, but got a comparison"),
        ("max(a > b)", "'max' needs numbers, but got a comparison"),
        ("and > 1", "unexpected 'and' at character 1; a number, a name or '(' is expected there"),
        ("a if b > c else d", "unexpected 'if' at character 3; an operator is expected there"),
        ("lambda: 1", "unexpected ':' at character 7"),
        ("a" * (MAX_LENGTH + 1), f"expression has {MAX_LENGTH + 1} characters; at most {MAX_LENGTH} are accepted"),
    ],
)
def test_refused(text: str, message: str) -> None:
    with pytest.raises(ExpressionError) as caught:
        parse_expression(text)
    assert str(caught.value).startswith(message)


@pytest.mark.parametrize(
    "text",
    [
        "(" * 400 + "a" + ")" * 400,
        "-" * 900 + "a",
        "not " * 200 + "a > b",
        "a" + "**a" * 300,
        "a" + "+a" * 400,
        "abs(" * 100 + "a" + ")" * 100,
    ],
)
def test_depth_is_limited(text: str) -> None:
    with pytest.raises(ExpressionError, match=f"nested too deeply or has too many terms in a row; at most {MAX_DEPTH}"):
        parse_expression(text)


def test_what_is_within_the_limits_is_accepted() -> None:
    assert parse_expression("(" * 50 + "1" + ")" * 50).value({}) == 1.0
    assert parse_expression("1" + " + 1" * 48).value({}) == 49.0
    assert parse_expression("abs(" * 48 + "-1" + ")" * 48).value({}) == 1.0


_pieces = st.sampled_from([*"ab1.e+-*/<>=!&|()[],'^% _é²;:", "\n", " and ", " not ", " or ", "ln(", "max(", "**"])


@given(st.lists(_pieces, max_size=25).map("".join))
def test_no_text_gives_anything_but_an_expression_or_its_error(text: str) -> None:
    outcome: object
    try:
        outcome = parse_expression(text)
    except ExpressionError as error:
        outcome = error
    assert isinstance(outcome, Expression | ExpressionError)


def test_words_do_not_collide() -> None:
    assert not FUNCTIONS.keys() & CONSTANTS.keys()
    assert {"exp", "ln", "log10", "sqrt", "abs", "min", "max", "tanh"} <= FUNCTIONS.keys()
