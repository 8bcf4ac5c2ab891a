"""Stages of a test from a column of loads, each constant over the readings of its stage."""

from __future__ import annotations

import json
from typing import Any

import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import measured_stages

HEAD = "Zeit [min];Spannung [MPa];Setzung [mm]\n"
READ_BEFORE = HEAD + "0;0,0125;0\n60;0,0125;0,1\n1440;0,0125;0,2\n1440,1;0,025;0,3\n1440,5;0,025;0,4\n4320;0,025;0,5\n"
READ_AFTER = HEAD + "0;0,0125;0\n60;0,0125;0,1\n1400;0,0125;0,2\n1440;0,025;0,2\n1440,5;0,025;0,4\n4320;0,025;0,5\n"
ANEW = HEAD + "0;0,0125;0\n60;0,0125;0,1\n1440;0,0125;0,2\n0;0,025;0,2\n60;0,025;0,4\n2880;0,025;0,5\n"
SEATED = HEAD + "0;0,005;0\n0,1;0,0125;0\n60;0,0125;0,1\n1440;0,0125;0,2\n1440,1;0,025;0,3\n4320;0,025;0,5\n"


def stages(text: str, column: str = "Spannung", unit: str | None = None, **keys: Any) -> tuple[Any, ...]:
    found = measured_stages(json.dumps({"x_column": "Zeit", **keys}), text.encode(), "a.csv", column, unit)
    return [(one.stress, one.duration) for one in found.stages], found.initial_stress, found.elapsed


@pytest.mark.parametrize(
    ("text", "initial", "elapsed"),
    [(READ_BEFORE, None, False), (READ_AFTER, None, False), (ANEW, None, True), (SEATED, 5.0, False)],
)
def test_stages_have_the_units_of_the_file(text: str, initial: float | None, elapsed: bool) -> None:
    assert stages(text) == ([(12.5, 1.0), (25.0, 2.0)], initial, elapsed)


@pytest.mark.parametrize(
    ("text", "keys", "path", "message"),
    [
        (READ_BEFORE.replace("[MPa]", ""), {}, "load_column", "has no unit; give load_unit: kPa, MPa or kg/cm2"),
        (READ_BEFORE.replace("[MPa]", "[mm]"), {}, "load_column", "column 'Spannung [mm]' is in mm"),
        (READ_BEFORE.replace("[min]", ""), {}, "x_column", "give x_unit"),
        (
            READ_BEFORE,
            {"column": "Setzung", "unit": "kPa"},
            "load_column",
            "loads are constant over the readings",
        ),
        (READ_BEFORE.replace("\n60;", "\n2000;"), {}, "load_column", "x falls from one reading to the next"),
        (READ_BEFORE, {"column": "Last"}, "", "there is no column 'Last'"),
    ],
)
def test_what_is_no_column_of_loads(text: str, keys: dict[str, Any], path: str, message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        stages(text, **keys)
    assert (caught.value.issues[0].path, message in str(caught.value)) == (path, True), str(caught.value)
