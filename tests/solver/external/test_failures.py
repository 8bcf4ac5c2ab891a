"""Programs that misbehave, without a service: each with the right reason, and nothing left behind."""

from __future__ import annotations

import contextlib
import os
from pathlib import Path

import numpy as np
import psutil
import pytest

from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.external.runs.folder import private_folder
from geoswarm.solver.problem import load_problem
from geoswarm.solver.report.curves import series_curves
from geoswarm.solver.runs.local import calibrate
from tests.solver.external.zoo import ZOO, zoo_problem

SHARED = {"children", "hangs", "licence"}
"""Whose runs need processes: to end what a program left, to be beside others, to share a licence."""


def sleepers(folder: Path) -> set[int]:
    """What programs have started in run folders below one, and left."""
    found = set()
    for one in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            if one.name() == "sleep" and one.cwd().startswith(str(folder)):
                found.add(one.pid)
    return found


def assert_expected(name: str, evaluations: list[Evaluation], folder: Path) -> None:
    """As many good and bad runs, each with its reason; no process left, and only the folders of failed runs."""
    expected = ZOO[name]
    bad = [one for one in evaluations if one.parameters[0] > 0]
    good = [one for one in evaluations if one.parameters[0] <= 0]
    assert len(bad) == len(good) > 0
    assert {one.reason for one in bad} == {expected.reason}
    assert all(expected.words in (one.message or "") for one in bad)
    always = name in ("missing", "not_executable")
    assert {one.reason for one in good} == ({expected.reason} if always else {None})
    assert not sleepers(folder)
    left = sorted(one.name for one in private_folder("runs").iterdir())
    assert all(one.startswith("failed-") for one in left)
    assert bool(left) == (expected.reason is not None or name == "fallback")


@pytest.mark.usefixtures("zoo_models")
@pytest.mark.parametrize("name", sorted(ZOO.keys() - SHARED))
def test_each_failure_has_its_reason(name: str, tmp_path: Path) -> None:
    calibration = Calibration(zoo_problem(name), 3)
    assert_expected(name, [calibration.evaluate(np.array([slope])) for slope in (0.5, -0.5)], tmp_path)


@pytest.mark.usefixtures("zoo_models")
@pytest.mark.parametrize("name", sorted(SHARED))
def test_failures_in_processes_that_share_a_generation(name: str, tmp_path: Path) -> None:
    result = calibrate(zoo_problem(name), workers=2)
    assert len(result.history) == 4
    assert_expected(name, [record.evaluation for record in result.history], tmp_path)


def test_a_placeholder_that_is_misspelled_is_a_mistake_of_the_problem(zoo_models: Path, tmp_path: Path) -> None:
    (zoo_models / "good" / "input.in").write_text("{{slop}}\n")
    with pytest.raises(ProblemError, match="slop"):
        zoo_problem("good")
    (tmp_path / "input.in").write_text("{{slop}}\n")
    (tmp_path / "problem.yaml").write_text(
        "forward_model: {kind: command, run: [prog], templates: {a: input.in}, series: {y: {file: b, x: 1, y: 2}}}\n"
        "parameters: {slope: {lower: 0, upper: 1}}\n"
        "observations: [{series: y, points: {x: [0], y: [0]}}]\n"
        "stopping: {max_evaluations: 10}\n"
    )
    with pytest.raises(ProblemError, match=r"parameters.slop: is missing \(Used by a\)"):
        load_problem(tmp_path / "problem.yaml")


def test_reports_run_no_program_of_the_users(zoo_models: Path, tmp_path: Path) -> None:
    """A service draws curves in the process of its API."""
    problem = zoo_problem("exit_1")
    (zoo_models / "exit_1" / "zoo.py").write_text("raise SystemExit(9)")
    points = {"y": problem.observations[0].x}
    (curve,) = series_curves(problem, points, {"slope": 1.0}, {"slope": 0.5})
    assert curve.at_points.tolist() == points["y"].tolist()
    assert not (tmp_path / f"geoswarm-{os.getuid()}").exists()
