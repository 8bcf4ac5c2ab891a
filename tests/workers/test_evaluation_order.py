"""Evaluations by their objective: pages that miss and repeat none, also while others come in."""

from __future__ import annotations

import itertools
from typing import Any

import pytest

from geoswarm.records.evaluation import Evaluation
from geoswarm.workers.errors import InvalidCursorError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.workers.conftest import MakeWorker
from tests.workers.hand import Hand, runtime_for
from tests.workers.problems import course, line

FORMULAS = {
    "some fail": "ln(a - 0.5) + b * x",  # below a = 0.5
    "all are equal": "x + 0 * a * b",
}


@pytest.fixture(params=FORMULAS)
def job(request: pytest.FixtureRequest, service: JobService, make_worker: MakeWorker) -> str:
    section = {"kind": "formula", "series": {"y": FORMULAS[request.param]}}
    job_id = service.submit(line(forward_model=section, method={"kind": "monte_carlo", "samples": 60}, stopping={}))[
        0
    ].id
    make_worker().serve(job_id)
    assert service.get(job_id).state == "finished"
    return job_id


def place(one: Evaluation) -> tuple[int, int]:
    return one.generation, one.particle


def expected(evaluations: list[Evaluation]) -> list[tuple[int, int]]:
    return [
        place(one) for one in sorted(evaluations, key=lambda one: (one.objective is None, one.objective, *place(one)))
    ]


def pages(service: JobService, job_id: str, limit: int, **filters: Any) -> list[tuple[int, int]]:
    """Places on all pages."""
    found: list[tuple[int, int]] = []
    cursor = None
    while True:
        page = service.evaluations(job_id, limit=limit, cursor=cursor, sort="objective", **filters)
        assert len(page.items) <= limit
        found += map(place, page.items)
        if (cursor := page.next_cursor) is None:
            return found


@pytest.mark.parametrize("limit", [1, 7, 1000])
@pytest.mark.parametrize(
    "filters",
    [{}, {"state": "finished"}, {"state": "failed"}, {"state": "running"}, {"max_objective": 3.0}, {"generation": 1}],
    ids=str,
)
def test_every_page_goes_on_where_the_last_one_ended(
    service: JobService, job: str, limit: int, filters: dict[str, Any]
) -> None:
    every = list(service.iterate_evaluations(job, **filters))
    assert pages(service, job, limit, **filters) == expected(every)


def test_a_cursor_belongs_to_its_order(service: JobService, job: str) -> None:
    by_objective, by_generation = (
        service.evaluations(job, limit=1, sort=sort).next_cursor for sort in ("objective", "generation")
    )
    with pytest.raises(InvalidCursorError):
        service.evaluations(job, cursor=by_objective)
    with pytest.raises(InvalidCursorError):
        service.evaluations(job, cursor=by_generation, sort="objective")


def test_pages_stay_in_order_while_evaluations_come_in(store: Store, settings: Settings, service: JobService) -> None:
    problem = line()
    job_id = service.submit(problem)[0].id
    hand = Hand(runtime_for(store, settings), job_id, "w1", course(problem))
    hand.take()
    while service.get(job_id).generations < 3:
        hand.submit()
    before = {place(one): one for one in service.iterate_evaluations(job_id) if one.objective is not None}
    assert len(before) >= 18
    seen: list[Evaluation] = []
    cursor = None
    while True:
        page = service.evaluations(job_id, limit=4, cursor=cursor, sort="objective")
        seen += page.items
        hand.submit(2)  # some of them belong before the page that was just read
        if (cursor := page.next_cursor) is None:
            break
    places = list(map(place, seen))
    assert len(set(places)) == len(places)
    assert before.keys() <= set(places)
    known = [one.objective for one in seen if one.objective is not None]
    assert all(a <= b for a, b in itertools.pairwise(known))
