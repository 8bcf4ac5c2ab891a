"""The script for PLAXIS against a stand-in for PLAXIS and its client: PLAXIS itself cannot be had here."""

from __future__ import annotations

import json
import os
import runpy
import shutil
import sys
from dataclasses import dataclass
from pathlib import Path

import pytest

from geoswarm.cli import main
from geoswarm.solver.examples import example_names
from geoswarm.solver.problem import load_problem
from tests.examples.engines import HERE, assert_same_readings, calibrated, copy_of
from tests.servers import free_port

STAND_IN = Path(__file__).parent / "plaxis_stand_in"
TRUTH = {"lambda_star": 0.1, "mu_star": 5.0e-3}
PASSWORD = "a secret of this test"


@dataclass(frozen=True)
class Plaxis:
    """The example with a project, and the stand-in that it calls."""

    problem: Path
    folder: Path
    port: int

    @property
    def commands(self) -> list[tuple[int, str, list[object]]]:
        """What was asked so far: port, command and arguments."""
        lines = (self.folder / "log").read_text(encoding="utf-8").splitlines()
        return [tuple(json.loads(line)) for line in lines]

    @property
    def model(self) -> Path:
        return self.problem.parent / "models" / "embankment"


@pytest.fixture
def plaxis(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Plaxis:
    problem = copy_of("plaxis", tmp_path / "example")
    folder = tmp_path / "stand in"
    shutil.copytree(STAND_IN, folder, ignore=shutil.ignore_patterns("__pycache__"))
    (folder / "licence").touch()
    program = folder / "Plaxis2DXInput"
    program.write_text(f"#!/bin/sh\nexec '{sys.executable}' '{folder / 'plaxis.py'}' \"$@\"\n", encoding="utf-8")
    program.chmod(0o755)
    found = Plaxis(problem, folder, free_port(2))  # for Input and Output
    (found.model / "embankment.p2dx").write_text("a project\n", encoding="utf-8")
    (found.model / "embankment.p2dxdat").mkdir()
    (found.model / "embankment.p2dxdat" / "data.p2dx").write_text("its data\n", encoding="utf-8")
    monkeypatch.setenv("GEOSWARM_MODELS", str(found.model.parent))
    monkeypatch.setenv("PATH", str(Path(sys.executable).parent), prepend=os.pathsep)
    monkeypatch.setenv("PYTHONPATH", str(folder), prepend=os.pathsep)
    monkeypatch.setenv("PLAXIS_PROGRAM", str(program))
    monkeypatch.setenv("PLAXIS_PASSWORD", PASSWORD)
    monkeypatch.setenv("PLAXIS_FIRST_PORT", str(found.port))
    return found


def checked(plaxis: Plaxis, capsys: pytest.CaptureFixture[str], *settings: str) -> tuple[int, str]:
    """Exit code and all that `geoswarm models check` prints."""
    options = [option for setting in settings for option in ("--set", setting)]
    code = main(["models", "check", plaxis.model.name, *options])
    printed = capsys.readouterr()
    return code, printed.out + printed.err


def test_the_script_makes_these_calls(plaxis: Plaxis, capsys: pytest.CaptureFixture[str]) -> None:
    code, told = checked(plaxis, capsys, "lambda_star=0.1", "kappa_star=0.02", "mu_star=0.005")
    assert code == 0, told
    assert PASSWORD not in told
    asked = plaxis.commands
    first, second = plaxis.port, plaxis.port + 1
    once = [(port, command) for port, command, _ in asked if command != "getcurveresults"]
    assert once == [
        *((first, "name"), (first, "open"), (first, "materials"), (first, "setproperties"), (first, "phases")),
        *((first, "calculate"), (first, "phases"), (first, "phases"), (first, "view")),
        *((second, "name"), (second, "nodes"), (second, "steps"), (first, "kill")),
    ]
    arguments = {command: given for _, command, given in asked}
    assert arguments["setproperties"] == ["clay", "lambdaModified", 0.1, "kappaModified", 0.02, "muModified", 0.005]
    assert arguments["open"] != [str(plaxis.model / "embankment.p2dx")]
    assert not (plaxis.model / "embankment.p2dxdat" / "results").exists()  # each run has its own copy of the project


@pytest.mark.slow
def test_the_true_values_lie_in_the_intervals(
    plaxis: Plaxis, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = calibrated(plaxis.problem, tmp_path / "out", capsys)
    assert found.keys() == TRUTH.keys()
    for name, value in TRUTH.items():
        assert found[name].lower < value < found[name].upper
        assert found[name].upper / found[name].lower < 1.2


def test_the_readings_are_those_of_the_stand_in(plaxis: Plaxis) -> None:
    script = runpy.run_path(str(plaxis.problem.parent / "generate_data.py"), run_name="__main__")
    assert script["TRUTH"] == TRUTH
    assert_same_readings("plaxis", plaxis.problem.parent, digit=0.1)


def test_a_phase_that_fails_is_diverged(plaxis: Plaxis, capsys: pytest.CaptureFixture[str]) -> None:
    code, told = checked(plaxis, capsys, "lambda_star=0.02", "mu_star=0.01")
    assert code == 1
    assert "diverged" in told
    assert "Consolidation: soil body collapses [101]" in told
    assert plaxis.commands[-1][1] == "kill"


def test_without_a_licence_it_waits(plaxis: Plaxis) -> None:
    text = (plaxis.model / "model.yaml").read_text(encoding="utf-8")
    (plaxis.model / "model.yaml").write_text(text.replace("licence_pause: 60", "licence_pause: 0.1"), encoding="utf-8")
    (plaxis.folder / "licence").unlink()
    problem = load_problem(plaxis.problem)
    run = problem.model.prepare({one.series: one.x for one in problem.observations})
    settlements = run(TRUTH | {"kappa_star": 0.02})
    assert settlements["A"][-1] > settlements["B"][-1] > 0.2
    assert (plaxis.folder / "licence").exists()


def test_the_password_is_never_shown(plaxis: Plaxis, capsys: pytest.CaptureFixture[str]) -> None:
    script = plaxis.model / "run_plaxis.py"
    text = script.read_text(encoding="utf-8").replace('print("FINISHED")', "print(password)")
    script.write_text(text, encoding="utf-8")
    code, told = checked(plaxis, capsys, "lambda_star=0.1", "mu_star=0.005")
    assert code == 1
    assert "***" in told
    assert PASSWORD not in told


def test_without_a_project_it_is_reported(plaxis: Plaxis, capsys: pytest.CaptureFixture[str]) -> None:
    (plaxis.model / "embankment.p2dx").unlink()
    assert main(["check", str(plaxis.problem)]) == 2
    assert "embankment.p2dx is not in " in capsys.readouterr().err


def test_the_client_of_plaxis_is_not_in_the_repository() -> None:
    """Its licence forbids to hand it on: the script takes that of the user's installation."""
    first = (HERE / "plaxis" / "README.md").read_text(encoding="utf-8").splitlines()[0]
    assert "not run against PLAXIS" in first
    assert "plaxis" not in example_names(engines=False)
    names = {path.relative_to(HERE).as_posix() for path in HERE.rglob("*plxscripting*")}
    assert names == set()
