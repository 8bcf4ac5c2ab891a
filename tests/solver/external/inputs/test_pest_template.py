"""Templates of PEST: spaces, digits, names, mistakes."""

from __future__ import annotations

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.external.errors import InputError, TemplateError
from geoswarm.solver.external.inputs.pest_numbers import Precision, number_in_space
from geoswarm.solver.external.inputs.pest_template import parse_pest_template


@pytest.mark.parametrize(
    ("value", "width", "text"),
    [
        (20.0, 2, None),
        (20.0, 3, "20."),
        (20.0, 4, "20.0"),
        (20.0, 10, "      20.0"),
        (123456.789, 7, "123457."),
        (123456.789, 9, "123456.79"),
        (1.23456789e-5, 9, "1.2346e-5"),
        (1.23456789e-5, 23, "        0.0000123456789"),
        (-0.125, 5, "-.125"),
        (-0.125, 4, "-.12"),
        (0.99999, 3, "1.0"),
        (1.5e-300, 8, "1.5e-300"),
        (1e22, 5, "1.e22"),
        (1.23e10, 6, "12.3e9"),
        (1.234e100, 8, "12.34e99"),
        (0.0, 2, "0."),
        (-0.0, 3, "0.0"),
        (0.0, 1, None),
    ],
)
def test_as_many_digits_as_fit(value: float, width: int, text: str | None) -> None:
    if text is None:
        with pytest.raises(InputError, match=f"cannot be written in {width} characters"):
            number_in_space(value, width)
    else:
        assert number_in_space(value, width) == text


@given(st.floats(allow_nan=False, allow_infinity=False), st.integers(1, 30), st.booleans())
def test_a_number_fills_its_space_and_reads_back(value: float, width: int, point: bool) -> None:
    try:
        text = number_in_space(value, width, point=point)
    except InputError:
        assert width < 9 or abs(value) > 1.7e308
        return
    assert len(text) == width
    assert float(text) == pytest.approx(value, rel=0.5)
    assert not point or "." in text
    if width >= 24:
        assert float(text) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(("precision", "used"), [("single", 13), ("double", 23)])
def test_wide_spaces_stay_blank_on_the_left(precision: Precision, used: int) -> None:
    text = number_in_space(math.pi * 1e-7, 40, precision)
    assert len(text) == 40
    assert text[: 40 - used].isspace()
    assert len(text.strip()) in range(used - 3, used + 1)


def test_without_a_point_one_character_more_is_left() -> None:
    assert number_in_space(2e5, 3, point=False) == "2e5"
    assert number_in_space(123456.0, 6, point=False) == "123456"
    assert number_in_space(123456.0, 6) == "1.23e5"


def test_a_template_keeps_everything_else() -> None:
    text = "ptf %\r\nk = %k1        % m/s\r\n\r\n%N    %%K1    %"
    template = parse_pest_template(text, "in.tpl")
    assert template.names == {"k1", "n"}
    assert template.used(["K1", "n", "E"]) == {"K1", "n"}
    assert template.fill({"K1": 1e-4, "n": 0.35, "E": 1.0}) == "k =       0.0001 m/s\r\n\r\n   0.35  0.0001"
    assert [(space.line, space.column, space.width) for space in template.spaces] == [(2, 5, 12), (4, 1, 7), (4, 8, 8)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "line 1: '' must be ptf and the marker"),
        ("pif %\n", "must be ptf"),
        ("ptf a\n", "marker 'a' must be one character"),
        ("ptf %%\n", "must be one character"),
        ("ptf !\n", "none of"),
        ("ptf %\n%k1 \n", "line 2, column 1: 1 markers '%' in the line"),
        ("ptf %\n\n a %k% %l", "line 3, column 8: 3 markers"),
        ("ptf %\n%  %\n", "line 2, column 1: between the markers '%' there is no name"),
        ("ptf %\n%k 1%\n", "there is 'k 1'"),
    ],
)
def test_mistakes_name_their_place(text: str, message: str) -> None:
    with pytest.raises(TemplateError, match=r"in\.tpl: ") as caught:
        parse_pest_template(text, "in.tpl")
    assert message in str(caught.value)


def test_values_are_checked() -> None:
    template = parse_pest_template("ptf %\n x %k1% %kappa   %", "in.tpl")
    with pytest.raises(TemplateError, match="line 2, column 9: kappa is not a parameter; did you mean kapa"):
        template.check(["k1", "Kapa"])
    with pytest.raises(TemplateError, match="differ in case only"):
        template.check(["k1", "K1", "kappa"])
    with pytest.raises(InputError, match=r"in\.tpl: line 2, column 4: k1: -123456\.0 cannot be written in 4 "):
        template.fill({"k1": -123456.0, "kappa": 1.0})
    with pytest.raises(InputError, match="k1 is inf"):
        template.fill({"k1": math.inf, "kappa": 1.0})
