"""Chaos: twelve jobs on PostgreSQL and Redis, done by workers and agents, while all of it is disturbed.

Processes are killed and frozen, servers restarted, messages lost and doubled, an agent's line to the service is cut;
the clock of another agent is off by an hour.

Everything random comes from one seed, which a failure names. ``CHAOS_SECONDS`` and ``CHAOS_SEED`` in the environment
choose duration and seed of the long run; ``CHAOS_REPORT`` is a file to which the summaries are appended.
"""

from __future__ import annotations

import itertools
import json
import logging
import os
import random
import secrets
import signal
import time
from collections import Counter
from pathlib import Path
from typing import Any

import psycopg
import pytest

from geoswarm import Client
from geoswarm.client.errors import GeoswarmError
from geoswarm.records.evaluation import Evaluation
from geoswarm.solver.problem import Problem
from geoswarm.solver.runs.local import calibrate
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.waker import NoWaker
from tests.chaos.faults import Disturber
from tests.chaos.fleet import MARK, Fleet
from tests.chaos.jobs import Planned, User, plan
from tests.chaos.proxy import LossyProxy
from tests.integration.clocks import an_hour_ahead
from tests.integration.cuttable import CuttableLine
from tests.integration.engines import wait_for
from tests.servers import PostgresServer, RedisServer, free_port

pytestmark = pytest.mark.usefixtures("misbehaving_models")

log = logging.getLogger(__name__)

LONG_SECONDS = float(os.environ.get("CHAOS_SECONDS", "300"))
SEED = int(os.environ.get("CHAOS_SEED", secrets.randbelow(2**32)))
SHORT_SECONDS = 25.0
SHORT_SCALE = 0.06
LONG_SCALE = 0.9 * LONG_SECONDS / 300.0  # keeps four workers on two idle cores busy for longer than the faults last
WORKERS = (2, 1, 1)  # processes of each
AGENTS = 2  # of one slot
FINISH_SECONDS = 1800.0

Bits = tuple[int, int, tuple[float, ...], float | None, dict[str, float], dict[str, list[float]], str | None]


@pytest.mark.slow
@pytest.mark.timeout(900)
def test_a_short_chaos_changes_nothing(
    fresh_postgres_url: str, redis_server: RedisServer, postgres_server: PostgresServer, tmp_path: Path
) -> None:
    summary = chaos(SHORT_SECONDS, SHORT_SCALE, SEED, fresh_postgres_url, postgres_server, redis_server, tmp_path)
    assert summary["jobs"] == 12
    assert summary["faults"]["redis restarted empty"] == 5
    assert summary["evaluations by agents"] > 0


@pytest.mark.slow
@pytest.mark.timeout(LONG_SECONDS + 3600)  # what is left to do takes long on a busy machine
def test_a_long_chaos_changes_nothing(
    fresh_postgres_url: str, redis_server: RedisServer, postgres_server: PostgresServer, tmp_path: Path
) -> None:
    summary = chaos(LONG_SECONDS, LONG_SCALE, SEED, fresh_postgres_url, postgres_server, redis_server, tmp_path)
    assert summary["jobs"] == 12
    assert summary["faults"]["redis restarted empty"] == 5
    assert summary["evaluations by agents"] > 0


