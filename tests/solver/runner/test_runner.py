"""Evaluation processes: results, limits, and the end of whole process trees."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runner.evaluator import EvaluationCancelled, RunLimits
from geoswarm.solver.runner.runner import Runner
from geoswarm.solver.system.processes import descendants
from tests.integration.engines import process_exists, wait_for
from tests.workers.problems import course, line

pytestmark = pytest.mark.usefixtures("misbehaving_models")


@pytest.fixture(scope="module")
def shared_runner() -> Iterator[Runner]:
    made = Runner()
    yield made
    made.close()


@pytest.fixture
def runner(misbehaving_models: None, shared_runner: Runner) -> Runner:  # noqa: ARG001
    """One fork server for all tests of this module, with a new evaluation process for each."""
    shared_runner._kill()
    return shared_runner


def misbehaving(**section: Any) -> Calibration:
    document = {
        "forward_model": {"kind": "misbehaving", **section},
        "parameters": {"slope": {"lower": -5, "upper": 5}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
        "method": {"kind": "monte_carlo", "samples": 4},
        "seed": 1,
    }
    return Calibration(parse_problem(document), 1)


def positions(*slopes: float) -> np.ndarray[Any, np.dtype[np.float64]]:
    return np.array(slopes)[:, None]


def noted(path: Path) -> list[int]:
    return [int(text) for text in path.read_text().split()] if path.exists() else []


def test_the_same_bits_as_inline_with_one_request_or_many(runner: Runner) -> None:
    begun = course(line())
    made, asked = begun.calibration, begun.start().positions
    expected = [made.evaluate(position) for position in asked]
    for chunk in (1, 4, len(asked)):
        found = [
            outcome.evaluation
            for start in range(0, len(asked), chunk)
            for outcome in runner.run("job", made, asked[start : start + chunk], RunLimits())
        ]
        assert [f.objective for f in found] == [e.objective for e in expected]
        assert [f.misfits for f in found] == [e.misfits for e in expected]
        assert [f.responses["y"].tolist() for f in found] == [e.responses["y"].tolist() for e in expected]
        assert [f.parameters.tolist() for f in found] == asked[: len(found)].tolist()


def test_more_jobs_than_the_process_remembers(runner: Runner) -> None:
    begun = course(line())
    made, asked = begun.calibration, begun.start().positions[:1]
    objectives = {next(runner.run(f"job{i % 12}", made, asked, RunLimits())).evaluation.objective for i in range(30)}
    assert objectives == {made.evaluate(asked[0]).objective}


def test_a_failed_evaluation_brings_the_end_of_its_output(runner: Runner) -> None:
    outcomes = list(runner.run("job", misbehaving(behaviour="diverge"), positions(-1, 1, -2), RunLimits()))
    assert [o.evaluation.reason for o in outcomes] == [None, "diverged", None]
    assert [o.log for o in outcomes] == [None, "iteration 17: residual 1e+30\n", None]


@pytest.mark.parametrize("behaviour", ["for_ever", "fork", "chatter"])
def test_what_never_ends_is_killed_as_a_whole_and_the_others_go_on(
    runner: Runner, tmp_path: Path, behaviour: str
) -> None:
    notes = tmp_path / "pids"
    made = misbehaving(behaviour=behaviour, notes=str(notes))
    list(runner.run("job", made, positions(-1), RunLimits()))
    began = time.monotonic()
    outcomes = list(runner.run("job", made, positions(-1, -2, 1, -3), RunLimits(seconds=4.0)))
    took = time.monotonic() - began
    assert [o.evaluation.reason for o in outcomes] == [None, None, "timeout", None]
    assert outcomes[2].evaluation.message == ("ran for longer than 4 s (limits.seconds_per_evaluation) and was killed")
    assert took > 4.0
    assert len(noted(notes)) == {"for_ever": 1, "fork": 4, "chatter": 0}[behaviour]
    assert not any(process_exists(pid) for pid in noted(notes))
    if behaviour == "chatter":
        assert outcomes[2].log is not None
        assert outcomes[2].log.endswith("still iterating\n")
        assert len(outcomes[2].log) <= 8192


def test_what_eats_memory_is_killed(runner: Runner, tmp_path: Path) -> None:
    made = misbehaving(behaviour="eat", notes=str(tmp_path / "pids"))
    bad, good = runner.run("job", made, positions(1, -1), RunLimits(memory_mb=200))
    assert (bad.evaluation.reason, good.evaluation.reason) == ("killed_memory", None)
    assert bad.evaluation.message is not None
    assert "more than 200 MiB (limits.memory_mb)" in bad.evaluation.message
    assert not any(process_exists(pid) for pid in noted(tmp_path / "pids"))


@pytest.mark.parametrize(
    ("behaviour", "reason", "message"),
    [
        ("crash", "worker_lost", "the evaluation process was ended by SIGSEGV"),
        ("leave", "worker_lost", "the evaluation process ended by itself with exit code 3"),
        ("exit", "bad_output", "the forward model ended the program (sys.exit(3))"),
    ],
)
def test_a_process_that_ends_is_one_failed_evaluation(
    runner: Runner, behaviour: str, reason: str, message: str
) -> None:
    outcomes = list(runner.run("job", misbehaving(behaviour=behaviour), positions(-1, 1, -2), RunLimits()))
    assert [o.evaluation.reason for o in outcomes] == [None, reason, None]
    assert outcomes[1].evaluation.message == message


def test_an_unwanted_evaluation_is_killed_after_its_grace(runner: Runner, tmp_path: Path) -> None:
    notes = tmp_path / "pids"
    made = misbehaving(behaviour="for_ever", notes=str(notes))
    told: list[float] = []

    def unwanted() -> float | None:
        if not noted(notes):  # the second one is not under way yet
            return None
        told.append(time.monotonic())
        return 0.3

    outcomes = runner.run("job", made, positions(-1, 1), RunLimits(), unwanted=unwanted)
    with pytest.raises(EvaluationCancelled) as caught:
        list(outcomes)
    assert caught.value.index == 1
    assert time.monotonic() - told[0] >= 0.3
    assert not any(process_exists(pid) for pid in noted(notes))


def test_no_evaluation_is_begun_after_the_budget(runner: Runner) -> None:
    made = misbehaving(behaviour="sleep", seconds=4.0)
    list(runner.run("job", made, positions(-1), RunLimits()))  # the process is ready
    outcomes = list(runner.run("job", made, positions(-1, 1, 2, 3), RunLimits(), budget=4.0))
    assert len(outcomes) == 2  # one that takes no time, and one that takes all of it
    assert len(list(runner.run("job", made, positions(1, 2, 3, 4), RunLimits(), budget=0.0))) == 1


def test_a_killed_evaluation_process_or_fork_server_is_replaced(runner: Runner) -> None:
    made = misbehaving()
    asked = positions(-1, -2)
    list(runner.run("job", made, asked, RunLimits()))
    fork_server = runner._fork_server.pid
    os.kill(descendants(fork_server)[0], signal.SIGKILL)
    assert [o.evaluation.reason for o in runner.run("job", made, asked, RunLimits())] == [None, None]
    os.kill(fork_server, signal.SIGKILL)
    wait_for(lambda: not process_exists(fork_server), "the end of the fork server")
    assert [o.evaluation.reason for o in runner.run("job", made, asked, RunLimits())] == [None, None]
    assert runner._fork_server.pid != fork_server


def test_closing_leaves_nothing_behind() -> None:
    runner = Runner()
    list(runner.run("job", misbehaving(), positions(-1), RunLimits()))
    assert runner._fork_server is not None
    pids = [runner._fork_server.pid, *descendants(runner._fork_server.pid)]
    assert len(pids) == 2
    runner.close()
    assert not any(process_exists(pid) for pid in pids)
