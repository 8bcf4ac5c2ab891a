"""Our templates: placeholders, formats, braces, and what is said about mistakes."""

from __future__ import annotations

import math
import struct
import time
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.external.errors import InputError, TemplateError
from geoswarm.solver.external.inputs.template import parse_template
from geoswarm.solver.external.inputs.texts import number_text, read_template_file, write_input_file


def filled(text: str, **values: float) -> str:
    return parse_template(text, "deck.in").fill(values)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("E={{E}}", "E=20000.0"),
        ("{{ E }},{{nu}}", "20000.0,0.3"),
        ("{{k}}", "1.0e-09"),
        ("{{2 * G * (1 + nu)}}", "26.0"),
        ("{{nu:%.6e}}", "3.000000e-01"),
        ("|{{nu:%10.3f}}|{{nu:%-8.2f}}|{{nu:%08.3f}}|", "|     0.300|0.30    |0000.300|"),
        ("{{E:%d}} {{E:%8d}} {{E:%g}} {{k:%G}}", "20000    20000 20000 1E-09"),
        ("|{{E:%10s}}|{{E:%-10s}}|", "|   20000.0|20000.0   |"),
        ("port {{4000 + slot}} {{slot}} {{slot:%03d}} {{slot / 2}}", "port 4003 3 003 1.5"),
        ("{{E}}\r\n{{nu}}\r\n", "20000.0\r\n0.3\r\n"),
        ("", ""),
        ("no placeholder", "no placeholder"),
    ],
)
def test_placeholders_are_filled(text: str, expected: str) -> None:
    assert filled(text, E=2e4, nu=0.3, G=10.0, k=1e-9, slot=3) == expected


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("{x} }} {", "{x} }} {"),
        ("{{{{", "{{"),
        ("{{{{ E }}", "{{ E }}"),
        ("{{{E}}}", "{1.0}"),
        ("{{{{{", "{{{"),
        ("{{{{{{E}}", "{{1.0"),
        ("{{{{{{{E}}", "{{{1.0"),
        ("{{{{{{{{", "{{{{"),
        ('{"a": {{E}}}', '{"a": 1.0}'),
    ],
)
def test_braces_can_be_written(text: str, expected: str) -> None:
    assert filled(text, E=1.0) == expected


@given(st.floats(allow_nan=False, allow_infinity=False))
def test_numbers_read_back_to_the_same_bits(value: float) -> None:
    text = number_text(value)
    assert struct.pack("<d", float(text)) == struct.pack("<d", value)
    assert "." in text
    assert len(text.partition("e")[0].replace(".", "").strip("-0")) <= 17


def test_names_are_the_parameters_used() -> None:
    template = parse_template("{{E * (1 + nu)}} {{slot}} {{oedometer.E:%g}}", "deck.in")
    assert template.names == {"E", "nu", "oedometer.E"}
    assert template.used(["E", "c", "slot"]) == {"E"}
    assert [(one.line, one.column) for one in template.placeholders] == [(1, 1), (1, 18), (1, 27)]


@pytest.mark.parametrize(
    ("text", "where", "message"),
    [
        ("a\nb {{E", "line 2, column 3", "'{{E' is not closed"),
        ("{{E\n}}", "line 1, column 1", "is not closed"),
        ("{{E {{nu}}", "line 1, column 1", "is not closed"),
        ("{{}}", "line 1, column 1", "placeholder is empty"),
        ("x {{E +}}", "line 1, column 3", "expression ends"),
        ("{{E > 1}}", "line 1, column 1", "comparison"),
        ("{{E:%5q}}", "line 1, column 1", "accepted are %e, %f, %g, %d and %s"),
        ("{{E:}}", "line 1, column 1", "format '' is not supported"),
        ("{{E:%.3d}}", "line 1, column 1", "takes a width, but no digits"),
        ("{{E:%1000f}}", "line 1, column 1", "is not supported"),
        ("{{" + "E" * 2000 + "}}", "line 1, column 1", "longer than"),
        ("{{__import__('os')}}", "line 1, column 1", "unexpected"),
    ],
)
def test_mistakes_name_their_place(text: str, where: str, message: str) -> None:
    with pytest.raises(TemplateError) as caught:
        parse_template(text, "deck.in")
    assert str(caught.value).startswith(f"deck.in: {where}: ")
    assert message in str(caught.value)


def test_an_unknown_name_is_a_mistake_with_a_suggestion() -> None:
    template = parse_template("a\n b {{lamda_star}}", "deck.in")
    with pytest.raises(TemplateError, match=r"line 2, column 4: lamda_star is not a parameter; did you mean lambda"):
        template.check(["lambda_star", "c"])
    with pytest.raises(TemplateError, match="lamda_star is not a parameter"):
        template.fill({"lambda_star": 0.1})
    with pytest.raises(TemplateError, match="slot has no value"):
        parse_template("{{slot}}", "deck.in").fill({"E": 1.0})


@pytest.mark.parametrize(
    ("text", "value", "message"),
    [
        ("{{E:%5.3f}}", 12345.0, r"'12345.000' has 9 characters, but %5.3f has room for 5"),
        ("{{E:%4s}}", 12345.0, "has room for 4"),
        ("{{E:%d}}", 1.5, "1.5 is not whole"),
        ("{{1 / E}}", 0.0, "1 / E is inf; only finite numbers"),
        ("{{E}}", math.nan, "E is nan"),
    ],
)
def test_values_that_cannot_be_written_name_their_place(text: str, value: float, message: str) -> None:
    with pytest.raises(InputError, match=r"deck\.in: line 2, column 1: ") as caught:
        filled("\n" + text, E=value)
    assert message in str(caught.value)


@pytest.mark.parametrize("piece", ["{{E}} ", "{", "{{{{ ", "}", "{{E}}\n"])
def test_long_files_take_time_in_proportion(piece: str) -> None:
    def seconds(times: int) -> float:
        """Least processor time of a few."""
        spent = []
        for _ in range(3):
            began = time.process_time()
            parse_template(piece * times + " ", "deck.in")
            spent.append(time.process_time() - began)
        return min(spent)

    seconds(100)
    # 16 times the text; if each piece looked at all others, 256 times the time.
    assert seconds(16_000) < 64.0 * max(seconds(1_000), 0.001)


def test_files_keep_every_other_byte(tmp_path: Path) -> None:
    content = "Höhe {{E}}\r\n".encode("latin-1") + b"\xff\x00\n"
    (tmp_path / "deck.in").write_bytes(content)
    text = parse_template(read_template_file(tmp_path / "deck.in"), "deck.in").fill({"E": 1.0})
    write_input_file(tmp_path / "deck", text)
    assert (tmp_path / "deck").read_bytes() == content.replace(b"{{E}}", b"1.0")
    with pytest.raises(TemplateError, match="cannot be read"):
        read_template_file(tmp_path / "missing.in")
    with pytest.raises(TemplateError, match="not a regular file"):
        read_template_file(tmp_path)
