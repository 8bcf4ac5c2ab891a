"""Sections of series: which reader they ask for, and what is said about mistakes in them."""

from __future__ import annotations

import pickle
from typing import Any

import pytest
from pydantic import BaseModel, TypeAdapter, ValidationError

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.external.errors import InputError, OutputError, TemplateError
from geoswarm.solver.external.outputs.series import READERS, SeriesReader, format_of
from geoswarm.solver.forward.programs.command import CommandSpec
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.problem.issues import issues_of
from tests.solver.external.outputs.reading import reader_of

SECTIONS: dict[str, dict[str, Any]] = {
    "table": {"file": "a.csv", "x": 1, "y": "-column4"},
    "search": {"file": "a.log", "find": "(?P<x>.) (?P<y>.)"},
    "pest": {"file": "a.out", "instructions": "a.ins", "observations": {"h": 1}},
    "json": {"file": "a.JSON", "x": "t", "y": "u[*].y"},
    "numpy": {"file": "a.npz", "x": "t", "y": "u"},
    "hdf5": {"file": "a.h5", "x": "t", "y": "u[*, 0]"},
    "mesh": {"file": "a.pvd", "point": [12, 0.0], "field": "u", "component": "y"},
}


class Problem(BaseModel):
    """A document that holds series."""

    series: dict[str, SeriesReader]


@pytest.mark.parametrize("name", READERS)
def test_fields_tell_the_reader(name: str) -> None:
    section = SECTIONS[name] | {"x_unit": "day", "y_unit": "m"}
    reader = reader_of(section)
    assert type(reader) is READERS[name]
    assert format_of(reader) == format_of(section) == name
    assert (reader.files, reader.x_unit, reader.y_unit) == ((section["file"],), "day", "m")
    assert reader_of(reader.model_dump(mode="json")) == reader
    assert pickle.loads(pickle.dumps(reader)) == reader  # noqa: S301  made here
    with_format = section | {"format": name}
    assert reader_of(with_format) == reader


