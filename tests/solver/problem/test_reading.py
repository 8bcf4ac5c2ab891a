"""Reading of YAML and JSON text."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import MAX_BYTES, load_problem, read_document
from geoswarm.solver.problem.text.reading import Form, plain_document


def test_numbers_are_those_of_yaml_1_2() -> None:
    text = "a: 1e-7\nb: [010, 1., .5, -2E3, 0x10]\nc: yes\nd: ~\ne: true\n"
    assert read_document(text, "yaml") == {
        "a": 1e-7,
        "b": [10, 1.0, 0.5, -2000.0, 16],
        "c": "yes",
        "d": None,
        "e": True,
    }


def test_anchors_are_resolved() -> None:
    text = "a: &stage {stress: 1}\nb: [*stage, *stage]\n"
    assert read_document(text, "yaml") == {"a": {"stress": 1}, "b": [{"stress": 1}, {"stress": 1}]}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("a: 1\nb:\n\tc: 1\n", "YAML syntax error in line 3, column 1: a tab; YAML is indented with spaces"),
        ("a: 1\nb:\n  c: 1\n  c: 2\n", "key 'c' is given twice, the second time in line 4, column 3"),
        ("a: [1\nb: 2\n", "YAML syntax error in line 2, column 2: expected ',' or ']', but got ':'"),
        ("\ta: 1", r"YAML syntax error in line 1, column 1: a tab; YAML is indented with spaces"),
        ("a: \x00", "YAML syntax error: unacceptable character"),
        ("a: !!python/object:os.system x", "YAML syntax error in line 1, column 4: could not determine a constructor"),
        ("a: 2001-99-99", "YAML cannot be read: month must be in"),
        ("a: 2001-01-01", "a: 2001-01-01 is a date; if text is meant, write it in quotes"),
        ("1: 2", "key 1 is a number; write it in quotes"),
        ("a: {b: {3: 1}}", "a.b: key 3 is a number"),
        ("- 1", "a problem is a mapping .*, but this is a list"),
        ("", "a problem is a mapping .*, but this is empty"),
        ("a: &x [*x]", r"what starts in line 1, column 4 contains itself by an alias \(\*\)"),
        ("a: &x {b: {<<: *x}}", "what starts in line 1, column 4 contains itself"),
        ("a: " + ("[" * 200 + "]" * 200 + "\n") * 500, "nested more than 30 levels deep"),
        ("[" * 5000, "nested more than 30 levels deep"),
        ("a: 1" + "0" * 400, "a: number is too large"),
        ('a: "\\ud800"', "a: text holds half a Unicode character"),
        ("a: 1\n---\nb: 1", "YAML syntax error in line 2, column 1: but found another document"),
    ],
)
def test_yaml_that_cannot_be_used(text: str, message: str) -> None:
    with pytest.raises(ProblemError, match=message) as caught:
        read_document(text, "yaml")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ('{"a": {"b": 1, "c": 2, "b": 3}}', "key 'b' is given twice, the second time in line 1, column 24"),
        (
            '{"a": [{"b": 1},\n {"b": "}", "c": "b"}],\n "\\u0061": 2}',
            "key 'a' is given twice, the second time in line 3, column 2",
        ),
        ('{"a": 1,\n}', "JSON syntax error in line 1, column 8|JSON syntax error in line 2, column 1"),
        ("[1]", "a problem is a mapping"),
        ('{"a":' * 100_000, "nested more than 30 levels deep"),
        ('{"a": ' + "9" * 5000 + "}", "JSON cannot be read"),
    ],
)
def test_json_that_cannot_be_used(text: str, message: str) -> None:
    with pytest.raises(ProblemError, match=message):
        read_document(text, "json")


@pytest.mark.parametrize(
    ("first", "level"),
    [("[1, 1, 1, 1, 1, 1, 1, 1, 1, 1]", "[{}]"), ("{k: 1}", "{{<<: [{}]}}"), ("[1, 1]", "[{{a: [{}]}}]")],
)
def test_what_aliases_repeat_is_counted_before_it_is_built(first: str, level: str) -> None:
    lines = [f"a0: &a0 {first}"]
    lines += [f"a{i}: &a{i} {level.format(', '.join([f'*a{i - 1}'] * 10))}" for i in range(1, 21)]
    with pytest.raises(ProblemError, match=r"aliases and merge keys \(\*name, <<\) repeat more than 100000 values"):
        read_document("\n".join(lines), "yaml")  # to build all 10^20 would take for ever


def test_merge_keys_are_resolved() -> None:
    text = "a: &a {b: 1, c: 2}\nd: {<<: *a, c: 3}\ne: [*a, *a]\n"
    repeated = {"b": 1, "c": 2}
    assert read_document(text, "yaml") == {"a": repeated, "d": {"b": 1, "c": 3}, "e": [repeated, repeated]}


def test_keys_of_a_mapping_are_limited() -> None:
    with pytest.raises(ProblemError, match=r"^a\[0\].b: has 10001 keys; at most 10000 are accepted"):
        plain_document({"a": [{"b": dict.fromkeys(map(str, range(10_001)))}]})


def test_size_is_limited(tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match=f"larger than {MAX_BYTES['yaml']} bytes"):
        read_document("#" * (MAX_BYTES["yaml"] + 1), "yaml")
    path = tmp_path / "large.yaml"
    path.write_text("#" * (MAX_BYTES["yaml"] + 1), encoding="utf-8")
    with pytest.raises(ProblemError, match=f"larger than {MAX_BYTES['yaml']} bytes"):
        load_problem(path)


def test_text_must_be_utf_8(tmp_path: Path) -> None:
    path = tmp_path / "latin.yaml"
    path.write_bytes(b"name: Corvar\xe0\n")
    with pytest.raises(ProblemError, match=r"not UTF-8 text: .* at byte 12"):
        load_problem(path)


def test_numpy_values_become_plain_ones() -> None:
    document = plain_document({"a": np.array([1.0, 2.0]), "b": (np.float64(3), np.int64(4), np.bool_(True))})
    assert document == {"a": [1.0, 2.0], "b": [3.0, 4, True]}
    assert [type(value) for value in document["b"]] == [float, int, bool]
    with pytest.raises(ProblemError, match=r"a\[0\]: b'x' is a bytes"):
        plain_document({"a": [b"x"]})


@given(st.text(alphabet=st.sampled_from(list("ab:{}[],-&*!|>'\"%@`#?~ \n\t01.e\\<=é\x07")), max_size=60))
def test_no_text_gives_anything_but_a_document_or_a_problem_error(text: str) -> None:
    for form in ("yaml", "json"):
        outcome: object
        try:
            outcome = read_document(text, form)  # type: ignore[arg-type]
        except ProblemError as error:
            outcome = error
        assert isinstance(outcome, dict | ProblemError)


@pytest.mark.parametrize("form", ["yaml", "json"])
def test_a_number_with_thousands_of_digits_is_told_in_words(form: Form) -> None:
    with pytest.raises(ProblemError, match=r"it has a number with thousands of digits$"):
        read_document('{"seed": ' + "1" * 5000 + "}", form)


def test_a_pipe_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "problem.yaml")
    with pytest.raises(ProblemError, match="a pipe, not a file"):
        load_problem(tmp_path / "problem.yaml")
