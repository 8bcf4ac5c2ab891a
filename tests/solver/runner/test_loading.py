"""What a fork server loads: what every evaluation needs, and before the first one of a job what that job needs."""

from __future__ import annotations

import json
import os
import signal
from collections.abc import Iterator
from pathlib import Path

import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.problem import load_problem, parse_problem
from geoswarm.solver.runner.evaluator import RunLimits
from geoswarm.solver.runner.kernels import make_ready
from geoswarm.solver.runner.runner import Runner
from geoswarm.solver.warm import SAMPLES
from tests.solver.runner.test_runner import misbehaving, positions

OF_OTHERS = "geoswarm.solver.laws.modified_cam_clay"
OF_OEDOMETER = "geoswarm.solver.element_test.constant_load"
OF_PLUG_IN = "geoswarm_test_models"

TELLING = f"""
import sys

def curve(a):
    print([name for name in {(OF_OTHERS, OF_OEDOMETER, OF_PLUG_IN)!r} if name in sys.modules])
    raise ValueError("told")
"""
PROBLEM = {
    "name": "telling",
    "forward_model": {"kind": "python", "file": "telling.py", "function": "curve", "series": {"y": {}}},
    "parameters": {"a": {"lower": 0.0, "upper": 1.0}},
    "observations": [{"series": "y", "points": {"x": [0.0, 1.0], "y": [0.0, 1.0]}}],
    "method": {"kind": "monte_carlo", "samples": 1},
}


@pytest.fixture
def runner(misbehaving_models: None) -> Iterator[Runner]:  # noqa: ARG001
    made = Runner()
    made.start()
    yield made
    made.close()


@pytest.fixture
def telling(tmp_path: Path) -> Calibration:
    """A model that tells which modules are there when it is called, in the output of a failed run."""
    (tmp_path / "telling.py").write_text(TELLING)
    (tmp_path / "problem.json").write_text(json.dumps(PROBLEM))
    return Calibration(load_problem(tmp_path / "problem.json"), 1)


def there(runner: Runner, telling: Calibration) -> str | None:
    (outcome,) = runner.run("telling", telling, positions(0.5), RunLimits())
    return outcome.log


def test_a_fork_server_loads_what_its_jobs_need_and_one_in_its_place_too(runner: Runner, telling: Calibration) -> None:
    assert there(runner, telling) == "[]\n"
    made = misbehaving(behaviour="diverge")
    for problem in (parse_problem(SAMPLES["oedometer"]), made.problem):
        assert make_ready(runner, problem)
    expected = f"{[OF_OEDOMETER, OF_PLUG_IN]}\n"
    assert there(runner, telling) == expected
    process = runner._fork_server.pid
    assert process is not None
    os.kill(process, signal.SIGKILL)
    list(runner.run("other", made, positions(-1), RunLimits()))
    assert runner._fork_server.pid not in (None, process)
    assert there(runner, telling) == expected


def test_what_is_loaded_is_not_loaded_again(runner: Runner) -> None:
    made = misbehaving(behaviour="diverge")
    assert make_ready(runner, made.problem)
    list(runner.run("job", made, positions(-1), RunLimits()))
    process = runner._process
    assert make_ready(runner, made.problem)
    assert runner._process is process is not None


def test_a_forward_model_that_cannot_be_imported_is_left_to_the_jobs_that_name_it(
    telling: Calibration, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    package = tmp_path / "broken-1.0.dist-info"
    package.mkdir()
    (package / "METADATA").write_text("Metadata-Version: 2.1\nName: broken\nVersion: 1.0\n")
    (package / "entry_points.txt").write_text("[geoswarm.forward_models]\nbroken = nowhere:Spec\n")
    monkeypatch.syspath_prepend(tmp_path)
    runner = Runner()
    try:
        runner.import_models(["broken", "unheard_of"], lambda: False)
        assert there(runner, telling) == "[]\n"
    finally:
        runner.close()
    told = capfd.readouterr().err
    assert "forward model 'broken' (nowhere:Spec) is installed but cannot be loaded" in told
    assert "unknown kind 'unheard_of'" in told
