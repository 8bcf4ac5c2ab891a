"""Numbers as a reader sees them: printed in reports, plain in a terminal."""

from __future__ import annotations

import pytest

from geoswarm.cli import output
from geoswarm.solver.words import duration, number, reasons_in_words, typeset


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


def test_the_terminal_uses_the_same_words() -> None:
    assert output.duration(125.0) == duration(125.0) == "2 min 05 s"
    assert (output.duration(None), duration(None)) == ("-", "–")
    assert output.reasons_in_words(["design_completed"]) == reasons_in_words(["design_completed"])


def test_sentences_are_typeset() -> None:
    assert typeset("f <= 5.23e-08, raised from 1e-09: 95% of 3e2") == "f <= 5.23·10⁻⁸, raised from 10⁻⁹: 95\xa0% of 3e2"
    assert typeset("parameter_1e-5 stays") == "parameter_1e-5 stays"
