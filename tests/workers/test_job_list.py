"""The list of jobs: filters, orders, pages, and the course of each search."""

from __future__ import annotations

import pytest

from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import InvalidCursorError
from geoswarm.workers.queries.job_list import JobFilters, SortKey
from geoswarm.workers.service.job_service import JobService
from tests.workers.conftest import MakeWorker
from tests.workers.problems import line

NAMES = ["Slope", "alpha 100%", "Beta", "alpha_2"]


@pytest.fixture
def ids(service: JobService, make_worker: MakeWorker) -> dict[str, str]:
    owners = {"Beta": "bob"}
    made = {
        name: service.on_behalf_of(Principal(owners.get(name, "alice"), "submit"))
        .submit(line(name=name, stopping={"max_evaluations": 12 + 6 * i}, seed=i))[0]
        .id
        for i, name in enumerate(NAMES)
    }
    worker = make_worker()
    for name in NAMES[:3]:
        worker.serve(made[name])
    return made


def listed(service: JobService, filters: JobFilters, limit: int = 1) -> list[str]:
    """Names on all pages."""
    names: list[str] = []
    cursor = None
    while True:
        page = service.list(filters, limit=limit, cursor=cursor)
        names += [view.name for view in page.items]
        if (cursor := page.next_cursor) is None:
            return names


def test_jobs_are_found_by_their_tags(service: JobService, ids: dict[str, str]) -> None:
    service.label(ids["Beta"], tags=["dam", "dam", "a_b"])
    service.label(ids["Slope"], tags=["dam 2"], note="dam")
    assert listed(service, JobFilters(tag="dam")) == ["Beta"]
    assert listed(service, JobFilters(tag="a%b")) == []
    assert sorted(listed(service, JobFilters(text="DAM"))) == ["Beta", "Slope"]
    assert service.get(ids["Beta"]).tags == ["a_b", "dam"]
    service.label(ids["Slope"], tags=[])
    slope = service.get(ids["Slope"])
    assert (slope.tags, slope.note) == ([], "dam")


def test_text_is_found_in_names_and_owners_and_wildcards_are_letters(service: JobService, ids: dict[str, str]) -> None:
    assert listed(service, JobFilters(text="ALPHA")) == ["alpha_2", "alpha 100%"]
    assert listed(service, JobFilters(text="0%")) == ["alpha 100%"]
    assert listed(service, JobFilters(text="a_2")) == ["alpha_2"]
    assert listed(service, JobFilters(text="bob")) == ["Beta"]
    assert listed(service, JobFilters(text=ids["Slope"][:10])) == ["Slope"]
    assert listed(service, JobFilters(text="formula", states=("queued",))) == ["alpha_2"]
    assert listed(service, JobFilters(owner="bob")) == ["Beta"]
    bob = service.on_behalf_of(Principal("bob", "read"))
    assert listed(bob, JobFilters(text="alpha")) == []


@pytest.mark.parametrize("limit", [1, 50])
def test_every_order_goes_through_all_jobs_once(service: JobService, ids: dict[str, str], limit: int) -> None:
    assert len(ids) == 4
    assert listed(service, JobFilters(), limit) == NAMES[::-1]
    assert listed(service, JobFilters(ascending=True), limit) == NAMES
    assert listed(service, JobFilters(sort="name"), limit) == ["alpha 100%", "alpha_2", "Beta", "Slope"]
    assert listed(service, JobFilters(sort="evaluations"), limit) == ["Beta", "alpha 100%", "Slope", "alpha_2"]
    best = {view.name: view.objective for view in service.list().items}
    known = sorted((name for name in NAMES if best[name] is not None), key=lambda name: best[name] or 0.0)
    assert listed(service, JobFilters(sort="objective"), limit) == [*known, "alpha_2"]
    assert listed(service, JobFilters(sort="objective", ascending=False), limit) == [*known[::-1], "alpha_2"]
    for sort in ("finished", "seconds"):
        key: SortKey = "finished" if sort == "finished" else "seconds"
        assert sorted(listed(service, JobFilters(sort=key), limit)) == sorted(NAMES)
        assert listed(service, JobFilters(sort=key), limit)[-1] == "alpha_2"


def test_a_cursor_of_another_order_is_refused(service: JobService, ids: dict[str, str]) -> None:
    assert len(ids) == 4
    cursor = service.list(JobFilters(sort="name"), limit=2).next_cursor
    with pytest.raises(InvalidCursorError):
        service.list(JobFilters(sort="objective"), limit=2, cursor=cursor)
    with pytest.raises(InvalidCursorError):
        service.list(JobFilters(sort="name", ascending=False), limit=2, cursor=cursor)


def test_trends_are_the_lowest_objectives_so_far(service: JobService, ids: dict[str, str]) -> None:
    views = {view.name: view for view in service.list(trend=3).items}
    assert views["alpha_2"].trend == []
    course = [generation.objective for generation in service.generations(ids["Beta"])]
    assert len(course) == 4
    trend = views["Beta"].trend or []
    assert len(trend) == 3
    assert (trend[0], trend[-1]) == (course[0], course[-1])
    assert set(trend) <= set(course)
    assert service.list().items[0].trend is None


def test_a_job_names_its_owner_and_its_newest_event(service: JobService, ids: dict[str, str]) -> None:
    view = service.get(ids["Beta"])
    assert view.owner == "bob"
    assert view.last_event == service.events(ids["Beta"])[-1].id


def test_follow_ups_are_listed_by_their_job_until_it_is_deleted(service: JobService, ids: dict[str, str]) -> None:
    alice = service.on_behalf_of(Principal("alice", "submit"))

    def follow(of: str, name: str) -> str:
        method = {"kind": "sensitivity", "at": {"a": 1.0, "b": 2.0}, "of": of}
        return alice.submit(line(name=name, method=method, stopping={}))[0].id

    below = follow(ids["Slope"], "below")
    follow(ids["Beta"], "of a job of bob's")
    follow("0" * 16, "of none")
    assert alice.get(below).parent == ids["Slope"]
    assert listed(service, JobFilters(parents=(ids["Slope"], ids["Beta"]))) == ["below"]
    assert listed(service, JobFilters(parents=())) == ["of none", "of a job of bob's", *NAMES[::-1]]
    service.delete(ids["Slope"])
    assert alice.get(below).parent is None
    assert "below" in listed(service, JobFilters(parents=()))
