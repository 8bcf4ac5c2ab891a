from __future__ import annotations

import logging
import socket
import sqlite3
from pathlib import Path

import pytest
from sqlalchemy.exc import OperationalError

from geoswarm.api.errors import TRANSLATED, translate
from geoswarm.workers import errors as workers_errors
from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import API, App, line_problem, live_server


def test_an_unknown_route_points_to_the_list_of_routes(app: App) -> None:
    answer = app.get("/api/v2/jobs")
    assert answer.status_code == 404
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.json() == {
        "type": "about:blank",
        "title": "Not Found",
        "status": 404,
        "detail": "There is nothing at /api/v2/jobs. The routes are listed in /openapi.json.",
    }


def test_a_wrong_method_names_the_right_ones(app: App) -> None:
    answer = app("PUT", f"{API}/jobs")
    assert answer.status_code == 405
    assert answer.headers["allow"]
    assert answer.headers["allow"] in answer.json()["detail"]


def test_queries_are_judged_with_their_path(app: App) -> None:
    answer = app.get(f"{API}/jobs/x/evaluations?generation=-1&limit=many&max_objective=nan")
    assert answer.status_code == 422
    assert {issue["path"] for issue in answer.json()["issues"]} == {
        "query.generation",
        "query.limit",
        "query.max_objective",
    }


def test_a_foreign_cursor_is_refused(app: App) -> None:
    answer = app.get(f"{API}/jobs?cursor=elsewhere")
    assert (answer.status_code, answer.json()["type"]) == (400, "urn:geoswarm:error:invalid-cursor")


class BrokenService(JobService):
    """Its database is gone, or it has a bug."""

    def __init__(self, error: Exception, folder: Path) -> None:
        super().__init__(Store(Settings(database_url=f"sqlite:///{folder}/jobs.db")), NoWaker())
        self.error = error

    def get(self, _job_id: str) -> object:  # type: ignore[override]
        raise self.error

    def health(self) -> dict[str, str]:
        return {"database": "cannot connect to postgresql://db/jobs", "broker": "ok"}


def test_an_unexpected_error_is_logged_with_its_id_and_told_without_a_traceback(
    caplog: pytest.LogCaptureFixture, tmp_path: Path
) -> None:
    app = App(BrokenService(ZeroDivisionError("secret detail"), tmp_path))
    with caplog.at_level(logging.ERROR, logger="geoswarm.api"):
        answer = app.get(f"{API}/jobs/x")
    detail = answer.json()
    assert answer.status_code == 500
    assert answer.headers["content-type"] == "application/problem+json"
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert "secret" not in answer.text
    assert "Traceback" not in answer.text
    assert detail["instance"].startswith("urn:uuid:")
    assert any(detail["instance"] in record.getMessage() and record.exc_info for record in caplog.records)


def test_an_unexpected_error_says_that_the_connection_ends(tmp_path: Path) -> None:
    service = BrokenService(ZeroDivisionError(), tmp_path)
    with live_server(service) as server:
        port = server.listener.getsockname()[1]
        with socket.create_connection(("127.0.0.1", port), timeout=30) as connection:
            connection.sendall(f"GET {API}/jobs/x HTTP/1.1\r\nHost: localhost\r\n\r\n".encode())
            answer = b"".join(iter(lambda: connection.recv(65536), b""))  # until the service closes it
    head, _, body = answer.partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 500")
    assert b"connection: close" in head.lower().split(b"\r\n")
    assert b"urn:uuid:" in body
    service.close()


def test_an_unavailable_database_is_503(tmp_path: Path) -> None:
    app = App(BrokenService(StoreUnavailableError("the database db does not answer"), tmp_path))
    answer = app.get(f"{API}/jobs/x")
    assert answer.status_code == 503
    assert answer.headers["retry-after"] == "5"
    assert answer.json()["title"] == "Database unavailable"
    assert answer.json()["detail"] == "the database db does not answer"


def test_ready_tells_which_dependency_is_down(tmp_path: Path) -> None:
    app = App(BrokenService(ValueError(), tmp_path))
    answer = app.get("/health/ready")
    assert answer.status_code == 503
    assert answer.json() == {
        "status": "unavailable",
        "dependencies": {"database": "cannot connect to postgresql://db/jobs", "broker": "ok"},
    }
    assert app.get("/health/live").status_code == 200


def test_a_database_that_is_really_gone_is_503(app: App, tmp_path: Path) -> None:
    job = app.post(f"{API}/jobs", json=line_problem()).json()["id"]
    with sqlite3.connect(tmp_path / "jobs.db") as other:
        for (table,) in other.execute(
            "select name from sqlite_master where type = 'table' and name not like 'sqlite_%'"
        ).fetchall():
            other.execute(f'drop table "{table}"')
    other.close()
    answer = app.get(f"{API}/jobs/{job}")
    assert answer.status_code == 503
    assert "Traceback" not in answer.text
    assert OperationalError.__name__ not in answer.json()["title"]


def test_every_error_of_the_engine_that_requests_can_meet_has_a_translation() -> None:
    start_up = {"WorkersError", "SettingsError", "KeyNotFoundError"}
    in_their_routes = {"NoBodyError"}  # no mesh, or no fields
    for name in set(workers_errors.__all__) - start_up - in_their_routes:
        assert getattr(workers_errors, name) in TRANSLATED, name
    with pytest.raises(TypeError, match="no problem detail is defined for KeyError"):
        translate(KeyError())


def test_mute_waker_is_enough_for_a_service_that_only_stores(app: App, service: JobService) -> None:
    assert isinstance(service.waker, NoWaker)
    assert app.get("/health/ready").json()["dependencies"] == {"database": "ok", "broker": "embedded"}