def chaos(
    seconds: float,
    scale: float,
    seed: int,
    database_url: str,
    postgres: PostgresServer,
    redis: RedisServer,
    folder: Path,
) -> dict[str, Any]:
    """Disturb an installation for some time, then let it finish, and compare with undisturbed runs; return figures."""
    chance = random.Random(seed)
    redis.start()
    cured = folder / "cured"
    jobs = plan(scale, cured)
    cured.touch()
    expected = [calm_history(job.problem) for job in jobs]
    cured.unlink()
    key, port = secrets.token_hex(16), free_port()
    with LossyProxy(redis.port, random.Random(chance.random())) as proxy, CuttableLine(port) as line:
        backends = ("--database", database_url, "--broker", f"redis://127.0.0.1:{proxy.port}/0")
        commands = {
            f"worker {number}": ("worker", "--concurrency", str(processes), *backends)
            for number, processes in enumerate(WORKERS)
        }
        commands |= {"api": ("serve", "--port", str(port), *backends), "sweep": ("sweep", *backends)}
        for number in range(AGENTS):  # the first one behind a line that can be cut
            address = f"http://127.0.0.1:{line.port if number == 0 else port}"
            commands[f"agent {number}"] = ("agent", "--server", address, "--slots", "1")
        wrong = {f"agent {AGENTS - 1}": an_hour_ahead()}
        environment = {
            "GEOSWARM_API_KEY": key,
            "GEOSWARM_KEY": agent_key(database_url),
            "GEOSWARM_PASS_ENVIRONMENT": MARK,
            "XDG_STATE_HOME": str(folder / "state"),
        }
        with (
            Fleet(commands, folder, environment, wrong) as fleet,
            Client(f"http://127.0.0.1:{port}", api_key=key, timeout=10.0) as client,
        ):
            try:
                summary = run(fleet, client, jobs, seconds, chance, database_url, postgres, redis, line)
                summary |= {"messages": dict(proxy.counts), **check(database_url, jobs, expected, summary.pop("calm"))}
                codes = fleet.stop()
                # one that was started a moment ago does not know yet what to do when it is asked to end
                assert set(codes.values()) <= {0, -signal.SIGTERM}, codes
                assert_nothing_is_left(fleet, database_url)
            except BaseException as error:
                error.add_note(f"CHAOS_SEED={seed}\n{fleet.logs()}")
                raise
    summary = {"seed": seed, "seconds of faults": seconds, **summary}
    log.warning("chaos: %s", json.dumps(summary))
    if "CHAOS_REPORT" in os.environ:
        with Path(os.environ["CHAOS_REPORT"]).open("a") as report:
            report.write(json.dumps(summary) + "\n")
    return summary


def run(
    fleet: Fleet,
    client: Client,
    jobs: list[Planned],
    seconds: float,
    chance: random.Random,
    database_url: str,
    postgres: PostgresServer,
    redis: RedisServer,
    line: CuttableLine,
) -> dict[str, Any]:
    """Submit and disturb; return what was done."""

    def all_there() -> bool:
        fleet.supervise()
        try:
            return len(client.workers()) == sum(WORKERS) + AGENTS
        except GeoswarmError:
            return False

    wait_for(all_there, f"{sum(WORKERS)} workers and {AGENTS} agents", 120.0)
    began = time.monotonic()
    user = User(client, jobs, seconds, random.Random(chance.random()))
    disturber = Disturber(fleet, postgres, redis, line, database_url, chance)
    user.start()
    disturber.disturb(seconds)
    calm = time.time()

    def all_ended() -> bool:
        fleet.supervise()
        try:
            states = [job.state for job in client.iterate_jobs()]
        except GeoswarmError as error:
            log.info("the service does not answer: %s", error)
            return False
        time.sleep(0.2)
        return len(states) == len(jobs) and not {"queued", "running", "paused"}.intersection(states)

    try:
        wait_for(lambda: all_ended() and not user.is_alive(), "the end of all jobs", FINISH_SECONDS)
    except AssertionError as error:
        error.add_note(f"user {'acts' if user.is_alive() else 'has ended'}; workers: {client.workers()}")
        for job in client.iterate_jobs():
            counted = f"{job.evaluations} of {job.max_evaluations} evaluations, generation {job.generations}"
            error.add_note(f"{job.id} {job.name}: {job.state}, {counted}")
        raise
    user.join()
    assert user.problem is None
    return {
        "faults": dict(disturber.counts),
        "restarts by the supervisor": fleet.restarts,
        "ended by themselves": dict(fleet.ended),
        "user": dict(user.counts),
        "calm": calm,
        "seconds to finish afterwards": round(time.time() - calm, 1),
        "seconds in all": round(time.monotonic() - began, 1),
    }


def agent_key(database_url: str) -> str:
    """Make a key of role agent."""
    store = Store(Settings(database_url=database_url))
    try:
        return ApiKeys(store).create("agents", "agent")[0]
    finally:
        store.close()


