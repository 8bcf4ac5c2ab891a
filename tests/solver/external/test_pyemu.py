"""Files of PEST are read and written like pyEMU 1.7.0 does it (pyemu_cases.json, made by compare_with_pyemu.py)."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.external.inputs.pest_template import parse_pest_template
from geoswarm.solver.external.outputs.pest.follow import follow
from geoswarm.solver.external.outputs.pest.instructions import parse_instructions

CASES: dict[str, Any] = json.loads(Path(__file__).with_name("pyemu_cases.json").read_text(encoding="utf-8"))

# What pyEMU refuses, or reads otherwise than PEST's manual has it, with what we read.
OTHERWISE = {
    "tab": {"h1": 12.3456},
    "continuation": {"n1": 1.0, "x1": 10.0, "h1": 12.3456},
    "semi-fixed, inside a number": {"h1": 12.3456},
}


def lines() -> list[tuple[int, str]]:
    return list(enumerate(CASES["listing"].split("\n"), start=1))


@pytest.mark.parametrize("case", CASES["read"])
def test_instructions_read_what_pyemu_reads(case: str) -> None:
    instructions = parse_instructions(CASES["read"][case]["instructions"], "case.ins")
    values = {name: value.number for name, value in follow(instructions, iter(lines()), "case.out").items()}
    assert values == OTHERWISE.get(case, CASES["read"][case]["values"])


def test_differences_from_pyemu_are_these_alone() -> None:
    refused = {case for case, found in CASES["read"].items() if found["values"] is None}
    assert refused == {"tab", "continuation"}
    assert CASES["read"]["semi-fixed, inside a number"]["values"] == {"h1": 234560.0}  # it reads from the column on


@pytest.mark.parametrize("case", CASES["written"])
def test_templates_have_the_layout_of_pyemu_and_more_digits(case: str) -> None:
    template, values, theirs = (CASES["written"][case][key] for key in ("template", "values", "text"))
    ours = parse_pest_template(template, "case.tpl").fill(values)
    assert [len(line) for line in ours.splitlines()] == [len(line) for line in theirs.splitlines()]
    assert len(ours.split()) == len(theirs.split())
    for mine, other in zip(ours.split(), theirs.split(), strict=True):
        try:
            number = float(mine)
        except ValueError:
            assert mine == other
            continue
        assert number == pytest.approx(float(other), rel=5e-4)
        assert number in values.values()  # exactly: the spaces are wide enough
