"""Runs that hang, fork or eat memory, pausing, cancelling and the limit of time, through real Celery workers."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from geoswarm.workers.hosts.engine import open_engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from tests.integration.engines import STEADY, Gated, celery_workers, process_exists, wait_for, wait_until_ended
from tests.integration.test_failures import LIMIT, misbehaving, pids

pytestmark = pytest.mark.usefixtures("misbehaving_models")


@pytest.fixture
def settings(fresh_postgres_url: str, fresh_redis_url: str) -> Settings:
    return Settings(database_url=fresh_postgres_url, broker_url=fresh_redis_url, **STEADY)


@contextmanager
def running(settings: Settings, processes: int) -> Iterator[JobService]:
    with open_engine(settings) as engine, celery_workers(settings, concurrency=processes):
        wait_for(lambda: len(engine.service.workers()) == processes, f"{processes} processes")
        yield engine.service


@pytest.mark.slow  # the embedded service has the same evaluation processes
def test_bad_runs_end_within_their_limits_and_leave_nothing(settings: Settings, tmp_path: Path) -> None:
    asked = {
        "for_ever": ({"seconds_per_evaluation": LIMIT}, "timeout"),
        "fork": ({"seconds_per_evaluation": LIMIT}, "timeout"),
        "eat": ({"memory_mb": 100, "seconds_per_evaluation": 240}, "killed_memory"),
    }
    with running(settings, 3) as service:
        ids = {
            behaviour: service.submit(misbehaving(behaviour, notes=str(tmp_path / behaviour), limits=limits))[0].id
            for behaviour, (limits, _) in asked.items()
        }
        for behaviour, (_, reason) in asked.items():
            job = wait_until_ended(service, ids[behaviour])
            assert (job.state, job.failed_evaluations, job.stop_reasons) == ("finished", 2, ["samples_completed"])
            views = list(service.iterate_evaluations(job.id))
            bad = [view for view in views if view.parameters["slope"] > 0]
            assert [(view.state, view.reason, view.attempts) for view in bad] == [("failed", reason, 1)] * 2
            assert {view.state for view in views if view not in bad} == {"finished"}
            if reason == "timeout":
                assert all(view.seconds is not None and view.seconds >= LIMIT for view in bad)
            assert len(pids(tmp_path / behaviour)) >= 2
            assert not any(process_exists(pid) for pid in pids(tmp_path / behaviour))


@pytest.mark.slow
def test_pause_and_cancel_reach_runs_in_their_middle(settings: Settings, tmp_path: Path) -> None:
    notes = {action: tmp_path / action for action in ("pause", "cancel")}
    cured = tmp_path / "cured"
    with running(settings, 2) as service:
        ids = {
            action: service.submit(misbehaving("for_ever", above=-2, samples=1, notes=str(path), cured=str(cured)))[
                0
            ].id
            for action, path in notes.items()
        }
        wait_for(lambda: all(len(pids(path)) == 1 for path in notes.values()), "two runs under way")
        for action, path in notes.items():
            getattr(service, action)(ids[action])
            wait_for(lambda path=path: not process_exists(pids(path)[0]), f"the end of the run ({action})")
        cured.touch()
        service.resume(ids["pause"])
        assert wait_until_ended(service, ids["pause"]).state == "finished"
        assert [t.outcome for t in service.attempts(ids["pause"], 0, 0)] == ["stopped", "finished"]
        assert service.get(ids["cancel"]).state == "cancelled"


@pytest.mark.slow
def test_the_time_of_a_job_goes_on_after_a_restart(settings: Settings, tmp_path: Path) -> None:
    gated = Gated(tmp_path, {"max_seconds": 15.0})  # enough for a few generations on any machine
    with running(settings, 1) as service:
        job_id = service.submit(gated.problem)[0].id
        gated.go_on(service, job_id)
    with open_engine(settings) as engine:  # nobody works
        before = engine.service.get(job_id)
        assert before.state == "running"
    gated.gate.open()
    with running(settings, 1) as service:
        after = service.get(job_id)
        assert before.seconds is not None
        assert after.seconds is not None
        assert after.seconds >= before.seconds > 0.0
        job = wait_until_ended(service, job_id)
        assert (job.state, job.stop_reasons) == ("finished", ["max_seconds"])
        assert job.seconds is not None
        assert job.generations >= before.generations
        assert job.seconds >= 15.0
