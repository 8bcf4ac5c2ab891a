"""JSON by path."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from geoswarm.solver.external.outputs.json_paths import parse_json_path
from tests.solver.external.outputs.reading import assert_bad, series

DOCUMENT = {
    "results": {"time": [0, 1.5], "top uy": [1, 2]},
    "steps": [{"t": 0.0, "u": [1.0, 3.0]}, {"t": 1.5, "u": [2.0, 4.0]}],
    "last": 7,
    "word": "a",
    "flag": True,
    "nothing": None,
    "bad": [1.0, float("nan")],
}
FILE = {"file": "out.json"}


@pytest.mark.parametrize(
    ("x", "y", "points"),
    [
        ("results.time", "steps[*].u[0]", [(0.0, 1.0), (1.5, 2.0)]),
        ("steps[*].t", 'results["top uy"]', [(0.0, 1.0), (1.5, 2.0)]),
        ("steps[0].u", "steps[-1].u", [(1.0, 2.0), (3.0, 4.0)]),
        ("last", "results.time[1]", [(7.0, 1.5)]),
        ("steps[*].u", "steps[*].u", [(1.0, 1.0), (3.0, 3.0), (2.0, 2.0), (4.0, 4.0)]),
    ],
)
def test_paths(tmp_path: Path, x: str, y: str, points: list[tuple[float, float]]) -> None:
    assert series(tmp_path, json.dumps(DOCUMENT), **FILE, x=x, y=y) == points
    assert series(tmp_path, json.dumps(DOCUMENT), file="out.txt", format="json", x=x, y=y) == points


@pytest.mark.parametrize(
    ("path", "message"),
    [
        ("result.time", "the document has no key result; its keys: results, steps"),
        ("results.time.t", "results.time is a list of 2; a mapping with the key t is expected"),
        ("steps[2].t", "steps has 2 entries; [2] does not exist"),
        ("last[0]", "last is 7; a list is expected"),
        ("word", "word is the text 'a'; a number is expected"),
        ("flag", "flag is true; a number is expected"),
        ("nothing", "nothing is null; a number is expected"),
        ("steps", "steps[0] is a mapping with the keys t, u; a number is expected"),
        ("results.time", "last has 1 numbers and results.time has 2; as many of both are expected"),
    ],
)
def test_mistakes_name_the_place(tmp_path: Path, path: str, message: str) -> None:
    assert_bad(tmp_path, json.dumps(DOCUMENT), f"out.json: {message}", **FILE, x="last", y=path)


def test_what_is_no_json(tmp_path: Path) -> None:
    paths = {"x": "a", "y": "b"}
    assert_bad(tmp_path, '{"a": [1, 2],\n "b": [3', "line 2: Expecting ',' delimiter", **FILE, **paths)
    assert_bad(tmp_path, '{"a": [1, 2],\n "b": [3', "the file may be truncated", **FILE, **paths)
    assert_bad(tmp_path, "a,b\n", "line 1: Expecting value", **FILE, **paths)
    assert_bad(tmp_path, "[" * 100_000, "cannot be read as JSON", **FILE, **paths)
    assert_bad(tmp_path, b'{"a": "\xff"}', "found the byte ff at position 8", **FILE, **paths)
    assert_bad(tmp_path, '{"a": 1, "b": 1' + "0" * 400 + "}", "b is larger than any number", **FILE, **paths)
    assert_bad(tmp_path, json.dumps(DOCUMENT), "y = nan is not finite", **FILE, x="results.time", y="bad")
    assert series(tmp_path, '\ufeff{"a": 1, "b": 2}', **FILE, **paths) == [(1.0, 2.0)]
    assert series(tmp_path, '{"a": 1, "b": 2}'.encode("utf-16"), **FILE, **paths) == [(1.0, 2.0)]


@pytest.mark.parametrize("text", ["", ".a", "a..b", "a[", "a[1.5]", "a b", "a[**]", "a.", "[0]a"])
def test_paths_that_are_none(text: str) -> None:
    with pytest.raises(ValueError, match=r"is not a path at character|path is empty"):
        parse_json_path(text)
