"""Forward models that behave badly: their own run fails for the right reason, and no other run notices anything."""

from __future__ import annotations

import itertools
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runner.evaluator import BuildError, EvaluationCancelled, RunLimits
from geoswarm.solver.runner.runner import Runner, _EndedError, _SpoiledError
from geoswarm.solver.runner.shared_state import Progress
from geoswarm.solver.runner.wire import Outcome
from geoswarm.solver.system.processes import descendants
from tests.integration.engines import wait_for
from tests.models.geoswarm_bad_models import REASONS
from tests.solver.runner.test_runner import positions

pytestmark = pytest.mark.usefixtures("misbehaving_models")

LIMITS = RunLimits(seconds=4.0, memory_mb=300.0)
PATIENT = RunLimits(seconds=120.0, memory_mb=300.0)  # on a busy machine memory fills slowly
SLOPES = (-1.0, 1.0, -2.0)


@pytest.fixture(scope="module")
def runners() -> Iterator[list[Runner]]:
    """One runner for all tests of this module: what one test leaves behind would show in the next."""
    made: list[Runner] = []
    yield made
    for runner in made:
        runner.close()


@pytest.fixture
def runner(misbehaving_models: None, runners: list[Runner]) -> Runner:  # noqa: ARG001
    if not runners:
        runners.append(Runner())
        runners[0].start()
    return runners[0]


