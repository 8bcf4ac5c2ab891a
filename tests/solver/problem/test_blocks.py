"""One observation from several blocks of a file: stages side by side, on sheets of their own, one below the other."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import load_problem, measured_points
from tests.solver.problem.test_laboratory_files import sheet_rows
from tests.solver.problem.test_measurements import workbook
from tests.solver.problem.test_selection import staged

SIDE = b"""load 10 kPa;;;load 20 kPa;
t [min];s [mm];;t [min];s [mm]
0;0;;0;0.3
60;0.2;;30;0.5
1440;0.3;;720;0.6
;;;1440;0.7
"""
IN_TURN = [
    {"x_column": "A:A", "y_column": "B:B", "stage": 1},
    {"x_column": "D:D", "y_column": "E:E", "stage": 2},
]
X, Y = [0, 60, 1440, 1470, 2160, 2880], [0, 0.2, 0.3, 0.5, 0.6, 0.7]


def read(content: bytes, name: str = "a.csv", **keys: Any) -> tuple[list[float], list[float], tuple[str, ...]]:
    observation = json.dumps({"series": "settlement", **keys})
    model = json.dumps(staged().document()["forward_model"])
    points, _ = measured_points(observation, content, name, model)
    return np.round(points.x, 9).tolist(), np.round(points.y, 9).tolist(), points.notes


def test_stages_side_by_side_are_one_series() -> None:
    x, y, notes = read(SIDE, blocks=IN_TURN)
    assert (x, y) == (X, Y)  # the reading at the load of stage 2 is the last of stage 1
    assert notes == ("a.csv: 2 blocks were joined, x of each from the start of its stage",)


def test_zero_readings_and_readings_that_begin_anew() -> None:
    gauge = SIDE.replace(b";0.3\n60", b";5.3\n60").replace(b";0.5", b";5.5").replace(b"720;0.6", b"720;5.6")
    gauge = gauge.replace(b"1440;0.7", b"1440;5.7")
    x, y, notes = read(gauge, blocks=[IN_TURN[0], IN_TURN[1] | {"y_zero": "first", "y_adds": True}])
    assert (x, y) == (X, Y)
    assert "less the zero readings of the blocks, y from the last reading of the block before" in notes[0]


def test_stages_on_sheets_of_their_own_in_other_units() -> None:
    first = sheet_rows(("t [min]", "s [mm]"), (0, 0), (60, 0.2), (1440, 0.3))
    second = sheet_rows(("t [h]", "s [cm]"), (0, 0.03), (0.5, 0.05), (12, 0.06), (24, 0.07))
    content = workbook(("10 kPa", first), ("20 kPa", second))
    blocks = [{"sheet": "10 kPa", "stage": 1}, {"sheet": "20 kPa", "stage": 2}]
    assert read(content, "a.xlsx", x_column="t", y_column="s", blocks=blocks)[:2] == (X, Y)


def test_stages_one_below_the_other_by_their_number() -> None:
    rows = "1;0;0\n1;60;0.2\n1;1440;0.3\n2;0;0.3\n2;30;0.5\n2;720;0.6\n2;1440;0.7\n"
    blocks = [{"where": {"stage": stage}, "stage": stage} for stage in (1, 2)]
    assert read(f"stage;t [min];s [mm]\n{rows}".encode(), x_column="t", y_column="s", blocks=blocks)[:2] == (X, Y)


AGAIN = "load;t [min];s [mm]\n10;0;0\n;60;0.2\n20;0;0.2\n20;60;0.4\n10;0;0.4\n10;60;0.35\n"


def test_a_load_that_comes_again_is_a_block_of_its_own() -> None:
    """Both parts were read twice."""
    blocks: list[dict[str, Any]] = [{"where": {"load": load}} for load in (10, 20, 10)]
    assert read(AGAIN.encode(), x_column="t", y_column="s", blocks=blocks)[1] == [0, 0.2, 0.2, 0.4, 0.4, 0.35]
    with pytest.raises(ProblemError, match="3 blocks have load = 10, but 2 parts of the table; give one for each"):
        read(AGAIN.encode(), x_column="t", y_column="s", blocks=[*blocks, blocks[0]])


def test_blocks_with_dates_count_from_the_first() -> None:
    rows = b"date;s [mm];date;s [mm]\n2024-03-01;1;2024-03-03 12:00;3\n2024-03-02;2;2024-03-04;4\n"
    blocks = [{key: value for key, value in block.items() if key != "stage"} for block in IN_TURN]
    blocks[1] |= {"x_column": "C:C", "y_column": "D:D"}
    assert read(rows, blocks=blocks)[:2] == ([0, 1, 2.5, 3], [1, 2, 3, 4])


@pytest.mark.parametrize(
    ("content", "change", "path", "message"),
    [
        (
            SIDE.replace(b"1440;0.3", b"1500;0.3"),
            {},
            "blocks[0].stage",
            "1500 min is not in stage 1, which lasts",
        ),
        (SIDE, {"stage": 3}, "blocks[1].stage", "there is no stage 3; the forward model has 2"),
        (
            SIDE.replace(b";;t [min]", b";;t"),
            {},
            "blocks[1].x_column",
            "is in no known unit, 't [min]' of block 1",
        ),
        (SIDE.replace(b";;t [min]", b";;t [mm]"), {}, "blocks[1].x_column", "x_unit says what all of them are in"),
        (SIDE, {"y_zero": {"x": 9000}}, "blocks[1].y_zero", "there is no reading at x = 9000"),
        (SIDE, {"y_column": "G:G"}, "blocks[1]", "a.csv"),
        (SIDE, {"stage": None}, "", "some blocks have a stage and others none"),
    ],
)
def test_blocks_that_do_not_fit(content: bytes, change: dict[str, Any], path: str, message: str) -> None:
    with pytest.raises(ProblemError) as caught:
        read(content, blocks=[IN_TURN[0], IN_TURN[1] | change])
    assert (caught.value.issues[0].path, message in str(caught.value)) == (path, True), str(caught.value)


def test_a_problem_file_with_blocks(tmp_path: Path) -> None:
    document = staged().document()
    document["observations"] = [{"series": "settlement", "file": "a.csv", "blocks": IN_TURN}]
    (tmp_path / "a.csv").write_bytes(SIDE)
    (tmp_path / "p.json").write_text(json.dumps(document))
    problem = load_problem(tmp_path / "p.json")
    np.testing.assert_allclose(problem.observations[0].x * 1440, X)
    np.testing.assert_allclose(problem.observations[0].y * 1000, Y)
