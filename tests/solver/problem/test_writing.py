"""Problems written as YAML are read again as the same problems."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as some

from geoswarm.solver.examples import example_file, example_names
from geoswarm.solver.problem import load_problem, parse_problem, problem_yaml, read_document

WORDS = some.text(" abcxyeno01:#-+{}[],'\"&*!|>%@`~?\\/.=<\n\tµ\x9c\u00ad\u2028\ufeff\U0001f600\U000e0001", max_size=6)
SCALARS = some.none() | some.booleans() | some.integers(-(2**70), 2**70) | some.floats(allow_nan=False) | WORDS
VALUES = some.recursive(
    SCALARS, lambda inner: some.lists(inner, max_size=4) | some.dictionaries(WORDS, inner, max_size=4)
)


@pytest.mark.parametrize("name", example_names(engines=False))
def test_examples_survive_being_written(name: str) -> None:
    with example_file(name) as path:
        document = load_problem(path).document()
    text = problem_yaml(document)
    assert read_document(text, "yaml") == document
    assert parse_problem(read_document(text, "yaml")).document() == document
    assert max(map(len, text.splitlines())) <= 110


@settings(deadline=None, max_examples=40)
@given(some.dictionaries(WORDS, VALUES, max_size=5))
def test_any_document_survives_being_written(document: dict[str, Any]) -> None:
    assert read_document(problem_yaml(document), "yaml") == document


@pytest.mark.parametrize("length", [90, 120, 2000])
@pytest.mark.parametrize("value", [1.5, [], {}, [0.1] * 40, {"a": {"b": [{"c": 1}]}}])
def test_long_keys_are_keys_too(length: int, value: Any) -> None:
    document = {"\U000f0000" * length: value, "list": [{"k" * length: value}, {"\x85" * length: [value]}]}
    assert read_document(problem_yaml(document), "yaml") == document


def test_it_reads_as_one_would_write_it() -> None:
    document = {
        "name": "a: b",
        "parameters": {"c": {"lower": 1e-05, "upper": 100.0}, "y": {"value": 3.0}},
        "constraints": ["c > 0.5"],
        "stages": [{"stress": 9.0, "duration": 2}],
        "observations": [{"series": "settlement", "points": {"x": [0.1] * 30, "y": []}}],
    }
    assert problem_yaml(document) == (
        'name: "a: b"\n'
        "parameters:\n"
        "  c: {lower: 1e-05, upper: 100}\n"
        "  y: {value: 3}\n"
        "constraints: [c > 0.5]\n"
        "stages:\n"
        "  - {stress: 9, duration: 2}\n"
        "observations:\n"
        "  - series: settlement\n"
        "    points:\n"
        f"      x: [{', '.join(['0.1'] * 18)},\n"
        f"        {', '.join(['0.1'] * 12)}]\n"
        "      y: []\n"
    )