def bad(behaviour: str) -> Calibration:
    document = {
        "forward_model": {"kind": "bad", "behaviour": behaviour},
        "parameters": {"slope": {"lower": -5, "upper": 5}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
        "method": {"kind": "monte_carlo", "samples": 4},
        "seed": 1,
    }
    return Calibration(parse_problem(document), 1)


def evaluated(runner: Runner, job: str, behaviour: str, slopes: tuple[float, ...] = SLOPES) -> list[Any]:
    """Reason or response of each run."""
    limits = LIMITS if REASONS.get(behaviour) == "timeout" else PATIENT
    outcomes = runner.run(job, bad(behaviour), positions(*slopes), limits)
    return [o.evaluation.reason or o.evaluation.responses["y"].tolist() for o in outcomes]


def expected(slopes: tuple[float, ...], reason: str | None = None) -> list[Any]:
    return [reason if slope > 0.0 and reason else (slope * np.arange(3.0)).tolist() for slope in slopes]


@pytest.mark.parametrize("behaviour", REASONS)
def test_a_bad_model_spoils_its_own_run_alone(runner: Runner, behaviour: str) -> None:
    found, wanted = evaluated(runner, f"job of {behaviour}", behaviour), expected(SLOPES, REASONS[behaviour])
    # an answer may arrive before the end of its process is noticed
    answers = expected(SLOPES) if behaviour == "end behind its answer" else wanted
    assert all(one in either for one, *either in zip(found, wanted, answers, strict=True)), found
    assert evaluated(runner, f"job after {behaviour}", "good") == expected(SLOPES)
    pid = runner._fork_server.pid
    assert pid is not None
    assert len(descendants(pid)) == 1  # the process of the good job; nothing else is left


def test_a_growing_process_is_renewed_and_no_evaluation_is_blamed(runner: Runner) -> None:
    slopes = tuple(float(number) for number in range(1, 13))  # 60 MiB each, 300 MiB are granted
    for size in (12, 5, 1):
        found: list[Any] = []
        for first in range(0, 12, size):
            found += evaluated(runner, f"leak {size}", "leak memory", slopes[first : first + size])
        assert found == expected(slopes)


@pytest.mark.parametrize("answered", range(4))
@pytest.mark.parametrize("noted", [-2, -1, 0, 1, 2, 3, 10**6])
@pytest.mark.parametrize("ending", ["ended", "spoiled", "never mind"])
def test_a_process_that_ends_anywhere_is_blamed_on_no_answered_evaluation(
    monkeypatch: pytest.MonkeyPatch, ending: str, noted: int, answered: int
) -> None:
    calibration, asked = bad("good"), positions(-1.0, -2.0, -3.0)
    ends = 3

    def batch(_: object, _job: str, _made: object, part: Any, *_others: object) -> Iterator[Outcome]:
        nonlocal ends
        ends -= 1
        for position in part[: answered if ends >= 0 else None]:
            yield Outcome(calibration.evaluate(position), None, 0.0, 0.0)
        if ends >= 0:
            match ending:
                case "ended":
                    raise _EndedError("worker_lost", "it ended", Progress(noted, 0.0, 0.0), None)
                case "spoiled":
                    raise _SpoiledError(noted)
                case _:
                    raise EvaluationCancelled(noted)

    monkeypatch.setattr(Runner, "_batch", batch)
    made = Runner()
    outcomes: list[Outcome] = []
    killed: int | None = None
    try:
        for outcome in made.run("job", calibration, asked, LIMITS):
            outcomes.append(outcome)  # noqa: PERF402  those before a EvaluationCancelled count
    except EvaluationCancelled as end:
        killed = end.index
    finally:
        made.close()
    assert (killed is None) == (ending != "never mind" or answered == 3)
    if killed is not None:
        assert len(outcomes) == answered <= killed < 3
        return
    assert [outcome.evaluation.parameters.tolist() for outcome in outcomes] == asked.tolist()
    assert ending == "ended" or not any(outcome.evaluation.reason for outcome in outcomes)
    assert not any(outcome.evaluation.reason for outcome in outcomes[:answered])


def test_output_stays_bounded_while_it_is_written(runner: Runner) -> None:
    evaluated(runner, "writes", "leave a thread that writes", (1.0,))
    size = os.fstat(runner._output).st_size
    time.sleep(0.5)
    assert os.fstat(runner._output).st_size == size  # whatever wrote is gone
    sizes: list[int] = []

    def look() -> None:
        sizes.append(os.fstat(runner._output).st_size)

    for outcome in runner.run(
        "writes on",
        bad("write without end"),
        positions(1.0),
        LIMITS,
        unwanted=look,
    ):
        assert outcome.evaluation.reason == "timeout"
        assert outcome.log is not None
    assert any(later < earlier for earlier, later in itertools.pairwise(sizes)), sizes  # shortened again and again


@pytest.mark.parametrize(
    ("builds", "why"),
    [
        ("crash", "the evaluation process was ended by SIGSEGV"),
        ("hang", "the problem was not built within 1 s in the evaluation process"),
        ("eat", "more than 300 MiB"),
    ],
)
def test_a_problem_that_cannot_be_built_harms_nobody(
    runner: Runner, monkeypatch: pytest.MonkeyPatch, builds: str, why: str
) -> None:
    document = bad("good").problem.document()
    document["forward_model"]["builds"] = builds
    with monkeypatch.context() as patch:
        patch.setattr("geoswarm.solver.runner.runner.BUILD_SECONDS", 1.0 if builds == "hang" else 120.0)
        with pytest.raises(BuildError, match=f"could not be built, tried 3 times: .*{why}"):
            runner.build(f"job {builds}", document, 1, LIMITS)
    assert evaluated(runner, f"job after {builds}", "good") == expected(SLOPES)


def test_forward_models_see_no_secret(
    misbehaving_models: None,  # noqa: ARG001
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setenv("GEOSWARM_API_KEY", "secret")
    monkeypatch.setenv("GEOSWARM_DATABASE_URL", "sqlite:///secret.db")
    monkeypatch.setenv("LICENSE_SERVER", "lm@host")
    runner = Runner(("LICENSE_*",))
    try:
        list(runner.run("job", bad("good"), positions(-1.0), LIMITS))
        fork_server = runner._fork_server.pid
        assert fork_server is not None
        for pid in (fork_server, *descendants(fork_server)):
            environment = Path(f"/proc/{pid}/environ").read_bytes()
            assert b"secret" not in environment
            assert b"LICENSE_SERVER=lm@host" in environment
    finally:
        runner.close()


def test_a_stopped_fork_server_ends_with_its_worker(tmp_path: Path) -> None:
    code = (
        "import os, signal, sys, time\n"
        "from tests.solver.runner.test_bad_models import bad, LIMITS, positions\n"
        "from geoswarm.solver.runner.runner import Runner\n"
        "runner = Runner()\n"
        "list(runner.run('job', bad('good'), positions(-1.0), LIMITS))\n"
        "os.kill(runner._fork_server.pid, signal.SIGSTOP)\n"
        "print(runner._fork_server.pid, flush=True)\n"
        "time.sleep(600)\n"
    )
    root = Path(__file__).parents[3]
    paths = os.pathsep.join([str(root / "tests" / "models"), str(root)])
    with subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, cwd=tmp_path, env={**os.environ, "PYTHONPATH": paths}
    ) as worker:
        try:
            assert worker.stdout is not None
            fork_server = int(worker.stdout.readline())
            assert descendants(fork_server)
        finally:
            worker.kill()
    wait_for(lambda: not Path(f"/proc/{fork_server}").exists(), "the end of the fork server")
