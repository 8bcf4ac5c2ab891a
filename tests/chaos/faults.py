"""What goes wrong, when, and to whom: chosen by one seed, done to the processes of this test only."""

from __future__ import annotations

import logging
import math
import random
import signal
import time
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import psycopg

from tests.chaos.fleet import Fleet, send
from tests.integration.cuttable import CuttableLine
from tests.servers import PostgresServer, RedisServer

__all__ = ["Disturber"]

log = logging.getLogger(__name__)

KILLS = {
    **{"worker": 3, "pool": 3, "evaluation": 3, "fork server": 1, "coordinator": 3, "api": 2, "sweep": 1, "frozen": 2},
    **{"agent": 3, "agent frozen": 2, "line": 2},
}
"""How often each kind of fault is chosen, relative to the others; what is frozen comes back late, as does a line."""
DONE = {"frozen": "worker process frozen", "agent frozen": "agent frozen", "line": "line of an agent cut"}
FROZEN_SECONDS = (4.0, 16.0)  # shorter and longer than a lease
REDIS_RESTARTS = 5
POSTGRES_RESTARTS = 3
LOOK_SECONDS = 1.0  # for a worker that is in a transaction with a job locked

# Who holds the row of a job, or has just locked it: the backend's transaction took a lock for SELECT ... FOR UPDATE.
HOLDERS = """
SELECT a.client_port FROM pg_stat_activity a JOIN pg_locks l ON l.pid = a.pid
WHERE l.relation = 'jobs'::regclass AND l.mode = 'RowShareLock' AND l.granted
  AND a.wait_event_type IS DISTINCT FROM 'Lock' AND a.pid <> pg_backend_pid()
"""


