"""The synchronous client against a real service."""

from __future__ import annotations

import csv
import json
import os
import ssl
import stat
import threading
import time
from contextlib import ExitStack
from datetime import UTC
from pathlib import Path

import httpx
import numpy as np
import pytest
from pydantic import SecretStr

from geoswarm import (
    Client,
    ConflictError,
    ConnectionFailedError,
    GeoswarmError,
    HttpError,
    InvalidProblemError,
    JobFailedError,
    NotFoundError,
    ServerError,
    UnauthorizedError,
    WaitTimeoutError,
)
from geoswarm.api import ApiSettings
from geoswarm.client import Event, Job
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import parse_problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.hosts.engine import Engine
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.api.conftest import BROKEN, LiveServer, line_problem, live_server, wait_until
from tests.integration.engines import PATIENCE


def endless() -> dict[str, object]:
    """A job that the tests end themselves."""
    return line_problem(stopping={"max_seconds": 600})


def test_authorities_are_read_only_for_a_service_with_tls(monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[object] = []
    monkeypatch.setattr(ssl.SSLContext, "load_verify_locations", lambda *places, **_: read.append(places))
    Client("http://127.0.0.1:8765").close()
    assert read == []
    Client("HTTPS://calibration.example.org").close()
    assert read != []


def test_an_idle_connection_is_left_before_the_service_closes_it(server: LiveServer) -> None:
    with Client(server.url) as client:
        transport = client._http._transport
        assert isinstance(transport, httpx.HTTPTransport)
        kept = transport._pool._keepalive_expiry
    assert kept is not None
    assert kept <= server.server.config.timeout_keep_alive - 1.0


def test_submit_wait_and_read_the_result(client: Client) -> None:
    events: list[Event] = []
    job = client.wait(client.submit(line_problem()).id, timeout=PATIENCE, on_event=events.append)
    local = calibrate(parse_problem(line_problem()))
    assert (job.state, job.ended, job.stop_reasons) == ("finished", True, ["max_evaluations"])
    assert (job.objective, job.parameters) == (local.objective, local.parameters)
    assert job.created_at.tzinfo == UTC
    assert [event.data["number"] for event in events if event.kind == "generation"] == list(range(10))
    assert [event.ends_job for event in events] == [False] * (len(events) - 1) + [True]
    best = client.best(job.id)
    assert (best.objective, best.parameters) == (job.objective, job.parameters)
    assert best.responses["y"].x == [0.0, 1.0, 2.0]
    generations = client.generations(job.id)
    assert [generation.number for generation in generations] == list(range(10))
    assert generations[-1].objective == job.objective
    assert generations[-1].diversity is None
    (last,) = client.generations(job.id, after=8, diversity=True)
    assert last.diversity is not None
    assert 0.0 < last.diversity < 1.8
    earlier = client.warm_starts(line_problem(method={"kind": "particle_swarm", "particles": 6}))
    assert (job.id, 60) in [(one.job, one.evaluations) for one in earlier]
    assert client.get(job.id) == job


def test_evaluations_in_pages_one_by_one_and_as_a_file(client: Client, tmp_path: Path) -> None:
    textbook = {"kind": "particle_swarm", "particles": 6, "acceleration": "none"}
    job = client.submit(line_problem(method=textbook, stopping={"max_evaluations": 1200}))
    job = client.wait(job.id, timeout=PATIENCE)
    page = client.evaluations(job.id, limit=7, responses=True)
    assert len(page.items) == 7
    assert page.items[0].responses is not None
    assert page.next_cursor is not None
    following = client.evaluations(job.id, limit=7, cursor=page.next_cursor)
    assert (following.items[0].generation, following.items[0].particle) == (1, 1)
    every = list(client.iterate_evaluations(job.id))
    assert [(e.generation, e.particle) for e in every] == [(g, p) for g in range(200) for p in range(6)]
    ordered = list(client.iterate_evaluations(job.id, sort="objective"))
    assert ordered == sorted(every, key=lambda one: (one.objective, one.generation, one.particle))
    path = client.download_evaluations(job.id, tmp_path / "evaluations.csv")
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["objective"]) for row in rows] == [evaluation.objective for evaluation in every]
    assert [entry.name for entry in tmp_path.iterdir()] == ["evaluations.csv"]
    mask = os.umask(0o022)
    os.umask(mask)
    assert stat.S_IMODE(path.stat().st_mode) == 0o666 & ~mask
    only = client.download_evaluations(job.id, tmp_path / "last.csv", generation=199)
    assert len(only.read_text().splitlines()) == 7


