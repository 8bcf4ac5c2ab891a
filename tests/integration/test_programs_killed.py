"""Workers that are killed while programs of theirs run: the history is that of the undisturbed run, bit for bit.

The short form kills a few, the slow one many.
"""

from __future__ import annotations

import contextlib
import os
import threading
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, TypeAlias

import psutil
import pytest

from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult
from geoswarm.solver.runs import evaluators
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.integration.engines import STEADY, Gate, celery_workers, wait_for, wait_until_ended
from tests.solver.external.zoo import zoo_problem

# parameters, objective, misfits, responses, reason
Bits: TypeAlias = tuple[tuple[float, ...], float | None, dict[str, float], dict[str, list[float]], str | None]

FORMS = [pytest.param(3, 24, id="short"), pytest.param(40, 400, id="long", marks=pytest.mark.slow)]
pytestmark = pytest.mark.timeout(1200)


# What a program does first: see Gate.
TURN = """
    numbers = os.open({numbers!r}, os.O_WRONLY | os.O_APPEND)
    os.write(numbers, b".")
    number = os.lseek(numbers, 0, os.SEEK_CUR)
    while number > int(Path({gate!r}).read_text()):
        time.sleep(0.01)
"""


@pytest.fixture
def gate(tmp_path: Path) -> Gate:
    return Gate(tmp_path)


@pytest.fixture
def problem_of(zoo_models: Path, gate: Gate) -> Callable[[int], Problem]:
    """Problems on a program that waits at the gate, and fails for some values, by their evaluations."""
    program = zoo_models / "exit_3" / "zoo.py"
    text = program.read_text()
    main = "def main() -> None:\n"
    assert main in text
    program.write_text(text.replace(main, main + TURN.format(numbers=str(gate.numbers), gate=str(gate.file))))

    def problem(evaluations: int) -> Problem:
        search: dict[str, Any] = {
            "method": {"kind": "particle_swarm", "particles": 4, "acceleration": "none"},
            "stopping": {"max_evaluations": evaluations},
            "failures": {"retry": {"worker_lost": 1000}},  # one may lose any number of workers here
        }
        return zoo_problem("exit_3", **search)

    return problem


def programs(folder: Path) -> list[psutil.Process]:
    """Programs that run now, in a run folder below this one."""
    found = []
    for one in psutil.process_iter():
        with contextlib.suppress(psutil.Error):
            if Path(one.cwd()).is_relative_to(folder) and "running-" in one.cwd():
                found.append(one)
    return found


def kill_one(folder: Path, workers: Sequence[int] = ()) -> bool:
    """Kill the process that waits for a program, or a worker above it; False when no program runs now."""
    for program in programs(folder):
        with contextlib.suppress(psutil.Error):
            above = program.parents()
            victims = [one for one in above if one.pid in workers] if workers else above[:1]
            if victims and victims[0].pid not in (1, os.getpid()):
                victims[0].kill()
                return True
    return False


def calm(problem: Problem, gate: Gate) -> list[Bits]:
    """What the undisturbed run gives; the gate is opened for it."""
    gate.open()
    return told(calibrate(problem))


def told(result: CalibrationResult) -> list[Bits]:
    """What a run in process has given."""
    return [
        (
            tuple(one.parameters.tolist()),
            one.objective,
            dict(one.misfits),
            {series: values.tolist() for series, values in one.responses.items()},
            one.reason,
        )
        for one in (record.evaluation for record in result.history)
    ]


def recorded(service: JobService, job_id: str) -> list[Bits]:
    """What an engine has stored."""
    return [
        (
            tuple(one.parameters.values()),
            one.objective,
            one.misfits,
            {series: curve.y for series, curve in (one.responses or {}).items()},
            one.reason,
        )
        for one in service.iterate_evaluations(job_id, responses=True)
    ]


def disturbed(service: JobService, problem: Problem, kills: int, folder: Path, gate: Gate) -> list[Bits]:
    """Run a job while evaluation processes and, every third time, whole workers are killed."""
    job_id = service.submit(problem)[0].id
    for number in range(kills):

        def killed(every: int = number) -> bool:
            assert service.get(job_id).state in ("queued", "running"), "it has ended before all kills were made"
            pids = [worker.pid for worker in service.workers()] if every % 3 == 2 else []
            return kill_one(folder, pids)

        wait_for(killed, "a program to run")
        done = service.get(job_id).evaluations

        def progress(before: int = done) -> bool:
            if gate.waiting:
                gate.let_through()
            return service.get(job_id).evaluations > before

        wait_for(progress, "progress")
    gate.open()
    job = wait_until_ended(service, job_id)
    assert job.state == "finished", job.error
    tries = [one.attempts for one in service.iterate_evaluations(job_id)]
    assert sum(tries) >= len(tries) + kills
    wait_for(lambda: not programs(folder), "the end of all programs")
    return recorded(service, job_id)


@pytest.mark.parametrize(("kills", "evaluations"), FORMS)
@pytest.mark.slow
def test_killed_processes_of_a_run_change_nothing(
    kills: int,
    evaluations: int,
    problem_of: Callable[[int], Problem],
    gate: Gate,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    problem = problem_of(evaluations)
    undisturbed = calm(problem, gate)
    gate.let_through()  # and no more
    monkeypatch.setattr(evaluators, "_START_SECONDS", 0.0)  # processes from the first evaluation on
    done, ended, ones = 0, threading.Event(), list[int]()

    def kill() -> None:
        while len(ones) < kills and not ended.wait(0.01):
            before = done
            if kill_one(tmp_path):
                ones.append(before)
                while done == before and not ended.wait(0.01):
                    if gate.waiting:
                        gate.let_through()
        gate.open()

    def count(_: object) -> None:
        nonlocal done
        done += 1

    killer = threading.Thread(target=kill)
    killer.start()
    try:
        result = calibrate(problem, workers=2, on_generation=count)
    finally:
        ended.set()
        killer.join()
    assert len(ones) == kills
    assert told(result) == undisturbed
    assert None in {bits[-1] for bits in undisturbed}
    assert "diverged" in {bits[-1] for bits in undisturbed}
    assert not programs(tmp_path)


@pytest.mark.slow
@pytest.mark.parametrize(("kills", "evaluations"), FORMS)
def test_killed_workers_of_the_embedded_engine_change_nothing(
    kills: int, evaluations: int, problem_of: Callable[[int], Problem], gate: Gate, tmp_path: Path
) -> None:
    problem = problem_of(evaluations)
    settings = Settings(database_url=f"sqlite:///{tmp_path / 'jobs.db'}", workers=2, **STEADY)
    with open_engine(settings) as engine:
        found = disturbed(engine.service, problem, kills, tmp_path, gate)
    assert found == calm(problem, gate)


@pytest.mark.slow
@pytest.mark.parametrize(("kills", "evaluations"), FORMS)
def test_killed_workers_of_celery_change_nothing(
    kills: int,
    evaluations: int,
    problem_of: Callable[[int], Problem],
    gate: Gate,
    tmp_path: Path,
    fresh_postgres_url: str,
    fresh_redis_url: str,
) -> None:
    problem = problem_of(evaluations)
    settings = Settings(database_url=fresh_postgres_url, broker_url=fresh_redis_url, **STEADY)
    with open_engine(settings) as engine, celery_workers(settings, concurrency=2):
        found = disturbed(engine.service, problem, kills, tmp_path, gate)
    assert found == calm(problem, gate)