def test_the_union_is_a_field_with_a_schema() -> None:
    problem = Problem.model_validate({"series": SECTIONS})
    assert [type(reader) for reader in problem.series.values()] == [READERS[name] for name in SECTIONS]
    assert Problem.model_validate_json(problem.model_dump_json(), strict=True) == problem
    schema = TypeAdapter(SeriesReader).json_schema()
    assert len(schema["oneOf"]) == len(READERS)


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("table", {"colums": [[1, 2]]}, "series.s: unknown key colums; did you mean columns?; a table (file, x and y)"),
        ("table", {"x": None}, "series.s.x: must be a whole number, got null\nseries.s.x: must be text, got null"),
        ("table", {"x": 0}, "series.s.x: column 0 does not exist; columns count from 1"),
        ("table", {"x": " "}, "series.s.x: is empty"),
        ("table", {"x": True}, "series.s.x: must be a whole number, got true\nseries.s.x: must be text, got true"),
        ("table", {"file": "/etc/passwd"}, "series.s.file: '/etc/passwd' must be relative to the folder of the run"),
        ("table", {"file": "C:/a.csv"}, "must be relative"),
        ("table", {"file": "../a.csv"}, "must stay in the folder of the run; .. is not accepted"),
        ("table", {"file": "a/../../a.csv"}, "must stay in the folder"),
        ("table", {"file": "a\\b.csv"}, "write / between folders"),
        ("table", {"file": ""}, "names no file"),
        ("table", {"file": "a/"}, "names no file"),
        ("table", {"file": "a\nb"}, "control characters"),
        ("table", {"columns": [[5, 4]]}, "column [5, 4] ends before it begins"),
        ("table", {"columns": [[1, 4]], "separator": ","}, "give one of them"),
        ("table", {"decimal": ",", "separator": ","}, "both a comma"),
        ("table", {"row": 5}, "row counts lines after a heading; give each"),
        ("table", {"each": "(", "row": 5}, "'(' is not a regular expression"),
        ("table", {"each": "a" * 1001}, "series.s.each: may have at most 1000 characters"),
        ("table", {"each": "t (?P<time>.)", "x": "tim"}, "x: no column tim; did you mean time?; there are time, row"),
        ("table", {"each": "a", "where": "node == 5"}, "where: no column node"),
        ("table", {"each": "a", "row": 1, "where": "column1 == 5"}, "row and where both choose"),
        ("table", {"each": "a", "header": 1}, "header is for a single table"),
        ("table", {"where": "column1 + 5"}, "must be a comparison"),
        ("table", {"rows": 0}, "series.s.rows: must be at least 1, got 0"),
        ("table", {"columns": [[1, "a"]]}, "series.s.columns[0][1]: must be a whole number, got text 'a'"),
        ("table", {"comment": [""]}, "a comment begins with a sign"),
        ("table", {"encoding": "utf-7"}, "series.s.encoding: must be 'utf-8', 'latin-1', 'cp1252' or"),
        ("table", {"format": "excel"}, "format must be one of table, search, pest"),
        ("search", {"find": "(?P<x>.)"}, "find has no group (?P<y>...); its named groups: x"),
        ("search", {"find": "(?P<foss>.)", "observations": {"fos": 1}}, "find has no group (?P<fos>...); did you mean"),
        ("search", {"find": ["(?P<a>.)", "(?P<a>.)"], "observations": {"a": 1}}, "group a is in several"),
        ("search", {"find": []}, "find is empty"),
        ("search", {"take": "last"}, "are for observations"),
        ("pest", {"observations": None}, "series.s.observations: must be a mapping, got null"),
        ("pest", {"instructions": "../a.ins"}, "must stay in the folder"),
        ("pest", {"instructions": "pif $\nl1 !h\n"}, "instructions: line 2, column 4: '!h' is not closed"),
        ("json", {"y": "u[x]"}, "series.s.y: 'u[x]' is not a path at character 2"),
        ("hdf5", {"y": "u[1, 2]"}, "one * and otherwise whole numbers are expected"),
        ("mesh", {"points": [[0, 0]]}, "give either point"),
        ("mesh", {"point": [1]}, "series.s.point: needs at least 2 entries"),
        ("mesh", {"time": 1.0}, "time and along are for points"),
        ("mesh", {"point": None, "points": [[0, 0], [0, 0, 0]]}, "or all of them three"),
        ("mesh", {"point": None, "points": [[0, 0]], "along": "z"}, "needs points with three coordinates"),
        ("mesh", {"file": "a.csv"}, "must be named .pvd, .vtu"),
        (
            "mesh",
            {"component": "magnitud"},
            "component: must be 'x', 'y', 'z' or 'magnitude', got text 'magnitud'; did you mean magnitude?",
        ),
    ],
)
def test_mistakes_name_the_key(name: str, change: dict[str, Any], message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        reader_of(SECTIONS[name] | change)
    assert message in str(caught.value)


def test_what_is_missing_is_named() -> None:
    with pytest.raises(ProblemError, match=r"^series\.s\.y: is missing$"):
        reader_of({"file": "a.csv", "x": 1})
    with pytest.raises(ProblemError, match=r"series\.s: must be a mapping"):
        reader_of("a.csv")


def test_a_missing_key_with_the_name_of_its_series_has_a_path_of_its_own() -> None:
    section = {"kind": "command", "run": ["x"], "series": {"y": {"file": "a.csv", "x": 1}}}
    with pytest.raises(ValidationError) as caught:
        parse_spec(section)
    found = issues_of(caught.value, section, "forward_model", CommandSpec.model_json_schema)
    assert [str(issue) for issue in found] == ["forward_model.series.y.y: is missing"]


def test_errors_survive_the_way_between_processes() -> None:
    for error in (OutputError("no_output", "a"), TemplateError("a", "f", 1, 2), InputError("a")):
        again = pickle.loads(pickle.dumps(error))  # noqa: S301  made here
        assert type(again) is type(error)
        assert (str(again), vars(again)) == (str(error), vars(error))