def test_a_job_is_renamed(client: Client) -> None:
    job = client.submit(line_problem())
    renamed = client.label(job.id, name="Dam, core")
    assert (renamed.name, renamed.tags) == ("Dam, core", [])
    assert client.label(job.id, tags=["dam"]).name == client.problem(job.id)["name"] == "Dam, core"
    with pytest.raises(InvalidProblemError, match="printable"):
        client.label(job.id, name="a\nb")


def test_a_download_that_fails_leaves_the_old_file(client: Client, tmp_path: Path) -> None:
    path = tmp_path / "evaluations.csv"
    path.write_text("old")
    with pytest.raises(NotFoundError):
        client.download_evaluations("nobody", path)
    assert path.read_text() == "old"
    assert [entry.name for entry in tmp_path.iterdir()] == ["evaluations.csv"]


def test_a_problem_file_is_sent_with_its_measurements(client: Client, tmp_path: Path) -> None:
    (tmp_path / "measured.csv").write_text("x,y\n0,1\n1,3\n2,5\n")
    problem = line_problem(observations=[{"series": "y", "file": "measured.csv"}])
    (tmp_path / "problem.json").write_text(json.dumps(problem))
    for path in (tmp_path / "problem.json", str(tmp_path / "problem.json")):
        job = client.wait(client.submit(path).id, timeout=PATIENCE)
        assert client.problem(job.id)["observations"][0]["points"]["y"] == [1.0, 3.0, 5.0]
    assert client.check(tmp_path / "problem.json").data_points == 3


def test_a_problem_file_that_is_wrong_is_told_before_anything_is_sent(client: Client, tmp_path: Path) -> None:
    with pytest.raises(ProblemError, match="no such file"):
        client.submit(tmp_path / "missing.yaml")


def test_arrays_of_numpy_are_data(client: Client) -> None:
    points = {"x": np.arange(3.0), "y": np.array([1.0, 3.0, 5.0])}
    result = client.check(line_problem(observations=[{"series": "y", "points": points}]))
    assert (result.valid, result.data_points, result.test_run.state) == (True, 3, "finished")
    with pytest.raises(TypeError, match="cannot hold"):
        client.check(line_problem(name=object()))


def test_idempotency(client: Client) -> None:
    first = client.submit(line_problem(), idempotency_key="client-1")
    assert client.submit(line_problem(), idempotency_key="client-1").id == first.id
    with pytest.raises(ConflictError, match="was used for job") as caught:
        client.submit(line_problem(seed=8), idempotency_key="client-1")
    assert caught.value.status == 409
    assert client.submit(line_problem()).id != client.submit(line_problem()).id


def test_list_iterate_pause_resume_cancel_delete(client: Client) -> None:
    ids = [client.submit(endless()).id for _ in range(2)]
    assert [job.id for job in client.list(limit=2).items] == ids[::-1]
    assert client.pause(ids[0]).state == "paused"
    assert client.resume(ids[0]).state in ("queued", "running")
    with pytest.raises(ConflictError, match="cannot delete a job that is"):
        client.delete(ids[0])
    for job_id in ids:
        assert client.cancel(job_id).state == "cancelled"
    assert client.wait(ids[0], timeout=PATIENCE).state == "cancelled"
    assert client.change_stopping(ids[0], {"max_seconds": 900}).state in ("queued", "running")
    assert client.cancel(ids[0]).state == "cancelled"
    found = client.list(search=ids[0], sort="evaluations", order="ascending", trend=4).items
    assert [job.id for job in found] == ids[:1]
    assert found[0].trend is not None
    client.delete(ids[0])
    with pytest.raises(NotFoundError, match="no job"):
        client.get(ids[0])
    assert ids[1] in [job.id for job in client.iterate_jobs(state="cancelled")]


def test_a_bad_problem_lists_its_mistakes(client: Client) -> None:
    with pytest.raises(InvalidProblemError) as caught:
        client.submit(line_problem(name=3, colour="red"))
    assert [issue.path for issue in caught.value.issues] == ["name", "colour"]
    assert "colour: unknown key" in str(caught.value)
    assert caught.value.type == "urn:geoswarm:error:invalid-problem"


def test_waiting_no_longer_than_asked(client: Client) -> None:
    job = client.submit(endless())
    began = time.monotonic()
    with pytest.raises(WaitTimeoutError, match=f"job {job.id} did not end within 0.7 s"):
        client.wait(job.id, timeout=0.7)
    assert time.monotonic() - began >= 0.7
    assert client.get(job.id).state in ("queued", "running")
    client.cancel(job.id)


def test_events_go_on_after_a_given_one(client: Client) -> None:
    job = client.submit(line_problem())
    events = list(client.events(job.id))
    assert events[-1].ends_job
    assert list(client.events(job.id, after=events[3].id)) == events[4:]
    assert list(client.events(job.id, after=events[-1].id)) == []


