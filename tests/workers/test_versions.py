"""A job knows what it is calculated under, and says when something else takes part."""

from __future__ import annotations

import logging
from collections.abc import Callable
from types import MappingProxyType

import pytest
from sqlalchemy import text

from geoswarm.solver.system.versions import PACKAGES, versions
from geoswarm.workers.queries import versions as recording
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.workers.conftest import ON_SQLITE
from tests.workers.hand import PROBLEM, Hand, finish, runtime_for

Become = Callable[..., None]


@pytest.fixture
def become(monkeypatch: pytest.MonkeyPatch) -> Become:
    """Let this process calculate under other versions."""

    def change(**changed: str) -> None:
        monkeypatch.setattr(recording, "versions", lambda: MappingProxyType({**versions(), **changed}))

    return change


def told(service: JobService, job: str) -> list[dict[str, object]]:
    return [event.data for event in service.events(job) if event.kind == "versions"]


def test_a_job_records_what_it_was_begun_under(service: JobService, store: Store, settings: Settings) -> None:
    job = service.submit(PROBLEM)[0].id
    assert (service.get(job).versions, service.get(job).warnings) == (None, [])
    finish(Hand(runtime_for(store, settings), job, "a"))
    view = service.get(job)
    assert view.state == "finished"
    assert view.versions == dict(versions())
    assert set(view.versions) == {"python", "machine", *PACKAGES}
    assert view.warnings == told(service, job) == []
    assert service.list().items[0].versions == view.versions


def test_going_on_under_others_warns_once(
    service: JobService, store: Store, settings: Settings, become: Become, caplog: pytest.LogCaptureFixture
) -> None:
    job = service.submit(PROBLEM)[0].id
    runtime = runtime_for(store, settings)
    first, second = Hand(runtime, job, "a"), Hand(runtime, job, "b")
    first.take()
    first.submit(want=False)
    service.pause(job)
    service.resume(job)
    become(numpy="1.0")
    with caplog.at_level(logging.WARNING):
        finish(second)
    view = service.get(job)
    own = versions()["numpy"]
    assert view.state == "finished"
    assert view.versions == dict(versions())
    (warning,) = view.warnings
    assert warning.startswith(f"continued with other versions: numpy 1.0 instead of {own}; ")
    (event,) = told(service, job)
    assert event["worker"] == "b"
    assert event["message"] == warning
    assert event["found"] == {**versions(), "numpy": "1.0"}
    assert [record.message for record in caplog.records] == [f"job {job}: {warning}"]


@ON_SQLITE
def test_each_set_of_versions_is_told_in_a_mixed_group(
    service: JobService, store: Store, settings: Settings, become: Become
) -> None:
    job = service.submit(PROBLEM)[0].id
    runtime = runtime_for(store, settings)
    hands = {changed: Hand(runtime, job, changed) for changed in ("0", "scipy", "numba")}
    hands["0"].take()
    hands["0"].submit(want=False)
    for changed in ("scipy", "numba", "scipy", "numba"):
        become(**{changed: "0.1"})
        hands[changed].take()
        hands[changed].submit(want=False)
    assert [warning.split(": ")[1].split()[0] for warning in service.get(job).warnings] == ["scipy", "numba"]
    assert len(told(service, job)) == 2


@ON_SQLITE
@pytest.mark.parametrize("python", [".".join([*versions()["python"].split(".")[:2], "99"])])
def test_a_third_number_of_python_is_no_difference(
    service: JobService, store: Store, settings: Settings, become: Become, python: str
) -> None:
    job = service.submit(PROBLEM)[0].id
    hand = Hand(runtime_for(store, settings), job, "a")
    hand.take()
    hand.submit(want=False)
    become(python=python)
    finish(hand)
    assert service.get(job).warnings == []


def test_a_job_without_a_record_goes_on_and_says_so(service: JobService, store: Store, settings: Settings) -> None:
    job = service.submit(PROBLEM)[0].id
    hand = Hand(runtime_for(store, settings), job, "a")
    hand.take()
    hand.submit(want=False)
    with store.engine.connect() as connection:
        connection.execution_options(write=True)
        with connection.begin():
            connection.execute(text("UPDATE jobs SET versions = NULL"))
    assert service.get(job).warnings == []
    finish(hand)
    view = service.get(job)
    assert (view.state, view.versions) == ("finished", None)
    assert view.warnings[0].startswith("started with unrecorded versions, continued with geoswarm ")
    assert len(view.warnings) == len(told(service, job)) == 1
