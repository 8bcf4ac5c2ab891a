"""Whose turn it is: owners are served in turn, then their jobs, whatever priority one gives oneself."""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Any

import pytest
from sqlalchemy import Connection, insert, update

from geoswarm.workers.access.principal import LOCAL, Principal
from geoswarm.workers.queries.jobs import lock_job
from geoswarm.workers.queries.queue import most_urgent_job, note_served, take_turn
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import jobs, turns
from tests.workers.conftest import MakeWorker
from tests.workers.problems import expected_history, line, recorded_history

ON_POSTGRESQL = pytest.mark.parametrize("database_url", ["postgresql"], indirect=True)
ALICE, BOB, ADMIN = Principal("alice", "submit", "a"), Principal("bob", "submit", "b"), Principal("root", "admin", "r")


def submit(service: JobService, principal: Principal, count: int = 1, **changes: Any) -> list[str]:
    bound = service.on_behalf_of(principal)
    return [bound.submit(line(**changes))[0].id for _ in range(count)]


def served(service: JobService, turns: int) -> list[tuple[str | None, str]]:
    """Owner and job of the next turns, each of which nothing comes of."""
    found = []
    for _ in range(turns):
        row = service.store.read(most_urgent_job)
        assert row is not None
        view = service.get(row.id)
        found.append((view.owner, view.id))
        whole = service.store.read(lambda c, id=row.id: c.execute(jobs.select().where(jobs.c.id == id)).one())
        service.store.write(lambda c, whole=whole: note_served(c, whole))
    return found


def test_owners_are_served_in_turn_whatever_priorities_they_choose(service: JobService) -> None:
    submit(service, ALICE, 20, priority=10)
    small = submit(service, BOB, priority=-10)
    order = served(service, 12)
    assert [owner for owner, _ in order] == ["alice", "bob"] * 6
    assert {job for owner, job in order if owner == "bob"} == set(small)
    assert len({job for owner, job in order if owner == "alice"}) == 6  # each of hers in turn


def test_turns_are_kept_where_the_clock_stands_still_or_is_set_back(service: JobService) -> None:
    submit(service, ALICE, 3)
    submit(service, BOB, 3)
    served(service, 2)
    service.store.write(lambda c: c.execute(update(turns).values(served_at=turns.c.served_at + 3600.0)))
    owners = [owner for owner, _ in served(service, 8)]
    assert owners in (["alice", "bob"] * 4, ["bob", "alice"] * 4)


def test_priority_orders_ones_own_jobs(service: JobService) -> None:
    usual = submit(service, ALICE)
    urgent = submit(service, ALICE, priority=3)
    assert [job for _, job in served(service, 3)] == urgent * 3
    assert served(service, 1) == [("alice", urgent[0])]
    service.on_behalf_of(ALICE).cancel(urgent[0])
    assert served(service, 1) == [("alice", usual[0])]


def test_an_administrators_priority_counts_among_owners(service: JobService) -> None:
    submit(service, ALICE, 2, priority=10)
    urgent = submit(service, ADMIN, priority=3)
    served(service, 2)  # each has been served once
    assert served(service, 3) == [("root", urgent[0])] * 3
    service.cancel(urgent[0])
    submit(service, ADMIN, priority=-5)
    served(service, 2)
    assert {owner for owner, _ in served(service, 3)} == {"alice"}


def test_jobs_without_an_owner_share_one_line_in_which_priority_counts_as_ever(service: JobService) -> None:
    first, second = submit(service, LOCAL, 2)
    urgent = submit(service, LOCAL, priority=3)[0]
    assert [job for _, job in served(service, 2)] == [urgent, urgent]
    service.cancel(urgent)
    assert [job for _, job in served(service, 4)] == [first, second] * 2


def test_who_has_nothing_to_be_done_keeps_nobody_waiting(service: JobService) -> None:
    (other,) = submit(service, BOB)
    service.on_behalf_of(BOB).pause(other)
    mine = submit(service, ALICE)
    assert served(service, 2) == [("alice", mine[0])] * 2
    assert service.store.read(lambda c: most_urgent_job(c, kinds=("slope",))) is None
    assert service.store.read(lambda c: most_urgent_job(c, without=("formula",))) is None


def test_a_small_job_beside_many_of_a_neighbour_gets_half_of_a_worker(
    service: JobService, make_worker: MakeWorker
) -> None:
    submit(service, ALICE, 30, priority=10, stopping={"max_evaluations": 6000})
    problem = line(stopping={"max_evaluations": 60})
    (small,) = submit(service, BOB, stopping={"max_evaluations": 60})
    worker = make_worker(slice_seconds=0.02, local_batch_seconds=0.0, cheap_seconds=0.0, single_seconds=1e-9)
    worker.start()
    for_bob = for_alice = 0
    while service.get(small).state != "finished":
        job_id = worker.next_job()
        assert job_id is not None
        worker.serve(job_id)
        for_bob += job_id == small
        for_alice += job_id != small
        assert for_alice <= for_bob + 1
    worker.close()
    assert for_bob > 1
    assert recorded_history(service, small) == expected_history(problem)