def test_what_the_service_offers(client: Client) -> None:
    assert "oedometer" in [info.kind for info in client.forward_models()]
    model = client.forward_model("oedometer")
    assert "settlement" in [series.name for series in model.series]
    assert model.json_schema["properties"]["kind"]["const"] == "oedometer"
    with pytest.raises(NotFoundError, match="known kinds: formula"):
        client.forward_model("odometer")
    client.wait(client.submit(line_problem()).id, timeout=PATIENCE)  # the worker has started
    assert [worker.engine for worker in client.workers()] == ["embedded"]
    assert client.health().ok


def test_the_address_and_the_key_come_from_the_environment(engine: Engine, monkeypatch: pytest.MonkeyPatch) -> None:
    with live_server(engine.service, ApiSettings(api_key=SecretStr("a-secret-key"))) as guarded:
        monkeypatch.setenv("GEOSWARM_URL", guarded.url)
        with Client() as without, pytest.raises(UnauthorizedError, match="An API key is needed") as caught:
            without.list()
        assert caught.value.status == 401
        with Client(api_key="wrong-key") as wrong, pytest.raises(UnauthorizedError, match="not valid"):
            list(wrong.events("x"))
        monkeypatch.setenv("GEOSWARM_API_KEY", "a-secret-key")
        with Client() as keyed:
            assert keyed.wait(keyed.submit(line_problem()).id, timeout=PATIENCE).state == "finished"


@pytest.mark.parametrize("url", ["localhost:8765", "ftp://localhost", "http://", "http://[::1"])
def test_an_address_that_is_none(url: str) -> None:
    with pytest.raises(GeoswarmError, match="address"):
        Client(url)


def test_nobody_answers(free_port: int) -> None:
    with Client(f"http://127.0.0.1:{free_port}") as client:
        for call in (client.list, client.health, lambda: client.wait("x"), lambda: client.submit(line_problem())):
            with pytest.raises(
                ConnectionFailedError, match=r"no geoswarm service answers at .*'geoswarm serve' starts"
            ):
                call()


def test_events_give_up_after_patience(free_port: int) -> None:
    with (
        Client(f"http://127.0.0.1:{free_port}", patience=0.5) as client,
        pytest.raises(ConnectionFailedError, match=r"could not be taken up for 0\.5 s"),
    ):
        next(client.events("x"))


def test_a_service_without_its_database_is_a_server_error(tmp_path: Path) -> None:
    settings = Settings(database_url=f"sqlite:///{tmp_path}/jobs.db")
    store = Store(settings)
    service = JobService(store, NoWaker(), settings)
    with live_server(service) as server, Client(server.url) as client:
        job = client.submit(line_problem())
        store.write(lambda connection: connection.exec_driver_sql("drop table evaluations"))
        with pytest.raises(ServerError) as caught:
            client.evaluations(job.id)
        assert caught.value.status == 503
    store.close()


def test_waiting_survives_a_restart_of_the_service(service: JobService, free_port: int) -> None:
    """No worker takes part: of many generations at once the stream leaves some out."""
    with ExitStack() as first, Client(f"http://127.0.0.1:{free_port}", patience=PATIENCE) as client:
        first.enter_context(live_server(service, port=free_port))
        job = client.submit(line_problem())
        client.pause(job.id)
        client.resume(job.id)
        events: list[Event] = []
        ended: list[Job] = []
        waiting = threading.Thread(target=lambda: ended.append(client.wait(job.id, PATIENCE, events.append)))
        waiting.start()
        wait_until(lambda: len(events) > 2)
        first.close()
        service.pause(job.id)
        time.sleep(0.5)  # nobody answers meanwhile
        with live_server(service, port=free_port):
            service.resume(job.id)
            service.cancel(job.id)
            waiting.join(PATIENCE)
            assert not waiting.is_alive()
    assert [found.state for found in ended] == ["cancelled"]
    assert [event.id for event in events] == [event.id for event in service.events(job.id)]


def test_a_failed_job_raises_with_what_is_known(client: Client) -> None:
    job = client.submit(line_problem(forward_model=BROKEN, stopping={"max_evaluations": 12}))
    with pytest.raises(JobFailedError, match="all 12 evaluations failed") as caught:
        client.wait(job.id, timeout=PATIENCE)
    assert caught.value.job.state == "failed"


def test_errors_of_something_that_is_no_geoswarm_service(server: LiveServer) -> None:
    with Client(f"{server.url}/static") as client:
        with pytest.raises(HttpError) as caught:
            client.list()
        assert caught.value.status == 404
