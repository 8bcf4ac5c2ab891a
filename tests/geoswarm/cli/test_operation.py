"""``geoswarm keys`` and ``prune``, and what ``serve`` makes of keys in its database."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from geoswarm.api import ApiSettings
from geoswarm.cli import main
from geoswarm.cli.serve import refuse_open_door
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.solver.problem import parse_problem
from geoswarm.workers.access.keys import KEY_PATTERN, ApiKeys
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import line_problem
from tests.integration.engines import PATIENCE, wait_for


@pytest.fixture
def url(tmp_path: Path) -> str:
    return f"sqlite:///{tmp_path}/jobs.db"


def test_a_key_is_made_listed_and_revoked(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "create", "--owner", "anna", "--role", "admin", "--expires", "90d", "--database", url]) == 0
    key = capsys.readouterr().out.strip()
    assert KEY_PATTERN.fullmatch(key)
    assert main(["keys", "list", "--json", "--database", url]) == 0
    text = capsys.readouterr().out
    (item,) = json.loads(text)["items"]
    assert (item["owner"], item["role"], item["state"]) == ("anna", "admin", "active")
    assert key.split("_", 2)[2] not in text
    assert "hash" not in item
    assert main(["keys", "list", "--database", url]) == 0
    assert "anna" in capsys.readouterr().out
    assert main(["keys", "revoke", key, "--database", url]) == 0  # the whole key does as well as its id
    assert "revoked" in capsys.readouterr().out
    store = Store(Settings(database_url=url))
    assert ApiKeys(store).principal(key) is None
    store.close()


def test_json_of_a_new_key_holds_it_once(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["keys", "create", "--owner", "ben", "--json", "--database", url]) == 0
    made = json.loads(capsys.readouterr().out)
    assert KEY_PATTERN.fullmatch(made["key"])
    assert (made["role"], made["expires_at"]) == ("submit", None)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["create", "--owner", "a b"], "letters, digits"),
        (["create", "--owner", "anna", "--expires", "soon"], "90d or 12h"),
        (["create", "--owner", "anna", "--role", "god"], "admin"),
        (["revoke", "nothing"], "keys list"),
    ],
)
def test_what_keys_refuses(url: str, arguments: list[str], said: str, capsys: pytest.CaptureFixture[str]) -> None:
    Store(Settings(database_url=url)).close()
    assert main(["keys", *arguments, "--database", url]) == 2
    assert said in capsys.readouterr().err


def test_a_broker_or_other_machines_need_a_key_in_the_database(url: str) -> None:
    embedded = Settings(database_url=url)
    remote = Settings(database_url=url, broker_url="redis://127.0.0.1:6379/0")
    refuse_open_door("127.0.0.1", None, embedded)
    for host, settings in (("127.0.0.1", remote), ("0.0.0.0", embedded), ("db.example", embedded)):
        with pytest.raises(BadInputError, match="geoswarm keys create"):
            refuse_open_door(host, None, settings)
        refuse_open_door(host, "8f3b1d0e52a94c77888f3b1d0e52a94c7788", settings)
    store = Store(embedded)
    ApiKeys(store).create("anna", "admin")
    store.close()
    refuse_open_door("0.0.0.0", None, remote)
    assert not ApiSettings().needs_key


def test_prune_every_stays_until_it_is_stopped(url: str) -> None:
    store = Store(Settings(database_url=url))
    service = JobService(store, NoWaker())

    def ended(name: str) -> str:
        job = service.submit(parse_problem(line_problem(name=name)))[0].id
        service.cancel(job)
        with store.engine.begin() as connection:
            connection.exec_driver_sql("UPDATE jobs SET finished_at = finished_at - 864000")
        return job

    ended("first")
    command = [sys.executable, "-m", "geoswarm", "prune", "--older-than", "9d", "--every", "1s", "--database", url]
    with subprocess.Popen(command, stderr=subprocess.PIPE, text=True) as process:
        try:
            wait_for(lambda: not service.list().items, "the first round")
            ended("second")
            wait_for(lambda: not service.list().items, "another round")
            process.terminate()
            assert process.stderr is not None
            assert process.stderr.read() == "geoswarm prune; Ctrl-C stops it.\n"
            assert process.wait(PATIENCE) == 0
        finally:
            process.kill()
    store.close()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--every", "24h", "--dry-run"], "--dry-run"),
        (["--every", "24h", "--json"], "--json"),
        (["--every", "0s"], "1s"),
    ],
)
def test_prune_every_refuses(options: list[str], said: str, url: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["prune", "--older-than", "9d", *options, "--database", url]) == 2
    assert said in capsys.readouterr().err


def test_prune_shows_first_and_then_deletes(url: str, capsys: pytest.CaptureFixture[str]) -> None:
    store = Store(Settings(database_url=url))
    service = JobService(store, NoWaker())
    old = service.submit(parse_problem(line_problem(name="old")))[0].id
    service.cancel(old)
    service.submit(parse_problem(line_problem(name="open")))
    with store.engine.begin() as connection:
        connection.exec_driver_sql("UPDATE jobs SET finished_at = finished_at - 864000 WHERE finished_at IS NOT NULL")
    assert main(["prune", "--older-than", "9d", "--dry-run", "--database", url]) == 0
    assert "1 job would be deleted" in capsys.readouterr().out
    assert main(["prune", "--older-than", "20d", "--database", url]) == 0
    assert "0 jobs deleted" in capsys.readouterr().out
    assert main(["prune", "--older-than", "9d", "--json", "--database", url]) == 0
    pruned = json.loads(capsys.readouterr().out)
    assert [item["id"] for item in pruned["items"]] == [old]
    assert [job.name for job in service.list().items] == ["open"]
    store.close()
