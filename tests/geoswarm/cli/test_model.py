"""``geoswarm model new``, ``model try``, ``models`` and ``check`` for programs of the user's."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.cli.model.new import Mark, marked, parse_mark
from geoswarm.cli.words.error_messages import BadInputError
from tests.solver.external.zoo import register, zoo_problem

PROGRAM = """\
import math
stiffness, rate = (float(word) for word in open("input.txt").read().split()[3:6:2])
with open("result.csv", "w") as file:
    file.write("day,mm\\n")
    for day in (1, 2, 4, 8, 16):
        file.write(f"{day},{1e4 / stiffness * (1 - math.exp(-rate * day))!r}\\n")
print("calculated")
"""
EXAMPLE = "# settlement\nE 2e4\nk 0.3\nsteps 20\n"


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("TMPDIR", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", None)
    (tmp_path / "settle.py").write_text(PROGRAM)
    (tmp_path / "input.txt").write_text(EXAMPLE)
    return tmp_path


def new(*more: str) -> int:
    given = ["--run", f"{sys.executable} settle.py", "--input", "input.txt", "--result", "result.csv"]
    return main(["model", "new", *given, "--mark", "E=20000", "--mark", "k=0.3", *more])


@pytest.mark.usefixtures("blank_figures")
def test_a_program_is_calibrated_from_an_example_of_its_input(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert new() == 0
    assert (folder / "input.txt.in").read_text() == "# settlement\nE {{E}}\nk {{k}}\nsteps 20\n"
    assert "files: [settle.py]" in (folder / "problem.yaml").read_text()
    text = (folder / "problem.yaml").read_text()
    units = '{file: result.csv, x: 1, y: 2, x_unit: "1", y_unit: "1"}'
    assert units in text
    text = text.replace(units, "{file: result.csv, x: day, y: mm, x_unit: day, y_unit: mm}")
    text = text.replace('file: readings.csv, x_unit: "1", y_unit: "1"', "file: readings.csv, x_unit: day, y_unit: mm")
    assert "max_evaluations: 200" in text
    (folder / "problem.yaml").write_text(text.replace("max_evaluations: 200", "max_evaluations: 60"))
    (folder / "readings.csv").write_text("x,y\n1,0.12\n2,0.21\n4,0.33\n8,0.43\n16,0.47\n")
    capsys.readouterr()

    assert main(["model", "try", "problem.yaml", "--set", "E=10000"]) == 0
    tried = capsys.readouterr().out
    assert "made by it" in tried
    assert "calculated" in tried
    assert "0.25918177931828" in tried  # the line that the first point was read from
    assert main(["model", "try", "problem.yaml", "--json"]) == 0
    (run,) = json.loads(capsys.readouterr().out)["runs"]
    assert run["written"] == ["settle.py", "input.txt"]
    assert run["made"] == ["output.txt", "result.csv"]
    assert run["series"]["result"]["lines"][0][1].startswith("1,0.12959088965914")
    assert (Path(run["folder"]) / "input.txt").read_text() == "# settlement\nE 20000.0\nk 0.3\nsteps 20\n"

    assert main(["check", "problem.yaml"]) == 0
    told = capsys.readouterr().out
    assert "5 points of result.csv, x from 1 to 16 day" in told
    assert main(["run", "problem.yaml", "--output", "out"]) == 0
    assert "20" in capsys.readouterr().out
    best = json.loads((folder / "out" / "result.json").read_text())["parameters"]
    assert best["E"] == pytest.approx(2.1e4, rel=0.05)


def test_nothing_is_overwritten_and_marks_are_found(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert new() == 0
    assert new() == 2
    assert "there already, and never overwritten" in capsys.readouterr().err
    assert new("--mark", "n=21", "--output", "other") == 2
    assert "--mark n=21: there is no such number in input.txt" in capsys.readouterr().err
    (folder / "input.txt").write_text("1 2\n1 3\n")
    assert main(["model", "new", "--run", "a", "--input", "input.txt", "--result", "r", "--mark", "a=1"]) == 2
    assert "it occurs in 2 places (lines 1, 2); give a=1@LINE" in capsys.readouterr().err


def test_marks_keep_their_line_and_name() -> None:
    assert marked("a 1.0 2\nb 1.0\n", [Mark("E", 1.0, 2), Mark("n", 2.0, None)], "f") == "a 1.0 {{n}}\nb {{E}}\n"
    assert marked("{{x}} 1D3", [Mark("E", 1000.0, None)], "f") == "{{{{x}} {{E}}"
    assert parse_mark("E = 1.5e-3 @ 7") == Mark("E", 1.5e-3, 7)
    for wrong in ("E", "=1", "1=2", "E=x", "E=1@x"):
        with pytest.raises(BadInputError, match="--mark"):
            parse_mark(wrong)


def test_a_run_that_fails_is_shown_whole(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "problem.yaml").write_text(
        "forward_model:\n"
        "  {kind: command, run: [sh, -c, 'echo went wrong; exit 3'], write: {a.json: json},\n"
        "   series: {y: {file: b.csv, x: 1, y: 2}}}\n"
        "parameters: {a: {lower: 0, upper: 1}}\n"
        "observations: [{series: y, points: {x: [0], y: [0]}}]\n"
        "stopping: {max_evaluations: 10}\n"
    )
    assert main(["model", "try", "problem.yaml"]) == 1
    told = capsys.readouterr()
    assert "ended with exit status 3" in told.out
    assert "b.csv: the run wrote no such file" in told.out
    assert "the run failed (program_failed)" in told.err
    assert "went wrong" in told.err
    assert main(["check", "problem.yaml"]) == 1
    assert "a" in capsys.readouterr().out


def test_models_are_listed_shown_and_checked(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["models", "list"]) == 0
    assert "GEOSWARM_MODELS names folders" in capsys.readouterr().err
    register(folder / "models")
    (folder / "models" / "exit_3" / "model.yaml").write_text("forward_model: {kind: registered}\nparameters: {a: {}}\n")
    monkeypatch.setenv("GEOSWARM_MODELS", str(folder / "models"))
    assert main(["models", "list", "--json"]) == 0
    rows = {row["model"]: row for row in json.loads(capsys.readouterr().out)}
    assert len(rows["good"]["version"]) == 64
    assert "forward_model.kind must be one of formula, combined, oedometer" in rows["exit_3"]["title"]
    assert main(["models", "show", "good"]) == 0
    assert "at least -10 and at most 10" in capsys.readouterr().out
    assert main(["models", "check", "good"]) == 0
    assert "ended with exit status 0" in capsys.readouterr().out
    assert main(["models", "check", "exit_1", "--set", "slope=1"]) == 1
    assert "no convergence in increment 7" in capsys.readouterr().err
    for given, mistake in [
        (["slop=1"], "--set slop: unknown parameter; did you mean slope?; known: slope"),
        (["slope"], "--set 'slope': give NAME=VALUE"),
        (["slope=nan"], "--set slope: 'nan' is not a finite number"),
        (["slope=1", "slope=2"], "--set slope: given twice"),
    ]:
        assert main(["models", "check", "good", *(word for one in given for word in ("--set", one))]) == 2
        assert mistake in capsys.readouterr().err
    text = (folder / "models" / "good" / "model.yaml").read_text()
    (folder / "models" / "good" / "model.yaml").write_text(
        text.partition("parameters:")[0] + "parameters: {slope: {}}\n"
    )
    assert main(["models", "check", "good"]) == 2
    assert "has neither a default nor a typical range; give --set slope=VALUE" in capsys.readouterr().err
    assert main(["models", "check", "good", "--set", "slope=2"]) == 0
    assert "ended with exit status 0" in capsys.readouterr().out
    assert main(["models", "show", "goood"]) == 2
    assert "did you mean good?" in capsys.readouterr().err
    assert main(["models", "show", "exit_3"]) == 2
    (folder / "registered.json").write_text(json.dumps(zoo_problem("good").document()))
    assert main(["model", "try", "registered.json"]) == 0
    assert "out.csv" in capsys.readouterr().out
    assert main(["check", "registered.json"]) == 0
    assert "5 points of out.csv" in capsys.readouterr().out


def test_a_model_that_cannot_be_looked_at_is_listed_as_broken(
    folder: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    register(folder / "models")
    monkeypatch.setenv("GEOSWARM_MODELS", str(folder / "models"))
    monkeypatch.setattr("geoswarm.solver.external.runs.fingerprints.MOST_FILES", 4)
    (folder / "models" / "good" / "further").write_text("")
    assert main(["models", "list", "--json"]) == 0
    rows = {row["model"]: row for row in json.loads(capsys.readouterr().out)}
    assert rows["good"]["title"].startswith("broken: ")
    assert "has more than 4 files" in rows["good"]["title"]
    assert rows["exit_3"]["title"] == ""


def test_only_programs_are_tried(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["model", "try", "examples/formula/problem.yaml"]) == 2
    assert "runs no program; geoswarm evaluate shows" in capsys.readouterr().err


def test_what_the_call_names_is_copied_into_another_folder(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "settle").write_text(f"#!{sys.executable}\n{PROGRAM}")
    (folder / "settle").chmod(0o755)
    call = ["--run", "./settle", "--input", "input.txt", "--result", "result.csv", "--mark", "k=0.3"]
    assert main(["model", "new", *call, "--output", "other"]) == 0
    assert "other/problem.yaml, other/settle" in capsys.readouterr().err
    text = (folder / "other" / "problem.yaml").read_text().replace("x: 1, y: 2", "x: day, y: mm")
    (folder / "other" / "problem.yaml").write_text(text)
    assert "files: [settle]" in text
    assert main(["model", "try", "other/problem.yaml"]) == 0
    assert "calculated" in capsys.readouterr().out
    (folder / "third").mkdir()
    (folder / "third" / "settle").write_text("another program")
    assert main(["model", "new", *call, "--output", "third"]) == 2
    assert "third/settle: there already, and never overwritten" in capsys.readouterr().err
