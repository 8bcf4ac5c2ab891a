"""Under which versions a job's evaluations were made: those it was begun under, then every other set that took part."""

from __future__ import annotations

import logging
from collections.abc import Mapping, Sequence
from functools import lru_cache

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
    recorded = locked.row.versions
    sets = {worker: versions() if found is None else found for worker, found in calculating.items()}
    new = {worker: dict(own) for worker, own in sets.items() if not _is_recorded(recorded, frozenset(own.items()))}
    if not new:
        return
    known = recorded_versions(locked.row)
    for worker, own in new.items():
        if _is_among(known, own):
            continue
        known.append(own)
        message = version_warnings([known[0], own])[0]
        log.warning("job %s: %s", locked.id, message, extra={"job": locked.id, "worker": worker})
        data = pack_json({"recorded": known[0], "found": own, "worker": worker, "message": message})
        insert_events(connection, [{"job_id": locked.id, "kind": "versions", "data": data, "created_at": locked.now}])
    connection.execute(update(jobs).where(jobs.c.id == locked.id).values(versions=pack_json(known)))


@lru_cache(maxsize=256)
def _is_recorded(recorded: str | None, own: frozenset[tuple[str, str]]) -> bool:
    """Whether a set of versions needs no entry in ``versions`` of a job's row: each exchange asks this."""
    return _is_among(_unpacked(recorded), dict(own))


def _is_among(known: Sequence[Versions | None], own: Versions) -> bool:
    return own in known or any(other is not None and not differences(other, own) for other in known)


def recorded_versions(row: Record) -> list[Versions | None]:
    """Return what is recorded with a job; the first is None when it is not begun or an older program began it."""
    return _unpacked(row.versions)


def _unpacked(recorded: str | None) -> list[Versions | None]:
    return [None] if recorded is None else unpack_json(recorded)


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
