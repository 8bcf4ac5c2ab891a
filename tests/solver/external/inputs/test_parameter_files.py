"""Files of parameters: what others read of them is what was written."""

from __future__ import annotations

import csv
import json
import math
from io import StringIO

import pytest
from hypothesis import given
from hypothesis import strategies as st
from ruamel.yaml import YAML

from geoswarm.solver.external.errors import InputError
from geoswarm.solver.external.inputs.parameter_files import parameter_text

NAMES = st.text(st.characters(min_codepoint=32, max_codepoint=0x2FF, exclude_categories=["Cs", "Cc"]), min_size=1)
VALUES = st.dictionaries(NAMES, st.floats(allow_nan=False, allow_infinity=False), max_size=5)


@given(VALUES)
def test_json_reads_back(values: dict[str, float]) -> None:
    assert json.loads(parameter_text("json", values)) == values


@given(VALUES)
def test_yaml_reads_back(values: dict[str, float]) -> None:
    assert YAML(typ="safe", pure=True).load(parameter_text("yaml", values)) == values


@given(VALUES)
def test_csv_reads_back(values: dict[str, float]) -> None:
    heading, *rows = csv.reader(StringIO(parameter_text("csv", values)))
    assert heading == ["name", "value"]
    assert {name: float(value) for name, value in rows} == values


def test_files_look_as_documented() -> None:
    values = {"E": 2e4, "y": 1e-9, "oedometer.c": 0.1, "slot": 2}
    assert parameter_text("yaml", values) == 'E: 20000.0\n"y": 1.0e-09\noedometer.c: 0.1\nslot: 2\n'
    assert parameter_text("csv", values) == "name,value\nE,20000.0\ny,1.0e-09\noedometer.c,0.1\nslot,2\n"
    assert parameter_text("json", {"E": 2e4, "n": 0.5}) == '{\n  "E": 20000.0,\n  "n": 0.5\n}\n'


def test_only_finite_numbers_are_written() -> None:
    with pytest.raises(InputError, match="parameter E is nan"):
        parameter_text("json", {"E": math.nan})
