from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from geoswarm.workers.hosts.healthcheck import main, what_is_wrong
from geoswarm.workers.identity import Identity
from geoswarm.workers.queries.workers import mark_lost, register_worker
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store


def test_a_worker_of_this_machine_must_be_alive(store: Store, settings: Settings) -> None:
    assert what_is_wrong(settings, worker=False) is None
    assert "no worker process on this machine" in str(what_is_wrong(settings, worker=True))
    identity = Identity.new("celery")
    store.write(lambda connection: register_worker(connection, identity))
    assert what_is_wrong(settings, worker=True) is None
    store.write(lambda connection: mark_lost(connection, [identity.id]))
    assert what_is_wrong(settings, worker=True) is not None


@pytest.mark.usefixtures("store")
def test_a_broker_that_does_not_answer_is_reported(settings: Settings, free_port: int) -> None:
    told = what_is_wrong(settings.model_copy(update={"broker_url": f"redis://127.0.0.1:{free_port}/0"}), worker=False)
    assert told is not None
    assert f"127.0.0.1:{free_port}" in told


def test_the_exit_code_tells(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("GEOSWARM_DATABASE_URL", f"sqlite:///{tmp_path}/jobs.db")
    assert main([]) == 1
    assert not (tmp_path / "jobs.db").exists()  # looking makes no database
    Store(Settings.from_environment()).close()
    assert main([]) == 0
    assert main(["--worker"]) == 1
    monkeypatch.setenv("GEOSWARM_DATABASE_URL", "sqlite:////nowhere/at/all.db")
    assert main([]) == 1


def test_it_runs_as_a_program(tmp_path: Path) -> None:
    Store(Settings(database_url=f"sqlite:///{tmp_path}/jobs.db")).close()
    done = subprocess.run(
        [sys.executable, "-m", "geoswarm.workers.hosts.healthcheck", "--worker"],
        env={"GEOSWARM_DATABASE_URL": f"sqlite:///{tmp_path}/jobs.db", "PATH": "/usr/bin:/bin"},
        cwd=Path(__file__).parents[2],
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )
    assert done.returncode == 1
    assert "no worker process" in done.stderr
