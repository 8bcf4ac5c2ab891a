"""Statistics of long histories: which generations are read, and that the statistics say so."""

from __future__ import annotations

import itertools

import pytest

from geoswarm.solver.identifiability import analyse
from geoswarm.solver.methods.particle_swarm import ParticleSwarmMethod
from geoswarm.workers.cache import Cache
from geoswarm.workers.queries import jobs, selection
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.service.statistics import StatisticsService, StoredJob
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from tests.workers.conftest import ON_SQLITE
from tests.workers.hand import Hand, finish, runtime_for
from tests.workers.problems import course, line

SWARM = line(
    method={"kind": "particle_swarm", "particles": 5, "acceleration": "none"}, stopping={"max_evaluations": 200}
)
SAMPLED = line(method={"kind": "monte_carlo", "samples": 200, "batch": 5}, stopping={})


@pytest.fixture(params=["search", "sampling"])
def job(request: pytest.FixtureRequest, store: Store, settings: Settings, service: JobService) -> tuple[str, bool]:
    """A finished job of 40 generations of 5 evaluations, and whether it is a sampling."""
    problem = SAMPLED if request.param == "sampling" else SWARM
    job_id = service.submit(problem)[0].id
    finish(Hand(runtime_for(store, settings), job_id, "w1", course(problem)))
    assert service.get(job_id).generations == 40
    return job_id, request.param == "sampling"


def chosen(store: Store, job_id: str, most: int, sampled: bool) -> list[int] | None:
    return store.read(lambda c: selection.chosen_generations(c, jobs.get_job(c, job_id), most, sampled=sampled))


def test_a_short_history_is_read_whole(store: Store, job: tuple[str, bool]) -> None:
    assert chosen(store, job[0], 200, job[1]) is None
    rows = store.read(lambda c: list(selection.read_evaluations(c, job[0], None)))
    assert [(row.generation, row.particle) for row in rows] == [(g, p) for g in range(40) for p in range(5)]


def test_a_long_history_is_read_in_generations_that_stand_for_it(
    store: Store, service: JobService, job: tuple[str, bool]
) -> None:
    job_id, sampled = job
    numbers = chosen(store, job_id, 100, sampled)
    assert numbers is not None
    assert numbers == sorted(set(numbers))
    best = service.best(job_id)
    assert best is not None
    assert {0, 39, best.generation} <= set(numbers)
    assert len(numbers) <= 23  # the one that would come next is asked for as well: it may be under way
    by_objective = sorted(service.generations(job_id, limit=100), key=lambda view: (view.best_objective, view.number))
    lowest = {view.number for view in by_objective[:10]}
    assert sampled or lowest <= set(numbers)
    assert max(b - a for a, b in itertools.pairwise(numbers)) <= (3 if sampled else 5)
    rows = store.read(lambda c: list(selection.read_evaluations(c, job_id, numbers)))
    assert [(row.generation, row.particle) for row in rows] == [(g, p) for g in numbers if g < 40 for p in range(5)]


@ON_SQLITE
def test_statistics_say_what_they_rest_on(
    monkeypatch: pytest.MonkeyPatch, service: JobService, job: tuple[str, bool]
) -> None:
    monkeypatch.setattr("geoswarm.workers.service.statistics.MOST_READ", 100)
    monkeypatch.setattr("geoswarm.workers.queries.selection.MOST_RECORDS", 10)
    job_id, sampled = job
    stored = service.statistics.stored(job_id)
    assert stored.samples.size + stored.samples.left_out == 200
    assert 80 <= stored.samples.size <= 110
    assert float(stored.samples.objectives.min()) == service.get(job_id).objective
    assert [record.number for record in stored.record.records][::9] == [0, 39]
    problem = SAMPLED if sampled else SWARM
    found = analyse(course(problem).calibration, stored.samples)
    rule = "spread evenly" if sampled else "half with the lowest objectives, half spread evenly"
    assert f"{stored.samples.size} of its 200 successful evaluations were read, {rule}" in found.warnings[0]
    assert (ParticleSwarmMethod.bias in found.warnings) is not sampled
    assert found.to_json()["samples"]["left_out"] == stored.samples.left_out


@ON_SQLITE
def test_long_responses_make_fewer_evaluations(
    monkeypatch: pytest.MonkeyPatch, service: JobService, job: tuple[str, bool]
) -> None:
    job_id, _ = job
    points = sum(o.x.size for o in service.statistics.stored(job_id).problem.observations)
    monkeypatch.setattr("geoswarm.workers.service.statistics.MOST_VALUES", 50 * points)
    stored = StatisticsService(service.store, service._row, Cache(), service.principal.sees).stored(job_id)
    assert stored.samples.size + stored.samples.left_out == 200
    assert 40 <= stored.samples.size <= 75
    assert float(stored.samples.objectives.min()) == service.get(job_id).objective
    assert any("of its 200 successful evaluations were read" in text for text in analysed(stored))


@ON_SQLITE
def test_a_large_generation_is_thinned(
    monkeypatch: pytest.MonkeyPatch, store: Store, settings: Settings, service: JobService
) -> None:
    problem = line(method={"kind": "monte_carlo", "samples": 200, "batch": 200}, stopping={})
    job_id = service.submit(problem)[0].id
    finish(Hand(runtime_for(store, settings), job_id, "w1", course(problem)))
    monkeypatch.setattr("geoswarm.workers.service.statistics.MOST_READ", 20)
    stored = service.statistics.stored(job_id)
    assert stored.samples.size + stored.samples.left_out == 200
    assert 20 <= stored.samples.size <= 31
    assert float(stored.samples.objectives.min()) == service.get(job_id).objective


def analysed(stored: StoredJob) -> tuple[str, ...]:
    return analyse(course(stored.problem).calibration, stored.samples).warnings
