"""Read-only links: keys that show one job to people without a key of their own, until they expire or are revoked."""

from __future__ import annotations

import builtins
from collections.abc import Callable
from typing import Any

from sqlalchemy import Connection

from geoswarm.records.account import Key
from geoswarm.workers.access.keys import ApiKeys
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.access.quotas import lock_quotas
from geoswarm.workers.errors import JobNotFoundError, QuotaExceededError
from geoswarm.workers.queries import api_keys
from geoswarm.workers.queries.attachments import hold_job
from geoswarm.workers.store import Store

__all__ = ["MOST_LINKS", "Links"]

MOST_LINKS = 100
"""Links of a job that are valid at a time."""


class Links:
    """Read-only links to the jobs that somebody may see; ``find`` is :meth:`.job_service.JobService._row`.

    Every method may raise :class:`geoswarm.workers.errors.StoreUnavailableError` and
    :class:`geoswarm.workers.errors.JobNotFoundError`: the sender that a link admits sees no links.
    """

    def __init__(self, store: Store, find: Callable[[Connection, str], Any], principal: Principal) -> None:
        self._store = store
        self._find = find
        self._principal = principal
        self._keys = ApiKeys(store)

    def list(self, job_id: str) -> builtins.list[Key]:
        """Return the links to a job, without their secrets, oldest first."""
        self._owner(job_id)
        return self._keys.list(job_id)

    def create(self, job_id: str, *, label: str = "", valid_seconds: float) -> tuple[str, Key]:
        """Make a link; return its key, this once, and what is stored of it.

        Parameters
        ----------
        valid_seconds
            Time until it expires [s].

        Raises
        ------
        QuotaExceededError
            When the job has as many valid links as are granted.
        SettingsError
            When label or time is not acceptable.
        """
        owner = self._owner(job_id)

        def admit(connection: Connection) -> None:
            lock_quotas(connection)  # before the look: its holder may take the last one
            hold_job(connection, job_id)
            self._find(connection, job_id)
            if sum(row.state == "active" for row in api_keys.list_keys(connection, job_id)) >= MOST_LINKS:
                raise QuotaExceededError(
                    f"the job has {MOST_LINKS} valid links; revoke those that are no longer needed"
                )

        return self._keys.create(owner, "read", label=label, valid_seconds=valid_seconds, job_id=job_id, admit=admit)

    def revoke(self, job_id: str, link_id: str) -> Key:
        """Revoke a link, at once and permanently.

        Raises
        ------
        KeyNotFoundError
        """
        self._owner(job_id)
        return self._keys.revoke(link_id, job_id)

    def _owner(self, job_id: str) -> str:
        if self._principal.job_id is not None:
            raise JobNotFoundError(job_id)
        return self._store.read(lambda connection: self._find(connection, job_id)).owner or ""
