"""Runs that hang, eat memory, crash or fail in a real engine: limits, retries, policies, pausing, another try."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest

from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.errors import InvalidTransitionError, NothingToRetryError
from geoswarm.workers.hosts.engine import Engine, open_engine
from geoswarm.workers.settings import Settings
from tests.integration.engines import process_exists, wait_for, wait_until_ended
from tests.variants import variants
from tests.workers.problems import line

pytestmark = pytest.mark.usefixtures("misbehaving_models")

Open = Callable[..., Any]
LIMIT = 4.0  # what ends by itself does so earlier on any machine


def misbehaving(behaviour: str, *, above: float = 0.0, samples: int = 6, **changes: Any) -> Problem:
    model = {key: changes.pop(key) for key in ("seconds", "cured", "notes") if key in changes}
    document: dict[str, Any] = {
        "name": behaviour,
        "forward_model": {"kind": "misbehaving", "behaviour": behaviour, "above": above, **model},
        "parameters": {"slope": {"lower": -1, "upper": 1}},
        "observations": [{"series": "y", "points": {"x": [0, 1, 2], "y": [0, 1, 2]}}],
        "method": {"kind": "monte_carlo", "samples": samples, "batch": samples},
        "seed": 3,
    }
    return parse_problem(document | changes)


@pytest.fixture
def engine_with(tmp_path: Path) -> Open:
    @contextmanager
    def opened(**changes: Any) -> Iterator[Engine]:
        short = {"lease_seconds": 60.0, "heartbeat_seconds": 0.5, "sweep_seconds": 0.5, "workers": 2}
        url = f"sqlite:///{tmp_path / 'jobs.db'}"
        with open_engine(Settings(database_url=url, **(short | changes))) as engine:
            yield engine

    return opened


def pids(notes: Path) -> list[int]:
    return [int(text) for text in notes.read_text().split()] if notes.exists() else []


@pytest.mark.parametrize(
    ("behaviour", "limits", "reason"),
    variants(
        [
            ("for_ever", {"seconds_per_evaluation": LIMIT}, "timeout"),
            ("fork", {"seconds_per_evaluation": LIMIT}, "timeout"),
            ("eat", {"memory_mb": 100, "seconds_per_evaluation": 240}, "killed_memory"),
            ("crash", {}, "worker_lost"),
        ],
        {"crash"},
    ),
)
def test_bad_runs_are_failed_evaluations_and_the_job_goes_on(
    engine_with: Open, tmp_path: Path, behaviour: str, limits: dict[str, float], reason: str
) -> None:
    notes = tmp_path / "pids"
    problem = misbehaving(behaviour, notes=str(notes), limits=limits)
    with engine_with() as engine:
        job = wait_until_ended(engine.service, engine.service.submit(problem)[0].id)
        views = list(engine.service.iterate_evaluations(job.id))
        tries = engine.service.attempts(job.id, 0, next(v.particle for v in views if v.reason))
    bad = [view for view in views if view.parameters["slope"] > 0]
    good = [view for view in views if view.parameters["slope"] <= 0]
    assert (len(bad), len(good)) == (2, 4)
    assert {view.reason for view in bad} == {reason}
    assert {view.state for view in good} == {"finished"}
    assert (job.state, job.failed_evaluations, job.stop_reasons) == ("finished", 2, ["samples_completed"])
    if reason == "timeout":
        assert all(view.seconds is not None and view.seconds >= LIMIT for view in bad)
    tries_of_each = 3 if reason == "worker_lost" else 1
    assert [view.attempts for view in bad] == [tries_of_each] * 2
    assert [t.outcome for t in tries] == [reason] * tries_of_each
    assert [t.counted for t in tries] == [False] * (tries_of_each - 1) + [True]
    assert not any(process_exists(pid) for pid in pids(notes))


@pytest.mark.slow
def test_a_job_whose_every_run_fails_ends_failed_and_tells_why(engine_with: Open) -> None:
    problem = misbehaving("diverge", above=-2, failures={"retry": {"diverged": 1}})
    with engine_with() as engine:
        job = wait_until_ended(engine.service, engine.service.submit(problem)[0].id)
        (first, *_) = engine.service.evaluations(job.id, state="failed").items
        tries = engine.service.attempts(job.id, first.generation, first.particle)
    assert job.state == "failed"
    assert job.error == "all 6 evaluations failed (6 diverged); first message: no equilibrium in stage 2"
    assert first.log == "iteration 17: residual 1e+30\n"
    assert [(t.number, t.outcome, t.counted, t.log) for t in tries] == [
        (1, "diverged", False, "iteration 17: residual 1e+30\n"),
        (2, "diverged", True, "iteration 17: residual 1e+30\n"),
    ]


def test_a_policy_ends_the_job_at_the_first_failure_here_and_in_process(engine_with: Open) -> None:
    problem = misbehaving("diverge", failures={"policy": {"diverged": "fail"}})
    with engine_with(workers=1) as engine:
        job = wait_until_ended(engine.service, engine.service.submit(problem)[0].id)
    result = calibrate(problem)
    assert (job.state, job.stop_reasons) == (result.state, list(result.stop_reasons)) == ("failed", [])
    assert job.error == result.error
    assert job.error is not None
    assert job.error.endswith("failed (diverged), which ends the job (failures.policy): no equilibrium in stage 2")


@pytest.mark.parametrize("action", variants(["pause", "cancel"], {"pause"}))
def test_pause_and_cancel_reach_a_run_in_its_middle(engine_with: Open, tmp_path: Path, action: str) -> None:
    notes = tmp_path / "pids"
    cured = tmp_path / "cured"
    problem = misbehaving("for_ever", above=-2, samples=2, notes=str(notes), cured=str(cured))
    with engine_with() as engine:
        service = engine.service
        job = service.submit(problem)[0].id
        wait_for(lambda: len(pids(notes)) == 2, "two runs under way")
        getattr(service, action)(job)
        wait_for(lambda: not any(process_exists(pid) for pid in pids(notes)), "the end of both runs")
        wait_for(lambda: not any(w.state == "busy" for w in service.workers()), "idle workers")
        if action == "pause":
            cured.touch()
            service.resume(job)
            assert wait_until_ended(service, job).state == "finished"
            assert [t.outcome for t in service.attempts(job, 0, 0)] == ["stopped", "finished"]
        else:
            assert service.get(job).state == "cancelled"


def test_failed_runs_are_run_again_and_only_they(engine_with: Open, tmp_path: Path) -> None:
    cured = tmp_path / "cured"
    problem = misbehaving(
        "diverge", above=-0.2, samples=12, cured=str(cured), method={"kind": "monte_carlo", "samples": 12, "batch": 4}
    )
    with engine_with() as engine:
        service = engine.service
        job = wait_until_ended(service, service.submit(problem)[0].id)
        before = list(service.iterate_evaluations(job.id))
        failed = [v.particle for v in before if v.state == "failed"]
        assert 0 < len(failed) == job.failed_evaluations < 12
        cured.touch()
        again, number = service.retry_failed(job.id)
        assert (again.state, again.retrying, number) == ("running", True, len(failed))
        job = wait_until_ended(service, job.id)
        after = list(service.iterate_evaluations(job.id))
        best = service.best(job.id)
        calm = calibrate(problem)
        with pytest.raises(NothingToRetryError, match="no failed evaluation"):
            service.retry_failed(job.id)
    assert (job.state, job.retrying, job.failed_evaluations) == ("finished", False, 0)
    assert [v.parameters for v in before] == [v.parameters for v in after]
    assert [v.objective for v in after] == [r.evaluation.objective for r in calm.history]
    assert [v.attempts for v in after] == [2 if v.state == "failed" else 1 for v in before]
    assert [v.started_at for v in after if v.attempts == 1] == [v.started_at for v in before if v.state != "failed"]
    assert best is not None
    assert (best.objective, job.objective) == (calm.objective, calm.objective)
    assert job.parameters == calm.parameters


@pytest.mark.slow
def test_a_job_that_one_failure_ended_goes_on_as_if_it_had_not_happened(engine_with: Open, tmp_path: Path) -> None:
    cured = tmp_path / "cured"
    swarm = {
        "method": {"kind": "particle_swarm", "particles": 4},
        "stopping": {"max_evaluations": 40},
        "failures": {"policy": "fail"},
    }
    problem = misbehaving("diverge", cured=str(cured), **swarm)
    with engine_with() as engine:
        service = engine.service
        job = wait_until_ended(service, service.submit(problem)[0].id)
        assert (job.state, job.generations) == ("failed", 0)
        cured.touch()
        calm = calibrate(problem)
        assert service.retry_failed(job.id)[0].state == "running"
        job = wait_until_ended(service, job.id)
        found = [(v.objective, tuple(v.parameters.values())) for v in service.iterate_evaluations(job.id)]
    assert (job.state, job.error, job.stop_reasons) == ("finished", None, ["max_evaluations"])
    expected = [(r.evaluation.objective, tuple(r.evaluation.parameters.tolist())) for r in calm.history]
    assert found == expected


@pytest.mark.slow
def test_another_try_can_be_cancelled_and_needs_a_job_at_rest(engine_with: Open, tmp_path: Path) -> None:
    cured = tmp_path / "cured"
    failing = misbehaving("diverge", cured=str(cured))
    with engine_with(workers=1) as engine:
        service = engine.service
        job = wait_until_ended(service, service.submit(failing)[0].id)
        blocker = service.submit(misbehaving("for_ever", above=-2, priority=10))[0].id
        wait_for(lambda: service.get(blocker).state == "running", "a busy worker")
        with pytest.raises(InvalidTransitionError, match="accepted states: paused, finished, failed, cancelled"):
            service.retry_failed(blocker)
        service.retry_failed(job.id)
        assert service.get(job.id).retrying
        assert service.cancel(job.id).state == "finished"
        service.cancel(blocker)
        assert [v.reason for v in service.iterate_evaluations(job.id)].count("diverged") == 2
        assert service.get(job.id).failed_evaluations == 2


@pytest.mark.slow
def test_an_overdue_run_is_given_to_another_worker_too_and_the_first_result_counts(
    engine_with: Open, tmp_path: Path
) -> None:
    cured, notes = tmp_path / "cured", tmp_path / "pids"
    problem = misbehaving("for_ever_once", samples=6, cured=str(cured), notes=str(notes))
    with engine_with(workers=4, overdue_seconds=3.0) as engine:
        service = engine.service
        job = service.submit(problem)[0].id
        ended = wait_until_ended(service, job)
        tries = [service.attempts(job, 0, v.particle) for v in service.iterate_evaluations(job)]
        wait_for(lambda: not any(process_exists(pid) for pid in pids(notes)), "the end of the slow ones")
        assert ended.state == "finished"
        outcomes = {tuple(t.outcome for t in of_one) for of_one in tries}
        first, second = {"overdue", "late"}, {"superseded", "late"}  # a slow one may have ended after all
        assert any(of_one[0] in first for of_one in outcomes if len(of_one) == 2)
        assert outcomes <= {("finished",), *((lost, "finished") for lost in first | second)}
        assert all(sorted(t.number for t in of_one) == list(range(1, len(of_one) + 1)) for of_one in tries)
        assert all(sum(t.counted for t in of_one) == 1 for of_one in tries)


@pytest.mark.slow  # 58 s; turns of jobs are also tested in tests/workers/test_queue.py
def test_a_short_job_is_not_starved_by_a_long_one(engine_with: Open) -> None:
    long = line(method={"kind": "monte_carlo", "samples": 100_000, "batch": 1000}, stopping={})
    with engine_with(workers=1) as engine:
        service = engine.service
        first = service.submit(long)[0].id
        wait_for(lambda: service.get(first).generations >= 1, "progress of the long job")
        short = service.submit(line(method={"kind": "monte_carlo", "samples": 10, "batch": 5}, stopping={}))[0].id
        ended = wait_until_ended(service, short)
        assert ended.state == "finished"
        assert service.get(first).state == "running"
        service.cancel(first)
        ends = [g.finished_at for g in service.generations(first)]
    # Counted in generations of the long job, not in seconds, which a busy machine stretches: the worker turns to the
    # short one after each lease, which holds a few generations of such short runs, not after the hundredth.
    assert ended.finished_at is not None
    assert sum(ended.created_at < end < ended.finished_at for end in ends) <= 25


@pytest.mark.slow
def test_slots_limit_how_many_run_at_once(engine_with: Open) -> None:
    with engine_with(workers=3, slots={"misbehaving": 1}) as engine:
        service = engine.service
        jobs = [service.submit(misbehaving("sleep", above=-2, seconds=0.2, samples=5))[0].id for _ in range(2)]
        busy = []

        def ended() -> bool:
            busy.append(sum(worker.state == "busy" for worker in service.workers()))
            return all(service.get(job).state == "finished" for job in jobs)

        wait_for(ended, "the end of both jobs")
        spans = sorted((v.started_at, v.finished_at) for job in jobs for v in service.iterate_evaluations(job))
    assert max(busy) <= 1
    assert len(spans) == 10
    assert all(before[1] <= after[0] for before, after in itertools.pairwise(spans))


@pytest.mark.slow
def test_workers_of_one_kind_leave_others_alone(engine_with: Open) -> None:
    with engine_with(workers=2, kinds=("misbehaving",)) as engine:
        service = engine.service
        other = service.submit(line())[0].id
        for _ in range(3):  # between which the workers look for other work
            mine = service.submit(misbehaving("sleep"))[0].id
            assert wait_until_ended(service, mine).state == "finished"
        assert service.get(other).state == "queued"
