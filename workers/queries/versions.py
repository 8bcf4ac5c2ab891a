"""Under which versions a job's evaluations were made: those it was begun under, then every other set that took part."""

from __future__ import annotations

import logging
from collections.abc import Sequence

from sqlalchemy import Connection, update

from geoswarm.solver.system.versions import differences, versions
from geoswarm.workers.queries.jobs import LockedJob
from geoswarm.workers.store.codec import pack_json, unpack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.event_bell import insert_events
from geoswarm.workers.store.tables import jobs

__all__ = ["note_versions", "recorded_versions", "version_warnings"]

log = logging.getLogger(__name__)

Versions = dict[str, str]


def note_versions(connection: Connection, locked: LockedJob, worker: str) -> None:
    """Record the versions of this process with a job that it evaluates for, and warn when they are new to it."""
    own = dict(versions())
    known = recorded_versions(locked.row)
    if any(other is not None and not differences(other, own) for other in known):
        return
    after = [*known, own]
    connection.execute(update(jobs).where(jobs.c.id == locked.id).values(versions=pack_json(after)))
    message = version_warnings([known[0], own])[0]
    log.warning("job %s: %s", locked.id, message, extra={"job": locked.id, "worker": worker})
    data = pack_json({"recorded": known[0], "found": own, "worker": worker, "message": message})
    insert_events(connection, [{"job_id": locked.id, "kind": "versions", "data": data, "created_at": locked.now}])


def recorded_versions(row: Record) -> list[Versions | None]:
    """Return what is recorded with a job; the first is None when it is not begun or an older program began it."""
    return [None] if row.versions is None else unpack_json(row.versions)


def version_warnings(recorded: Sequence[Versions | None]) -> list[str]:
    """Return one warning for each set of versions after the first, which is None when it is not known."""
    first, *others = recorded
    warnings = []
    for other in others:
        if other is None:
            continue
        if first is None:
            named = ", ".join(f"{name} {number}" for name, number in other.items())
            warnings.append(f"begun under versions that were not recorded, continued under {named}")
        else:
            warnings.append(f"continued under other versions: {', '.join(differences(first, other))}")
    return [f"{warning}; numbers may differ from those of a run under one set of versions" for warning in warnings]
