"""What a command says to who has no key for a service that asks for one."""

from __future__ import annotations

from pathlib import Path

import pytest

from geoswarm.api import ApiSettings
from geoswarm.cli import main
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import live_server


def test_the_option_and_the_variable_are_named(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.delenv("GEOSWARM_API_KEY", raising=False)
    settings = Settings(database_url=f"sqlite:///{tmp_path}/jobs.db", workers=1)
    store = Store(settings)
    service = JobService(store, NoWaker(), settings)
    try:
        with live_server(service, ApiSettings(require_key=True)) as server:
            assert main(["list", "--url", server.url]) == 2
            assert "Give one with --api-key KEY or in GEOSWARM_API_KEY." in capsys.readouterr().err
            assert main(["list", "--url", server.url, "--api-key", "gsw_nothing"]) == 2
            assert "Give another one with --api-key KEY" in capsys.readouterr().err
    finally:
        service.close()
        store.close()