def calm_history(problem: Problem) -> list[Bits]:
    """What the undisturbed run in one process gives."""
    return [
        (
            record.generation,
            record.particle,
            tuple(record.evaluation.parameters.tolist()),
            record.evaluation.objective,
            dict(record.evaluation.misfits),
            {series: values.tolist() for series, values in record.evaluation.responses.items()},
            record.evaluation.reason,
        )
        for record in calibrate(problem).history
    ]


def check(database_url: str, jobs: list[Planned], expected: list[list[Bits]], calm: float) -> dict[str, Any]:
    """Compare every job with its undisturbed run, and its accounts with themselves; return the totals."""
    outcomes: Counter[str] = Counter()
    evaluations, by_agents, runs, ended = 0, 0, 0.0, []
    store = Store(Settings(database_url=database_url))
    try:
        service = JobService(store, NoWaker())
        ids = {job.name: job.id for job in service.list(limit=100).items}
        assert sorted(ids) == sorted(job.problem.name for job in jobs)
        for job, history in zip(jobs, expected, strict=True):
            name, job_id = job.problem.name, ids[job.problem.name]
            view = service.get(job_id)
            found = list(service.iterate_evaluations(job_id, responses=True))
            assert view.state == "finished", (name, view.error)
            assert [recorded(one) for one in found] == history, name
            assert (view.evaluations, view.failed_evaluations) == (
                len(history),
                sum(bits[-1] is not None for bits in history),
            ), name
            generations = service.generations(job_id, limit=10_000)
            assert [g.number for g in generations] == list(range(view.generations)), name
            sizes = Counter(bits[0] for bits in history)
            totals = [0, *(g.evaluations for g in generations)]
            assert [after - before for before, after in itertools.pairwise(totals)] == [
                sizes[g.number] for g in generations
            ], name
            assert_told_once(service, job_id, view.generations)
            for one in found:
                outcomes.update(tries(service, job_id, one))
            by_agents += sum("/" in (one.worker or "") for one in found)
            evaluations += len(found)
            runs += sum(one.seconds or 0.0 for one in found)
            ended.append(view.finished_at)
    finally:
        store.close()
    return {
        "jobs": len(jobs),
        "jobs that ended after the faults": sum(at is not None and at.timestamp() > calm for at in ended),
        "evaluations": evaluations,
        "evaluations by agents": by_agents,
        "seconds of counted forward runs": round(runs, 1),
        "tries": dict(outcomes),
    }


def recorded(view: Evaluation) -> Bits:
    """What the engine has stored of one evaluation."""
    return (
        view.generation,
        view.particle,
        tuple(view.parameters.values()),
        view.objective,
        view.misfits,
        {series: curve.y for series, curve in (view.responses or {}).items()},
        view.reason,
    )


def assert_told_once(service: JobService, job_id: str, generations: int) -> None:
    """Every generation is announced once and in order, and the end once."""
    numbers: list[int] = []
    states: list[str] = []
    after = 0
    while events := service.events(job_id, after=after, limit=5000):
        after = events[-1].id
        numbers += [event.data["number"] for event in events if event.kind == "generation"]
        states += [event.data["state"] for event in events if event.kind == "state"]
    assert numbers == list(range(generations))
    assert states[0] == "queued"
    assert [state for state in states if state in ("finished", "failed", "cancelled")] == states[-1:] == ["finished"]


def tries(service: JobService, job_id: str, view: Evaluation) -> list[str]:
    """Return how the tries at an evaluation ended, of which one counts."""
    if view.attempts == 1:
        return [view.reason or view.state]  # nothing was lost
    found = service.attempts(job_id, view.generation, view.particle)
    assert sum(one.counted for one in found) == 1, found
    assert sorted(one.number for one in found) == list(range(1, view.attempts + 1)), found
    return [one.outcome for one in found]


def assert_nothing_is_left(fleet: Fleet, database_url: str) -> None:
    """No process of the fleet lives, and none is connected to the database."""
    wait_for(lambda: not fleet.processes(), "the end of all processes")
    with psycopg.connect(database_url.replace("+psycopg", "", 1), autocommit=True) as connection:
        others = "SELECT count(*) FROM pg_stat_activity WHERE datname = current_database() AND pid <> pg_backend_pid()"
        wait_for(lambda: connection.execute(others).fetchone() == (0,), "the end of all connections")
