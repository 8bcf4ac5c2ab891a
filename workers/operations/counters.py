"""Counts what happens in this process, and adds it to the counters in the database now and then.

Processes come and go, and several run at once: what Prometheus reads are the sums in the database. A killed process
takes what it counted since its last heartbeat with it. The counters are for watching; the accounts are the jobs' rows.
"""

from __future__ import annotations

import threading
from collections import defaultdict
from collections.abc import Mapping, Sequence

from sqlalchemy import Connection, select
from sqlalchemy.dialects.postgresql import insert as postgresql_insert
from sqlalchemy.dialects.sqlite import insert as sqlite_insert

from geoswarm.workers.errors import StoreUnavailableError
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import counters

__all__ = ["BUCKETS", "Counters", "read_counters", "process_counters"]

BUCKETS: Sequence[float] = (0.001, 0.003, 0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0, 300.0, 1000.0, 3600.0)
"""Upper limits of the classes of seconds per run [s]; the last class has none."""

_BUCKET_LABELS = tuple(f"{limit:g}" for limit in BUCKETS)
MOST_LABELS = 40


class Counters:
    """Counters of one process; safe to use from several threads."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._counts: defaultdict[tuple[str, str], float] = defaultdict(float)

    def add(self, name: str, label: str = "", amount: float = 1) -> None:
        """Add to a counter."""
        with self._lock:
            self._counts[name, label[:MOST_LABELS]] += amount

    def run(self, outcome: str, seconds: float) -> None:
        """Count a forward run that took so long [s]; ``outcome`` is ``finished`` or the reason of its failure."""
        label = next((text for text, limit in zip(_BUCKET_LABELS, BUCKETS, strict=True) if seconds <= limit), "+Inf")
        with self._lock:
            self._counts["runs", outcome[:MOST_LABELS]] += 1
            self._counts["run_seconds", label] += 1
            self._counts["run_seconds_sum", ""] += seconds

    def take(self) -> dict[tuple[str, str], float]:
        """Return what was counted since the last call."""
        with self._lock:
            counts, self._counts = self._counts, defaultdict(float)
        return dict(counts)

    def flush(self, store: Store) -> None:
        """Add to the database what was counted since the last time; keep it when the database does not answer.

        Raises
        ------
        StoreUnavailableError
        """
        counts = self.take()
        if not counts:
            return
        try:
            store.write(lambda connection: _add(connection, counts))
        except StoreUnavailableError:
            with self._lock:
                for key, amount in counts.items():
                    self._counts[key] += amount
            raise


process_counters = Counters()
"""The one of this process."""


def _add(connection: Connection, counts: Mapping[tuple[str, str], float]) -> None:
    upsert = sqlite_insert if connection.dialect.name == "sqlite" else postgresql_insert
    # In one order everywhere, so that two processes never wait for each other's rows crosswise.
    rows = [{"name": name, "label": label, "value": float(counts[name, label])} for name, label in sorted(counts)]
    statement = upsert(counters).values(rows)
    connection.execute(
        statement.on_conflict_do_update(
            index_elements=[counters.c.name, counters.c.label],
            set_={"value": counters.c.value + statement.excluded.value},
        )
    )


def read_counters(connection: Connection) -> dict[tuple[str, str], float]:
    """Return the sums over all processes, by name and label."""
    rows = connection.execute(select(counters.c.name, counters.c.label, counters.c.value))
    return {(row.name, row.label): row.value for row in rows}
