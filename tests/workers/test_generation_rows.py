"""An exchange reads of a generation what it concerns, and hands out the same as if it had read everything."""

from __future__ import annotations

from collections.abc import Callable

import pytest
from sqlalchemy import Connection, select

from geoswarm.solver.problem import Problem
from geoswarm.workers.coordinator.generation_rows import GenerationRows, load_generation
from geoswarm.workers.coordinator.hand_out import HandOut
from geoswarm.workers.coordinator.work import Submission
from geoswarm.workers.queries.jobs import LockedJob
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.evaluation import Claimed, EvaluationStatus, settle
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import evaluations
from tests.workers.hand import Hand, finish, runtime_for
from tests.workers.problems import course, line

PARTICLES = 100


def wide(particles: int = PARTICLES) -> Problem:
    method = {"kind": "particle_swarm", "particles": particles}
    return line(method=method, stopping={"max_evaluations": 3 * particles})


@pytest.fixture
def hand(store: Store, settings: Settings, service: JobService) -> Hand:
    """A worker that runs one evaluation at a time."""
    runtime = runtime_for(store, settings, single_seconds=0.0, cheap_seconds=0.0)
    return Hand(runtime, service.submit(wide())[0].id, "w1", course(wide()))


@pytest.fixture
def read(monkeypatch: pytest.MonkeyPatch) -> list[GenerationRows]:
    """What the exchanges read from now on."""
    found: list[GenerationRows] = []

    def keep(*given: object, **more: object) -> GenerationRows:
        found.append(load_generation(*given, **more))  # type: ignore[arg-type]
        return found[-1]

    monkeypatch.setattr("geoswarm.workers.coordinator.job_exchange.load_generation", keep)
    return found


def test_an_exchange_reads_what_is_handed_in_and_what_is_handed_out(hand: Hand, read: list[GenerationRows]) -> None:
    hand.take()
    for _ in range(20):
        hand.submit()
    assert {rows.size for rows in read} == {PARTICLES}
    assert max(len(rows.cells) for rows in read) == 2
    assert (read[-1].pending, read[-1].undone) == (PARTICLES - 21, PARTICLES - 20)


def test_the_state_of_the_search_is_read_when_a_generation_ends(hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    job: Callable[[LockedJob], object] = LockedJob.job
    monkeypatch.setattr(LockedJob, "job", lambda locked: (asked.append(locked.id), job(locked))[1])
    hand.take()
    asked.clear()
    for _ in range(PARTICLES - 1):
        hand.submit()
    assert asked == []
    hand.submit()
    assert len(asked) == 1


@pytest.mark.parametrize("most", [1, 3, 64, 500])
def test_claims_are_in_order_whatever_was_read_and_given_back(store: Store, hand: Hand, most: int) -> None:
    hand.take()
    hand.exchange(Submission(hand.claim), want=False)
    for particle, state in {4: "finished", 5: "failed", 7: "running", 70: "running", 99: "running"}.items():
        statement = evaluations.update().where(evaluations.c.particle == particle).values(state=state, worker="w9")
        store.write(lambda c, statement=statement: c.execute(statement))  # type: ignore[misc]

    def claimed(count: int) -> list[int]:
        def work(connection: object) -> list[int]:
            rows = load_generation(connection, hand.job_id, 0, particles=[70], workers=["w1"], most=most)  # type: ignore[arg-type]
            rows.cell(70).set(EvaluationStatus())
            hand_out = HandOut(rows, 0.0, 10.0)
            found = [cell.particle for _ in range(2) for cell in hand_out.choose("w1", count, ())]
            assert hand_out.left == PARTICLES - 4 - len(set(found))
            assert [cell.particle for cell in hand_out.rows.read_running()] == sorted({*found, 7, 99})
            return found

        return store.read(work)

    free = [particle for particle in range(PARTICLES) if particle not in (4, 5, 7, 99)]
    assert claimed(1) == [0, 0]  # what it holds comes again
    assert claimed(50)[:50] == free[:50]
    assert claimed(PARTICLES)[: len(free)] == free


@pytest.mark.parametrize(("most", "late"), [(1, 3), (8, 20), (64, 70)])
def test_late_results_of_unclaimed_runs_leave_no_worker_without_work(
    store: Store, hand: Hand, most: int, late: int
) -> None:
    """Their rows are pending in the database until the exchange ends, and may fill what is read further."""
    hand.take()
    hand.exchange(Submission(hand.claim), want=False)

    def claimed(connection: Connection) -> list[int]:
        rows = load_generation(connection, hand.job_id, 0, particles=range(1, 1 + late), workers=["w1"], most=most)
        for particle in range(1, 1 + late):
            rows.cell(particle).set(EvaluationStatus("finished", 1, "w1"))
        hand_out = HandOut(rows, 0.0, 10.0)
        return [cell.particle for cell in hand_out.choose("w1", most, ())]

    assert store.read(claimed) == [0, *range(1 + late, PARTICLES)][:most]


def test_counts_follow_what_is_set(store: Store, hand: Hand) -> None:
    hand.take()
    rows = store.read(lambda c: load_generation(c, hand.job_id, 0, workers=["w1"], most=2))
    counts = (rows.size, rows.pending, rows.undone)
    assert counts == (PARTICLES, PARTICLES - 1, PARTICLES)
    held, free = rows.cell(0), rows.cell(1)
    assert held in rows.held_by("w1")
    held.set(EvaluationStatus("finished", 1, "w1"))
    free.set(settle(free.status, Claimed("w2"))[0])
    assert (rows.pending, rows.undone) == (PARTICLES - 2, PARTICLES - 1)
    with pytest.raises(IndexError, match="generation 0 has 100 particles; there is no 100"):
        rows.cell(PARTICLES)


def test_of_a_generation_that_is_not_there_nothing_is_read(store: Store, hand: Hand) -> None:
    hand.take()
    rows = store.read(lambda c: load_generation(c, hand.job_id, 5, particles=[1], workers=["w1", "w2"]))
    assert (rows.size, rows.cells) == (0, {})
    assert store.read(lambda c: c.execute(select(evaluations.c.generation).distinct()).scalars().all()) == [0]


def test_the_same_parameters_have_every_column_of_their_earlier_run_but_its_times(
    store: Store, settings: Settings, service: JobService
) -> None:
    whole = {"a": {"lower": 0, "upper": 3, "integer": True}, "b": {"value": 1}}
    problem = line(parameters=whole, stopping={"max_evaluations": 30})
    runtime = runtime_for(store, settings, single_seconds=0.0, cheap_seconds=0.0)
    hand = Hand(runtime, service.submit(problem)[0].id, "w1", course(problem))
    finish(hand)
    assert service.get(hand.job_id).state == "finished"  # also after generations of known runs only
    rows = store.read(lambda c: c.execute(select(evaluations).order_by(evaluations.c.generation)).mappings().all())
    first = {row["parameters"]: row for row in reversed(rows)}
    again = [row for row in rows if row["seconds"] == 0.0]
    assert again
    own = {"generation", "particle", "worker", "started_at", "finished_at", "seconds"}
    shared = {column.name for column in evaluations.c} - own
    assert all(row[name] == first[row["parameters"]][name] for row in again for name in shared)