class Disturber:
    """Kills and restarts for a while; ``counts`` tells what was done."""

    def __init__(
        self,
        fleet: Fleet,
        postgres: PostgresServer,
        redis: RedisServer,
        line: CuttableLine,
        database_url: str,
        chance: random.Random,
    ) -> None:
        self.counts: Counter[str] = Counter()
        self._frozen: dict[int, float] = {}
        self._line = line
        self._cut_until: float | None = None
        self._postgres_fast = bool(chance.getrandbits(1))
        self._fleet = fleet
        self._postgres = postgres
        self._redis = redis
        self._dsn = database_url.replace("+psycopg", "", 1)
        self._chance = chance

    def disturb(self, seconds: float) -> None:
        """Let one process be killed every 1 to 3 s, Redis be emptied five times, PostgreSQL restarted three times."""
        began = time.monotonic()
        planned = sorted(
            [(at, self._restart_redis) for at in self._spread(REDIS_RESTARTS, seconds)]
            + [(at, self._restart_postgres) for at in self._spread(POSTGRES_RESTARTS, seconds)],
            key=lambda plan: plan[0],
        )
        next_kill = self._chance.uniform(1, 3)
        while (now := time.monotonic() - began) < seconds or planned:
            self._fleet.supervise()
            self._thaw(time.monotonic())
            if planned and now >= planned[0][0]:
                planned.pop(0)[1]()
            elif now >= next_kill:
                next_kill += self._chance.uniform(1, 3)
                self._kill_one()
            else:
                time.sleep(0.05)
        self._thaw(math.inf)

    def _spread(self, times: int, seconds: float) -> list[float]:
        return [(number + self._chance.random()) * seconds / times for number in range(times)]

    def _restart_redis(self) -> None:
        self._redis.kill()
        time.sleep(self._chance.uniform(0, 0.5))
        self._redis.restart(empty=True)
        self._note("redis restarted empty")

    def _restart_postgres(self) -> None:
        fast = self._postgres_fast = not self._postgres_fast
        end: Callable[[], None] = self._postgres.stop if fast else self._postgres.kill
        end()
        time.sleep(self._chance.uniform(0, 0.5))
        self._postgres.start()
        self._note(f"postgresql restarted ({'fast' if fast else 'immediate'})")

    def _kill_one(self) -> None:
        """Kill a process of a kind chosen at random, of another kind while there is none of it."""
        kinds = list(KILLS)
        order = sorted(kinds, key=lambda kind: self._chance.random() ** (1 / KILLS[kind]), reverse=True)
        for kind in order:
            if self._kill_a(kind):
                self._note(DONE.get(kind, f"{kind} killed"))
                return

    def _kill_a(self, kind: str) -> bool:
        fleet = self._fleet
        if kind in ("worker", "agent", "api", "sweep"):
            return fleet.kill(self._chance.choice(self._named(kind)))
        if kind == "line":
            return self._cut()
        if kind == "agent frozen":
            process = fleet.members[self._chance.choice(self._named("agent"))].process
            return process is not None and process.poll() is None and self._stop(process.pid)
        below = fleet.below()
        if kind == "frozen":
            return self._freeze(below["pool"])
        if kind == "coordinator":
            pid = self._coordinator(below["pool"])
            return pid is not None and send(pid, signal.SIGKILL)
        return bool(below[kind]) and send(self._chance.choice(below[kind]), signal.SIGKILL)

    def _freeze(self, pool: list[int]) -> bool:
        """Stop a worker process: nothing is heard of it, its lease ends, and later it hands in what it has."""
        awake = [pid for pid in pool if pid not in self._frozen]
        if len(awake) < 2:
            return False
        return self._stop(self._chance.choice(awake))

    def _named(self, kind: str) -> list[str]:
        return [name for name in self._fleet.members if name.startswith(kind)]

    def _stop(self, pid: int) -> bool:
        if pid in self._frozen:
            return False
        self._frozen[pid] = time.monotonic() + self._chance.uniform(*FROZEN_SECONDS)
        return send(pid, signal.SIGSTOP)

    def _cut(self) -> bool:
        """Cut the line between an agent and the service for a while."""
        if self._cut_until is not None:
            return False
        self._cut_until = time.monotonic() + self._chance.uniform(*FROZEN_SECONDS)
        self._line.cut()
        return True

    def _thaw(self, now: float) -> None:
        if self._cut_until is not None and self._cut_until < now:
            self._cut_until = None
            self._line.mend()
        for pid in [pid for pid, until in self._frozen.items() if until < now]:
            del self._frozen[pid]
            if pid in self._fleet.processes():  # another process may have its number by now
                send(pid, signal.SIGCONT)

    def _coordinator(self, pool: list[int]) -> int | None:
        """Return a worker process that has a job locked at this moment, None: none was met."""
        by_port = _owners_of_ports(pool)
        deadline = time.monotonic() + LOOK_SECONDS
        try:
            with psycopg.connect(self._dsn, autocommit=True, connect_timeout=2) as connection:
                while time.monotonic() < deadline:
                    for (port,) in connection.execute(HOLDERS).fetchall():
                        if port in by_port:
                            return by_port[port]
        except psycopg.OperationalError as error:
            log.info("no look at the transactions: %s", error)
        return None

    def _note(self, what: str) -> None:
        self.counts[what] += 1
        log.info("%s", what)


def _owners_of_ports(pids: list[int]) -> dict[int, int]:
    """Return which of these processes has the socket with a local TCP port."""
    owners: dict[str, int] = {}
    for pid in pids:
        try:
            for descriptor in Path(f"/proc/{pid}/fd").iterdir():
                owners[str(descriptor.readlink())] = pid
        except OSError:  # it has ended, or closed that descriptor, meanwhile
            continue
    ports: dict[int, int] = {}
    for line in Path("/proc/net/tcp").read_text().splitlines()[1:]:
        fields = line.split()
        owner = owners.get(f"socket:[{fields[9]}]")
        if owner is not None:
            ports[int(fields[1].rpartition(":")[2], 16)] = owner
    return ports
