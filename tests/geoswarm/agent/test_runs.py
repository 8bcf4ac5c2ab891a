"""Runs in a process of their own: what they give, what ends them, and that nothing outlives them."""

from __future__ import annotations

import json
import os
import signal
import sys
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import psutil
import pytest

from geoswarm.agent.run_main import BOOTSTRAP
from geoswarm.agent.runs import RunProcess, Unwanted
from geoswarm.agent.trees.tree import start_tree
from geoswarm.solver.problem import Problem
from geoswarm.workers.agents.prepared import frame_of
from geoswarm.workers.settings import Settings
from tests.integration.agents import line_model, registered_line
from tests.integration.engines import wait_for
from tests.workers.problems import course, line, predicted_tests

VALUES = [{"a": 0.1 * k, "b": 1.0 / 3.0} for k in range(5)]


def process() -> RunProcess:
    def arguments(log: Path) -> list[str]:
        return [sys.executable, "-c", BOOTSTRAP, json.dumps({"path": sys.path, "log": str(log)})]

    return RunProcess(arguments, dict(os.environ))


@pytest.fixture
def runs() -> Iterator[RunProcess]:
    made = process()
    yield made
    made.close()


def shared(problem: Problem, **limits: Any) -> tuple[str, dict[str, Any]]:
    frame, found = frame_of(problem, Settings())
    found["limits"] |= limits
    return frame, found


def below() -> list[str]:
    """Names of the processes that runs have started."""
    found = []
    for one in psutil.Process().children(recursive=True):
        try:
            ours = one.name() == "sleep" or "geoswarm.agent" in " ".join(one.cmdline())
            if ours and one.status() != psutil.STATUS_ZOMBIE:  # not what other tests have started
                found.append(one.name())
        except psutil.Error:
            continue
    return found


def test_runs_give_what_they_give_here_to_the_last_bit(runs: RunProcess) -> None:
    problem = line()
    frame, found = shared(problem)
    outcomes = list(runs.run(frame, found, VALUES, lambda: False))
    here = [course(problem).calibration.evaluate_values(values).responses["y"].tolist() for values in VALUES]
    assert [outcome.responses["y"] for outcome in outcomes] == here
    assert [outcome.index for outcome in outcomes] == list(range(5))
    assert all(outcome.reason is None and outcome.ended >= outcome.began for outcome in outcomes)


def test_a_prediction_keeps_the_parts_that_succeeded(runs: RunProcess) -> None:
    problem = predicted_tests("ln(-1 - b**2)")
    frame, found = shared(problem)
    (outcome,) = runs.run(frame, found, VALUES[:1], lambda: False)
    here = course(problem).calibration.evaluate_values(VALUES[0])
    assert (outcome.reason, outcome.message) == (here.reason, here.message)
    assert outcome.responses == {"sound.y": here.responses["sound.y"].tolist()}
    del found["keeps_parts"]  # a service of an earlier version
    (outcome,) = runs.run("other", found, VALUES[:1], lambda: False)
    assert (outcome.reason, outcome.responses) == (here.reason, {})


def test_a_model_that_fails_and_one_that_cannot_be_built(runs: RunProcess) -> None:
    problem = line(forward_model={"kind": "formula", "series": {"y": "a * x + sqrt(b)"}})
    frame, found = shared(problem)
    (outcome,) = runs.run(frame, found, [{"a": 1.0, "b": -1.0}], lambda: False)
    inline = course(problem).calibration.evaluate_values({"a": 1.0, "b": -1.0})
    assert (outcome.reason, outcome.message) == (inline.reason, inline.message)
    found["forward_model"] = {"kind": "nonsense"}
    (outcome,) = runs.run("other", found, VALUES[:1], lambda: False)
    assert outcome.reason == "bad_output"
    assert "the problem cannot be built here" in str(outcome.message)


def test_a_program_of_whoever_is_refused(runs: RunProcess) -> None:
    _, found = shared(line())
    section = {"kind": "command", "run": ["touch", "hacked"], "series": {"y": {"file": "a", "x": 1, "y": 2}}}
    (outcome,) = runs.run("other", found | {"forward_model": section}, VALUES[:1], lambda: False)
    assert outcome.reason == "bad_output"
    assert "is not registered here" in str(outcome.message)


def test_a_run_beyond_its_limit_is_killed_with_what_it_has_started(
    runs: RunProcess, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("GEOSWARM_MODELS", str(line_model(tmp_path, seconds=300.0)))
    own = process()  # with the variable
    frame, found = shared(registered_line(6), seconds=0.5, of_time="limits.seconds_per_evaluation")
    outcomes = list(own.run(frame, found, VALUES[:2], lambda: False))
    own.close()
    assert [outcome.reason for outcome in outcomes] == ["timeout", "timeout"]
    assert outcomes[0].message == "ran for longer than 0.5 s (limits.seconds_per_evaluation) and was killed"
    wait_for(lambda: "sleep" not in below(), "the end of what was started")
    runs.close()
    assert below() == []


def test_what_nobody_wants_is_killed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_MODELS", str(line_model(tmp_path, seconds=300.0)))
    own = process()
    frame, found = shared(registered_line(6))
    with pytest.raises(Unwanted) as end:
        list(own.run(frame, found, VALUES, lambda: "sleep" in below()))
    assert end.value.index == 0
    own.close()
    assert below() == []


@pytest.mark.parametrize("victim", ["run", "keeper"])
def test_a_killed_process_is_one_failed_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, victim: str) -> None:
    monkeypatch.setenv("GEOSWARM_MODELS", str(line_model(tmp_path, seconds=300.0)))
    own = process()
    frame, found = shared(registered_line(6))
    killed: list[int] = []

    def kill() -> bool:
        if killed:  # the second run need not wait for its program's process
            for one in psutil.Process().children(recursive=True):
                with suppress(psutil.Error):
                    if one.name() == "sleep":
                        one.kill()
        elif "sleep" in below():
            keeper = next(one for one in psutil.Process().children() if "trees.keeper" in " ".join(one.cmdline()))
            pid = keeper.pid if victim == "keeper" else keeper.children()[0].pid
            killed.append(pid)
            os.kill(pid, signal.SIGKILL)
        return False

    first, second = own.run(frame, found, VALUES[1:3], kill)
    own.close()
    assert first.reason == "worker_lost"
    ended = "was ended by SIGKILL" if victim == "run" else "was lost"
    assert first.message == f"the evaluation process {ended}"
    assert second.reason is None
    assert second.responses["y"] == [VALUES[2]["a"] * x + VALUES[2]["b"] for x in range(4)]


def test_the_exit_code_is_known_although_the_answers_end_before_the_process() -> None:
    late = "import os, time; os.close(1); time.sleep(0.5); os._exit(7)"
    tree = start_tree([sys.executable, "-c", late], dict(os.environ))
    with tree.answers:
        assert tree.answers.read() == b""
    assert tree.kill(ending=True) == 7
