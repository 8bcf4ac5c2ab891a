"""Statements that the driver gets directly answer and fail as with SQLAlchemy, and an exchange makes few of them."""

from __future__ import annotations

import threading
from contextlib import closing
from typing import Any

import pytest
from sqlalchemy import Connection, event, func, select

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.statements import MANY, Statement, change, enter
from geoswarm.workers.store.tables import evaluations, events, generations, jobs, turns
from tests.workers.hand import PROBLEM, Hand, runtime_for

COUNT = Statement(select(func.count().label("count")).select_from(turns))


@pytest.fixture
def hand(store: Store, settings: Settings, service: JobService) -> Hand:
    """A worker that runs one evaluation at a time, in generation 1."""
    runtime = runtime_for(store, settings, single_seconds=0.0, cheap_seconds=0.0)
    found = Hand(runtime, service.submit(PROBLEM)[0].id, "w1")
    found.take()
    while found.claim is not None and found.claim.generation == 0:
        found.submit()
    return found


@pytest.mark.usefixtures("hand")
def test_rows_are_those_of_sqlalchemy(store: Store) -> None:
    for table in (evaluations, events, generations, jobs):
        statement = select(table).order_by(*table.primary_key.columns)
        own = store.read(lambda c, statement=statement: Statement(statement).rows(c, {}))
        others = store.read(lambda c, statement=statement: c.execute(statement).all())
        assert own
        assert [row._asdict() for row in own] == [row._asdict() for row in others]
        assert [[type(value) for value in row] for row in own] == [[type(value) for value in row] for row in others]


def test_what_is_changed_is_counted(store: Store) -> None:
    served = change(turns, ("line",), ("served_at",))

    def write(connection: Connection) -> list[int]:
        enter(connection, turns, [{"line": line, "served_at": None} for line in "abc"])
        values = [{"of_line": line, "to_served_at": 1.5} for line in ("a", "b", "nobody")]
        return [served.write(connection, values), served.write(connection, values[-1:])]

    assert store.write(write) == [2, 0]
    rows = store.read(lambda c: c.execute(select(turns.c.line, turns.c.served_at).order_by(turns.c.line)).all())
    assert rows == [("a", 1.5), ("b", 1.5), ("c", None)]


@pytest.mark.parametrize("count", [1, 2, MANY - 1, MANY, MANY + 1])
def test_any_number_of_rows_is_entered(store: Store, count: int) -> None:
    rows = [{"served_at": None if number % 3 else number / 7, "line": f"{number}\t\\N %s"} for number in range(count)]
    store.write(lambda c: enter(c, turns, rows))
    found = store.read(lambda c: c.execute(select(turns.c.served_at, turns.c.line)).all())
    assert sorted(found, key=lambda row: row.line) == sorted(
        ((row["served_at"], row["line"]) for row in rows), key=lambda row: row[1]
    )


@pytest.mark.parametrize("count", [1, 2, MANY])
def test_what_the_database_refuses_is_undone_and_said(store: Store, count: int) -> None:
    def write(connection: Connection) -> None:
        enter(connection, turns, [{"line": "a"}])
        enter(connection, turns, [{"line": "a"}] * count)

    with pytest.raises(StoreUnavailableError, match=r"(?i)unique"):
        store.write(write)
    assert store.read(lambda c: COUNT.rows(c, {})[0].count) == 0


def test_values_of_any_size_follow_each_other(store: Store, hand: Hand) -> None:
    """A statement that was prepared with a small number, a short text or none takes the largest, too."""
    names = ("parameters", "message", "duplicates", "seconds")
    here = change(evaluations, ("job_id", "generation", "particle"), names)
    read = Statement(
        select(*(evaluations.c[name] for name in names)).where(
            evaluations.c.generation == 0, evaluations.c.particle == 0
        )
    )
    key = {"of_job_id": hand.job_id, "of_generation": 0, "of_particle": 0}
    for values in (
        (b"", "", 0, 0.0),
        (b"\0\\x\xff" * 3000, "Größe $1 \\x00 '" * 500, 2**31 - 1, 5e-324),
        (b"1", None, None, 1.7976931348623157e308),
        (b"2", "%s", -1, -0.1),
    ):
        given = key | {f"to_{name}": value for name, value in zip(names, values, strict=True)}
        assert store.write(lambda c, given=given: here.write(c, [given])) == 1
        found = store.read(lambda c: read.rows(c, {}))[0]
        assert tuple(found) == values
        assert [type(value) for value in found] == [type(value) for value in values]


def test_the_victim_of_a_deadlock_tries_again(fresh_postgres_url: str) -> None:
    """Once, or twice where the connection of its second try has lost what it had prepared."""
    served = change(turns, ("line",), ("served_at",))
    both = threading.Barrier(2)
    tries: list[str] = []

    def write(connection: Connection, lines: str) -> None:
        tries.append(lines)
        for number, line in enumerate(lines):
            served.write(connection, [{"of_line": line, "to_served_at": 1.0}])
            if number == 0 and tries.count(lines) == 1:
                both.wait(60.0)

    with closing(Store(Settings(database_url=fresh_postgres_url))) as store:
        rows = [{"line": line, "served_at": 0.0} for line in "ab"]
        store.write(lambda c: enter(c, turns, rows))
        threads = [
            threading.Thread(target=lambda lines=lines: store.write(lambda c: write(c, lines)))
            for lines in ("ab", "ba")
        ]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        assert len(tries) in (3, 4)
        assert store.read(lambda c: c.scalars(select(turns.c.served_at)).all()) == [1.0, 1.0]


def test_an_exchange_makes_four_statements(store: Store, hand: Hand, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lock the job, read what the exchange concerns, write the result, write the claim."""
    made: list[object] = []
    execute = Statement._execute

    def note(statement: Statement, *given: Any) -> Any:
        made.append(statement)
        return execute(statement, *given)

    monkeypatch.setattr(Statement, "_execute", note)
    event.listen(store.engine, "before_cursor_execute", lambda _c, _k, said, *_: made.append(said))
    given = (hand.job_id, hand.name, hand.course, hand.results())
    assert hand.runtime.exchange(*given, live_workers=2, want=True).claim is not None
    assert len([one for one in made if not str(one).startswith("BEGIN")]) == 4
