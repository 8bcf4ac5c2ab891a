"""``geoswarm examples``: for those who have no checkout."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

from geoswarm.cli import main

EXAMPLES = Path(__file__).parents[3] / "examples"
NAMES = [
    *(
        "calculix",
        "column",
        "combined",
        "consolidation",
        "crs_oedometer",
        "direct_simple_shear",
        "formula",
        "fortran_pest",
    ),
    *("isotropic_compression", "kratos"),
    *("oedometer", "opengeosys", "opengeosys_slope", "pile_tz", "plaxis", "python_spreadsheet", "slope", "triaxial"),
    "umat",
]


def files_of(folder: Path) -> dict[str, str]:
    """Texts of an example by name; not what running its scripts, or compiling its program, has left there."""
    left = (".pyc", "consolidation", ".so")
    found = [path for path in folder.rglob("*") if path.is_file() and not path.name.endswith(left)]
    return {path.relative_to(folder).as_posix(): path.read_text(encoding="utf-8") for path in found}


def test_list_names_every_example_with_what_it_shows(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples"]) == 0
    lines = capsys.readouterr().out.splitlines()
    for name in NAMES:
        (line,) = [line for line in lines if line.strip().startswith(f"{name} ")]
        heading = (EXAMPLES / name / "README.md").read_text(encoding="utf-8").splitlines()[0]
        assert heading[2:40] in line


def test_the_documentation_lists_the_same_examples() -> None:
    index = (EXAMPLES.parent / "docs" / "index.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^\| \[examples/(\w+)\]", index, re.MULTILINE)) == NAMES


def test_json_has_kind_and_method(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples", "--json"]) == 0
    items = json.loads(capsys.readouterr().out)["items"]
    assert [item["name"] for item in items] == NAMES
    assert items[NAMES.index("slope")] == {
        "name": "slope",
        "title": "A creeping slope",
        "forward_model": "section",
        "method": "particle_swarm",
        "needs_engine": False,
    }
    assert items[-1]["needs_engine"] is True


@pytest.mark.parametrize("name", NAMES)
def test_an_example_is_written_out_whole(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = tmp_path / "new" / name
    assert main(["examples", name, str(folder), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    written, there = files_of(folder), files_of(EXAMPLES / name)
    there["README.md"] = there["README.md"].replace(f"examples/{name}/", f"{folder}/")
    assert written == there
    assert set(document["files"]) >= {str(folder / file) for file in written}


def test_what_needs_a_program_says_so(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples", "calculix", str(tmp_path)]) == 0
    assert f"Next: {tmp_path / 'README.md'} says how to run it, and what must be installed" in capsys.readouterr().err
    assert "`ccx`" in (tmp_path / "README.md").read_text(encoding="utf-8")


def test_it_runs_where_it_was_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples", "formula", str(tmp_path)]) == 0
    assert f"Next: geoswarm run {tmp_path / 'problem.yaml'}" in capsys.readouterr().err
    assert main(["check", str(tmp_path / "problem.yaml")]) == 0


def test_existing_files_are_named_and_kept(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    mine = tmp_path / "settlement.csv"
    mine.write_text("x,y\n", encoding="utf-8")
    assert main(["examples", "formula", str(tmp_path)]) == 2
    assert capsys.readouterr().err == f"Error: nothing was written, because these files exist: {mine}\n"
    assert [path.name for path in tmp_path.iterdir()] == ["settlement.csv"]
    assert mine.read_text(encoding="utf-8") == "x,y\n"


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (["oedometre", "x"], "there is no example 'oedometre'; did you mean oedometer?; known: calculix, column, "),
        (["xyz", "x"], "there is no example 'xyz'; known: calculix, column, "),
        (["slope"], "give the folder to write it to: geoswarm examples slope DIRECTORY"),
        (["slope", __file__], "is a file"),
    ],
)
def test_what_cannot_be_written_is_said(arguments: list[str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["examples", *arguments]) == 2
    assert told in capsys.readouterr().err
