"""Kernels are compiled before a job begins: once on a machine, told to who watches, and counted nowhere."""

from __future__ import annotations

import json
import threading
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver import warm
from geoswarm.solver.examples import example_file
from geoswarm.solver.problem import Problem, load_problem, parse_problem
from geoswarm.solver.runner import kernels
from geoswarm.solver.runner.evaluator import InlineEvaluator
from geoswarm.solver.runner.kernels import make_ready
from geoswarm.solver.warm import SAMPLES
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.settings import Settings
from geoswarm.workers.store.tables import events
from tests.integration.engines import wait_until_ended
from tests.workers.problems import line


class Compiler(InlineEvaluator):
    """Compiles for a moment, and notes what."""

    def __init__(self, log: list[str], name: str) -> None:
        super().__init__()
        self.log, self.name = log, name

    def load(self, group: str, unwanted: Callable[[], bool]) -> None:  # noqa: ARG002
        time.sleep(0.1)
        self.log.append(f"{self.name} {group}")
        self.loaded.add(group)


@pytest.fixture
def nothing_compiled(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The cache folder is new and empty."""
    for module in (warm, kernels):
        monkeypatch.setattr(module, "settle", lambda: tmp_path)
    monkeypatch.setattr(warm, "_ready", set())


def oedometer(**changes: Any) -> Problem:
    return parse_problem(SAMPLES["oedometer"] | changes)


@pytest.mark.usefixtures("nothing_compiled")
def test_of_several_workers_one_compiles() -> None:
    log: list[str] = []
    told: list[tuple[int, int, float | None]] = []

    def tell(compiled: int, missing: int, seconds: float | None) -> None:
        told.append((compiled, missing, seconds))

    workers = [Compiler(log, name) for name in "abc"]
    threads = [
        threading.Thread(target=make_ready, args=(worker, oedometer()), kwargs={"tell": tell}) for worker in workers
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert sorted(log) == ["a oedometer", "b oedometer", "c oedometer"]  # the others load what the first one compiled
    assert told[0] == (0, 1, None)
    assert told[1][:2] == (1, 1)
    assert told[1][2] is not None
    assert told[1][2] >= 0.1
    assert make_ready(workers[0], oedometer(), tell=tell)
    assert (len(log), len(told)) == (3, 2)


@pytest.mark.usefixtures("nothing_compiled")
def test_who_waits_is_told_how_many_groups_are_compiled() -> None:
    told: list[tuple[int, int]] = []
    with example_file("slope") as path:
        problem = load_problem(path)
    assert make_ready(Compiler([], "a"), problem, tell=lambda compiled, missing, _: told.append((compiled, missing)))
    assert told == [(0, 4), (1, 4), (2, 4), (3, 4), (4, 4)]


@pytest.mark.usefixtures("nothing_compiled")
def test_a_job_without_kernels_waits_for_nothing() -> None:
    log: list[str] = []
    assert make_ready(Compiler(log, "a"), line())
    assert log == []


@pytest.mark.usefixtures("nothing_compiled")
def test_a_worker_that_is_to_end_does_not_compile() -> None:
    log: list[str] = []
    assert not make_ready(Compiler(log, "a"), oedometer(), unwanted=lambda: True)
    assert log == []


@pytest.mark.slow
def test_the_first_job_of_an_installation(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither its seconds nor the limit of an evaluation count the time of compiling."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "kernels"))
    problem = oedometer(
        method={"kind": "monte_carlo", "samples": 20},
        limits={"seconds_per_evaluation": 3},
        failures={"policy": "fail"},
    )
    with open_engine(Settings(database_url=f"sqlite:///{tmp_path / 'jobs.db'}", workers=2)) as engine:
        job = wait_until_ended(engine.service, engine.service.submit(problem)[0].id)
        rows = engine.service.store.read(lambda c: c.execute(events.select().order_by(events.c.id)).all())
    assert (job.state, job.evaluations, job.failed_evaluations) == ("finished", 20, 0)
    found = [(row.kind, json.loads(row.data)) for row in rows]
    kernel_events = [data["seconds"] for kind, data in found if kind == "kernels"]
    assert kernel_events[0] is None
    assert len(kernel_events) == 2
    course = [data["state"] if kind == "state" else kind for kind, data in found]
    assert course[:4] == ["queued", "kernels", "kernels", "running"]  # its seconds are counted from there
    assert [path.name.split("-")[1] for path in (tmp_path / "kernels").glob("*/compiled-*")] == ["oedometer"]
