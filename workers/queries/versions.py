"""Under which versions a job's evaluations were made: those it was begun under, then every other set that took part."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence

from sqlalchemy import Connection, update

from geoswarm.solver.system.versions import differences, versions
from geoswarm.workers.queries.jobs import LockedJob
from geoswarm.workers.store.codec import pack_json, unpack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.event_listener import insert_events
from geoswarm.workers.store.tables import jobs

__all__ = ["note_versions", "recorded_versions", "version_warnings"]

log = logging.getLogger(__name__)

Versions = dict[str, str]


def note_versions(
    connection: Connection, locked: LockedJob, calculating: Mapping[str, Mapping[str, str] | None]
) -> None:
    """Record with a job under which versions workers calculate, None: those of this process; warn of new ones."""
    known = recorded_versions(locked.row)
    before = len(known)
    for worker, found in calculating.items():
        own = dict(versions() if found is None else found)
        if own in known or any(other is not None and not differences(other, own) for other in known):
            continue
        known.append(own)
        message = version_warnings([known[0], own])[0]
        log.warning("job %s: %s", locked.id, message, extra={"job": locked.id, "worker": worker})
        data = pack_json({"recorded": known[0], "found": own, "worker": worker, "message": message})
        insert_events(connection, [{"job_id": locked.id, "kind": "versions", "data": data, "created_at": locked.now}])
    if len(known) > before:
        connection.execute(update(jobs).where(jobs.c.id == locked.id).values(versions=pack_json(known)))


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
            warnings.append(f"started with unrecorded versions, continued with {named}")
        else:
            warnings.append(f"continued with other versions: {', '.join(differences(first, other))}")
    return [f"{warning}; numbers may differ from those of a run with one set of versions" for warning in warnings]