@ON_POSTGRESQL
def test_owners_are_served_in_turn_where_the_choice_notes_the_turn(service: JobService) -> None:
    submit(service, ALICE, 20, priority=10)
    small = submit(service, BOB, priority=-10)
    urgent = submit(service, ADMIN, priority=3)
    rows = [service.store.read(take_turn) for _ in range(4)]
    assert [row.id for row in rows if row is not None] == urgent * 4
    service.cancel(urgent[0])
    rows = [service.store.read(take_turn) for _ in range(12)]
    order = [(service.get(row.id).owner, row.id) for row in rows if row is not None]
    assert [owner for owner, _ in order] in (["alice", "bob"] * 6, ["bob", "alice"] * 6)
    assert {job for owner, job in order if owner == "bob"} == set(small)
    assert len({job for owner, job in order if owner == "alice"}) == 6
    assert service.store.read(lambda c: take_turn(c, kinds=("slope",))) is None


@ON_POSTGRESQL
def test_workers_that_come_at_once_turn_to_different_jobs(service: JobService, make_worker: MakeWorker) -> None:
    ids = submit(service, ALICE, 4)
    workers = [make_worker() for _ in range(4)]
    assert [worker.take_turn() for worker in workers] == [(job_id, True) for job_id in ids]


@ON_POSTGRESQL
def test_a_job_that_somebody_has_locked_is_left_to_others(service: JobService, make_worker: MakeWorker) -> None:
    first, second = submit(service, ALICE, 2)
    worker = make_worker()

    def choose_meanwhile(connection: Connection) -> None:
        assert lock_job(connection, first) is not None
        assert worker.take_turn() == (second, True)
        assert lock_job(connection, second) is not None
        assert worker.take_turn() == (first, False)  # it waits for the first in turn

    service.store.write(choose_meanwhile)
    assert worker.take_turn() == (first, True)


@ON_POSTGRESQL
def test_a_turn_is_noted_once(service: JobService, make_worker: MakeWorker) -> None:
    first, second = submit(service, ALICE, 2)
    worker = make_worker(slice_seconds=0.0, local_batch_seconds=0.0, cheap_seconds=0.0, single_seconds=1e-9)

    def served_at() -> list[float | None]:
        rows = service.store.read(lambda c: c.execute(jobs.select().order_by(jobs.c.created_at)).all())
        return [row.served_at for row in rows]

    assert worker.take_turn() == (first, True)
    noted = served_at()
    worker.serve(first, noted=True)
    assert served_at() == noted
    worker.serve(second)
    assert served_at()[1] is not None


def test_a_long_list_makes_the_choice_no_dearer(tmp_path: Path) -> None:
    """Steps of SQLite's machine with 500 and with 8000 jobs that wait, of several owners, beside ended ones."""
    steps = []
    for count in (500, 8000):
        store = Store(Settings(database_url=f"sqlite:///{tmp_path}/{count}.db"))
        rows = [
            {"id": secrets.token_hex(8), "name": "x", "state": ("queued", "finished")[i % 3 == 0], "forward_model": "f"}
            | {"method": "m", "problem": "{}", "seed": 1, "free_parameters": "[]", "grids": "{}", "body_hash": ""}
            | {"generation": -1, "generations": 0, "evaluations": 0, "failed_evaluations": 0, "failures": "{}"}
            | {"stop_reasons": "[]", "created_at": float(i), "run_seconds": 0.0}
            | {"owner": f"o{i % 5}", "line": f"o{i % 5}", "place": float(-i)}
            for i in range(count)
        ]
        store.write(lambda c, rows=rows: c.execute(insert(jobs), rows))
        store.write(lambda c: c.execute(insert(turns), [{"line": f"o{i}"} for i in range(5)]))
        taken = [0]

        def count_steps(taken: list[int] = taken) -> int:
            taken[0] += 1
            return 0

        with store.engine.connect() as connection:
            driver: Any = connection.connection.driver_connection
            driver.set_progress_handler(count_steps, 10)
            row = most_urgent_job(connection)
            driver.set_progress_handler(None, 0)
        assert row is not None
        steps.append(taken[0])
        store.close()
    assert steps[1] < 1.5 * steps[0]


@pytest.mark.parametrize("again", [False, True])
def test_a_new_owner_need_not_wait_for_all_who_came_before(service: JobService, again: bool) -> None:
    submit(service, ALICE, 5)
    served(service, 3)
    if again:  # whose last turn is long ago
        (old,) = submit(service, BOB)
        service.on_behalf_of(BOB).cancel(old)
        service.store.write(lambda c: c.execute(update(turns).where(turns.c.line == "bob").values(served_at=1.0)))
    submit(service, BOB)
    assert served(service, 1)[0][0] == "bob"
