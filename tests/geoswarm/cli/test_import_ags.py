"""``geoswarm import ags``: lists a file, makes a problem that passes its check, and tells what is wrong in one line."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from geoswarm.cli import main
from tests.solver.ags.synthetic import content


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    (tmp_path / "synthetic.ags").write_bytes(content())
    monkeypatch.chdir(tmp_path)
    return tmp_path


def test_without_an_output_the_file_is_listed(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "ags", "synthetic.ags"]) == 0
    told = capsys.readouterr().out
    for words in (
        "BH1/3/1/4.60",
        "oedometer (CONG/CONS)",
        "triaxial CU (TREG/TRET)",
        "monitoring PRES (MOND)",
        "SWELL",
    ):
        assert words in told
    assert main(["import", "ags", "synthetic.ags", "--json", "--specimen", "BH3"]) == 0
    listed = json.loads(capsys.readouterr().out)
    assert [entry["id"] for entry in listed] == ["BH3/P1", "BH3/P1"]
    assert sorted(path.name for path in folder.iterdir()) == ["synthetic.ags"]


def test_a_problem_passes_its_check(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", "ags", "synthetic.ags", "--output", "made", "--specimen", "BH1/3/1"]) == 0
    captured = capsys.readouterr()
    assert captured.out == ""
    assert "Note: the durations of the increments are not in the file; 24 h are assumed" in captured.err
    assert "To do" not in captured.err
    assert "Next: geoswarm check made/problem.yaml" in captured.err
    assert main(["check", "made/problem.yaml"]) == 0
    assert "test run          finished" in capsys.readouterr().out
    assert main(["import", "ags", "synthetic.ags", "--output", "made", "--specimen", "BH1/3/1"]) == 2
    assert "never overwritten" in capsys.readouterr().err
    assert (folder / "made" / "BH1_3_1_4_60.csv").is_file()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--output", "made"], "holds 5 tests, which need not be of one soil; choose with --specimen ID: BH1/3/1/4.60"),
        (["--output", "made", "--specimen", "BH9"], "'BH9' is not an ID in this file"),
        (["--output", "made", "--specimen", "BH2/7/3"], "no problem can be made of these tests"),
        (["--stage-duration", "24"], "--stage-duration must be a number and a unit, such as '24 h', got '24'"),
        (["--stage-duration", "24 kPa"], "--stage-duration '24 kPa': unit 'kPa' cannot be converted to day"),
        (["--stage-duration", "0 h"], "--stage-duration must be above 0 day, got '0 h'"),
        (["--initial-stress", "low"], "--initial-stress must be a number and a unit, such as '1 kPa', got 'low'"),
        (["--output", "made", "--specimen", "BH1/3/1", "--material", "x"], "--material: unknown law 'x'"),
    ],
)
def test_what_is_wrong_is_reported(
    folder: Path, capsys: pytest.CaptureFixture[str], arguments: list[str], message: str
) -> None:
    assert main(["import", "ags", "synthetic.ags", *arguments]) == 2
    assert message in capsys.readouterr().err
    assert not (folder / "made").exists()


def test_other_files_are_reported(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "old.ags").write_text('"**PROJ"\n"*PROJ_ID"\n"1"\n')
    assert main(["import", "ags", "old.ags"]) == 2
    assert "is AGS 3; AGS 4 is accepted" in capsys.readouterr().err
