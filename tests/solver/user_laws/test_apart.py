"""Routines that crash, keep state, hang or print: what of it reaches the process that wants their result."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.cli import main
from geoswarm.solver.calibration import Calibration
from geoswarm.solver.errors import ForwardError
from geoswarm.solver.problem import Problem, load_problem
from geoswarm.solver.runs.local import calibrate
from tests.solver.user_laws.routines import MISBEHAVING, section
from tests.solver.user_laws.test_sections import calculated, document, written

XIT, SHORTER, NAN, CRASH, HANG, KEEPS, PRINTS = 1, 8, 9, 13, 15, 20, 21


def problem(
    folder: Path, mode: int, *, stress: float = 100.0, method: dict[str, Any] | None = None, **changes: Any
) -> Path:
    """An oedometer of a routine that misbehaves."""
    made = document(section(MISBEHAVING, **changes), {"mode": {"value": mode}, "stress": {"value": stress}})
    return written(folder, made | ({} if method is None else method))


def searched(found: Problem) -> list[tuple[float | None, str | None, str]]:
    """Objective, reason and message of every evaluation of a calibration in process."""
    return [
        (one.evaluation.objective, one.evaluation.reason, one.evaluation.message or "")
        for one in calibrate(found, workers=1).history
    ]


SEARCH = {"method": {"kind": "particle_swarm", "particles": 3}, "stopping": {"max_evaluations": 6}, "seed": 1}


def test_a_crash_is_a_failed_run(tmp_path: Path) -> None:
    found = load_problem(problem(tmp_path, CRASH))
    with pytest.raises(ForwardError, match="the routine ended its process by SIGSEGV") as failed:
        calculated(found)
    assert failed.value.reason == "worker_lost"
    evaluation = Calibration(found, 1).evaluate(np.array([5.0e3]))
    assert evaluation.reason == "worker_lost"
    assert calculated(found, mode=0.0)["stage_axial_strain"][1] > 0.0


def test_a_crash_is_a_failed_evaluation_of_a_calibration(tmp_path: Path) -> None:
    found = load_problem(problem(tmp_path, CRASH, method=SEARCH))
    assert [reason for _, reason, _ in searched(found)] == ["worker_lost"] * 6


def test_commands_survive_a_crash(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    path = str(problem(tmp_path, CRASH))
    for command in (["evaluate", path, "--json"], ["check", path]):
        assert main(command) == 1
        assert "(worker_lost): the routine ended its process by SIGSEGV" in capfd.readouterr().err


@pytest.mark.parametrize(
    ("mode", "words"),
    [(XIT, "the routine ended itself (XIT, STOP)"), (NAN, "the routine gave numbers that are none")],
)
def test_xit_and_nan_are_failed_evaluations(mode: int, words: str, tmp_path: Path) -> None:
    found = load_problem(problem(tmp_path, mode))
    with pytest.raises(ForwardError, match="no solution at") as failed:
        calculated(found)
    assert failed.value.reason == "diverged"
    assert words in str(failed.value)
    assert "shorter" not in str(failed.value)
    evaluation = Calibration(found, 1).evaluate(np.array([5.0e3]))
    assert evaluation.reason == "diverged"
    assert words in (evaluation.message or "")


def test_steps_are_as_short_as_the_routine_wants(tmp_path: Path) -> None:
    # Elastic whatever the steps: the strains of the whole load are 6e-3 and more.
    found = load_problem(problem(tmp_path, SHORTER, stress=1.0e-4))
    confined = 5.0e3 * 0.7 / (1.3 * 0.4)
    assert calculated(found)["stage_axial_strain"] == pytest.approx(np.array([40.0, 130.0]) / confined, rel=1.0e-6)


def test_a_routine_with_state_of_its_own_begins_anew_with_each_run(tmp_path: Path) -> None:
    kept = load_problem(problem(tmp_path, KEEPS, method=SEARCH, stateful=True))
    first, second = calculated(kept), calculated(kept)
    assert first["stage_axial_strain"].tolist() == second["stage_axial_strain"].tolist()
    # In evaluation processes, which make many runs, as well: one value for one position.
    alone = Calibration(kept, 1)
    for one in calibrate(kept, workers=1).history:
        assert one.evaluation.objective == alone.evaluate(one.evaluation.parameters).objective
    loose = load_problem(problem(tmp_path, KEEPS, method=SEARCH))
    history = [one.evaluation for one in calibrate(loose, workers=1).history]
    assert any(one.objective != alone.evaluate(one.parameters).objective for one in history)


def test_what_a_routine_prints_fills_no_disk_and_no_answer(
    tmp_path: Path, capfd: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    path = problem(tmp_path, PRINTS, method=SEARCH)
    assert main(["evaluate", str(path), "--json"]) == 0
    printed = capfd.readouterr()
    assert json.loads(printed.out)["objective"] > 0.0
    lines = printed.err.splitlines()
    (left_out,) = [place for place, line in enumerate(lines) if line.endswith("lines of the routine before these")]
    assert int(lines[left_out].split()[1]) > 20_000
    assert len(lines) - left_out <= 101
    shown = "\n".join(lines[left_out + 1 :])
    assert "a line of output" in shown
    assert "a line for the message file" in shown
    assert [objective is not None for objective, _, _ in searched(load_problem(path))] == [True] * 6
    assert capfd.readouterr().err.count("a line of output") == 0
    assert sorted(one.name for one in tmp_path.iterdir()) == ["problem.json"]


def test_a_routine_that_hangs_is_ended_at_the_limit(tmp_path: Path) -> None:
    limits = {**SEARCH, "limits": {"seconds_per_evaluation": 1.0}, "stopping": {"max_evaluations": 1}}
    limits["method"] = {"kind": "monte_carlo", "samples": 1}
    found = load_problem(problem(tmp_path, HANG, method=limits))
    assert [reason for _, reason, _ in searched(found)] == ["timeout"]


def test_an_interrupt_leaves_no_copy_behind(tmp_path: Path) -> None:
    path = problem(tmp_path, HANG)
    code = (
        "import os, psutil, signal, sys, threading, time\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"  # a background job may ignore it
        "from geoswarm.solver.problem import load_problem\n"
        "from tests.solver.user_laws.test_sections import calculated\n"
        "found = load_problem(sys.argv[1])\n"
        "calculated(found, mode=0.0)\n"
        "def interrupt():\n"
        "    while sum(sum(one.cpu_times()[:2]) for one in psutil.Process().children()) < 0.5:\n"
        "        time.sleep(0.05)\n"
        "    os.kill(os.getpid(), signal.SIGINT)\n"  # while the copy hangs
        "try:\n"
        "    threading.Thread(target=interrupt).start()\n"
        "    calculated(found)\n"
        "except KeyboardInterrupt:\n"
        "    print('children', len(psutil.Process().children()))\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(path)],
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(sys.path)},
    )
    assert done.stdout.strip().endswith("children 0"), done.stderr
