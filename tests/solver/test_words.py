"""Numbers as a reader sees them: printed in reports, plain in a terminal."""

from __future__ import annotations

import pytest

from geoswarm.cli.words import output
from geoswarm.solver.words import duration, ends, number, per_cent, reasons_in_words, typeset, visible


@pytest.mark.parametrize(
    ("value", "printed", "plain"),
    [
        (None, "–", "-"),
        (4.8329e-9, "4.833·10⁻⁹", "4.833e-9"),
        (1e-7, "10⁻⁷", "1e-7"),
        (-2.5, "−2.5", "-2.5"),
        (123456.0, "123500", "123500"),
        (1.5e12, "1.5·10¹²", "1.5e12"),
        (42, "42", "42"),
    ],
)
def test_a_number_is_printed_or_plain(value: float | None, printed: str, plain: str) -> None:
    assert number(value) == printed
    assert number(value, plain=True) == plain
    assert output.number(value) == plain


@pytest.mark.parametrize(
    ("low", "high", "printed"),
    [
        (2.3, 9.1, ("2.3", "9.1")),
        (2.34512, 2.34518, ("2.34512", "2.34518")),
        (0.0116, 0.0174, ("0.0116", "0.0174")),
        (-1e-9, 1e-9, ("-1e-9", "1e-9")),
        (1e5, 1e5 + 0.5, ("100000", "100000.5")),
        (3.0, 3.0, ("3", "3")),
    ],
)
def test_the_ends_of_an_interval_differ(low: float, high: float, printed: tuple[str, str]) -> None:
    assert ends(low, high, plain=True) == printed


def test_a_narrow_interval_shows_a_value_between_its_ends() -> None:
    value, half = 2.298765, 3e-7
    low, high = (float(text) for text in ends(value - half, value + half, plain=True))
    assert low < value < high
    assert high - low == pytest.approx(2 * half, rel=0.1)


@pytest.mark.parametrize(
    ("part", "printed"),
    [(0.34, "34 %"), (0.021, "2.1 %"), (0.00004, "0.004 %"), (3e-10, "less than 0.000001 %"), (0.0, "0 %")],
)
def test_a_share_never_reads_zero_unless_it_is(part: float, printed: str) -> None:
    assert per_cent(part) == printed


def test_the_terminal_uses_the_same_words() -> None:
    assert output.duration(125.0) == duration(125.0) == "2 min 05 s"
    assert (output.duration(None), duration(None)) == ("-", "–")
    assert output.reasons_in_words(["design_completed"]) == reasons_in_words(["design_completed"])


def test_sentences_are_typeset() -> None:
    assert typeset("f <= 5.23e-08, from 1e-09: 95 % of 3e2") == "f <= 5.23·10⁻⁸, from 10⁻⁹: 95\xa0% of 3e2"
    assert typeset("parameter_1e-5 stays") == "parameter_1e-5 stays"


def test_control_characters_are_escaped() -> None:
    assert visible("a\x1b[31m\r\n\tb\u202e\x85") == "a\\x1b[31m\\r\\n\\tb\\u202e\\x85"
    assert visible("a\u061cb", lines=True) == "a\\u061cb"
    assert visible("a\n\tb\x07", lines=True) == "a\n\tb\\x07"
    assert visible(visible("a\x1b")) == visible("a\x1b")
    assert visible("λ* = 0.12 °C · 日本") == "λ* = 0.12 °C · 日本"
