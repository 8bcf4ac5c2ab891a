"""Hooks of one store: made, listed, tested, deleted."""

from __future__ import annotations

import secrets
from collections.abc import Sequence
from typing import Any

from sqlalchemy import ColumnElement, Connection, Select, and_, delete, func, insert, or_, select, text

from geoswarm.records.account import Hook, NewHook
from geoswarm.records.states import ENDED_STATES, EndedState
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.access.quotas import lock_quotas
from geoswarm.workers.errors import HookNotFoundError, HookRefusedError, JobNotFoundError, QuotaExceededError
from geoswarm.workers.notices.addresses import judge_url
from geoswarm.workers.notices.mail import judge_address
from geoswarm.workers.notices.queue import insert_delivery
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.notices.web import new_secret
from geoswarm.workers.queries.jobs import lock_job
from geoswarm.workers.store import Store
from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.codec import pack_json, to_datetime, to_optional_datetime, unpack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import deliveries, hooks

__all__ = ["Hooks"]

MANY = 1000  # deliveries of one hook that wait; more of its tests are refused


class Hooks:
    """The hooks that somebody may see: their own, an administrator all.

    Every method may raise :class:`geoswarm.workers.errors.StoreUnavailableError`, those with a ``hook_id``
    :class:`geoswarm.workers.errors.HookNotFoundError`.
    """

    def __init__(self, store: Store, principal: Principal, settings: NoticeSettings | None = None) -> None:
        self.store = store
        self.principal = principal
        self.settings = NoticeSettings.from_environment() if settings is None else settings

    def create(self, target: str, *, job_id: str | None = None, states: Sequence[EndedState] = ENDED_STATES) -> NewHook:
        """Make a hook for the caller's own jobs, or for one of them.

        A job that has ended already is announced at once.

        Parameters
        ----------
        target
            ``https://...``, or an address of e-mail.
        job_id
            The only job; None: all jobs of the owner.
        states
            Report only jobs that ended in one of these states.

        Raises
        ------
        HookRefusedError
            When target or states are not acceptable.
        JobNotFoundError, QuotaExceededError
        """
        wanted = [state for state in ENDED_STATES if state in states]
        if not wanted or len(wanted) != len(set(states)):
            raise HookRefusedError("states", f"must be one or more of {', '.join(ENDED_STATES)}")
        by_mail = "@" in target and "://" not in target
        if by_mail:
            judge_address(target, self.settings)
        else:
            judge_url(target, self.settings.networks)
        hook_id = secrets.token_hex(8)
        secret = None if by_mail else new_secret()

        owner = self.principal.owner

        def work(connection: Connection) -> Hook:
            ended = None
            if job_id is not None:
                locked = lock_job(connection, job_id)  # it cannot end between this look and the commit
                if locked is None or not self.principal.sees(locked.row.owner):
                    raise JobNotFoundError(job_id)
                ended = locked if locked.row.state in ENDED_STATES else None
            if self._find(connection, hook_id) is None:  # an earlier run may have been committed
                self._require_room(connection, owner)
                values = {"id": hook_id, "owner": owner, "job_id": job_id, "kind": "mail" if by_mail else "web"}
                values |= {"target": target, "secret": secret, "states": pack_json(wanted)}
                connection.execute(insert(hooks).values(**values, created_at=database_now()))
                if ended is not None and ended.row.state in wanted:
                    insert_delivery(connection, hook_id, ended.id, ended.row.state)
            return _view(self._row(connection, hook_id))

        return NewHook(secret=secret, view=self.store.write(work))

    def list(self) -> list[Hook]:
        """Return the hooks, oldest first."""
        statement = _listed().order_by(hooks.c.created_at, hooks.c.id)
        rows = self.store.read(lambda connection: connection.execute(statement).all())
        return [_view(row) for row in rows if self.principal.sees(row.owner)]

    def delete(self, hook_id: str) -> None:
        """Remove a hook; messages not sent yet are dropped."""

        def work(connection: Connection) -> None:
            self._row(connection, hook_id)
            connection.execute(delete(hooks).where(hooks.c.id == hook_id))

        self.store.write(work)

    def test(self, hook_id: str) -> Hook:
        """Send a test notification soon.

        Raises
        ------
        QuotaExceededError
            When too much waits for it already.
        """

        def work(connection: Connection) -> Hook:
            self._row(connection, hook_id)
            here = and_(deliveries.c.hook_id == hook_id, text("deliveries.state = 'waiting'"))
            if (connection.scalar(select(func.count()).where(here)) or 0) >= MANY:
                raise QuotaExceededError(
                    f"{MANY} messages wait for hook {hook_id}; a test message would wait behind them"
                )
            insert_delivery(connection, hook_id, None, "test")
            return _view(self._row(connection, hook_id))

        return self.store.write(work)

    def _require_room(self, connection: Connection, owner: str | None) -> None:
        lock_quotas(connection)
        own = hooks.c.owner.is_(None) if owner is None else hooks.c.owner == owner
        # Hooks of single jobs that have been told have done their work.
        open_ones = or_(hooks.c.job_id.is_(None), _some_waiting(), ~_some_delivery())
        count = connection.scalar(select(func.count()).select_from(hooks).where(own, open_ones)) or 0
        if count >= self.settings.hooks_per_owner:
            raise QuotaExceededError(
                f"{count} hooks are set; at most {self.settings.hooks_per_owner} are accepted "
                "(GEOSWARM_HOOKS_PER_OWNER)"
            )

    def _find(self, connection: Connection, hook_id: str) -> Record | None:
        return connection.execute(_listed().where(hooks.c.id == hook_id)).one_or_none()

    def _row(self, connection: Connection, hook_id: str) -> Record:
        row = self._find(connection, hook_id)
        if row is None or not self.principal.sees(row.owner):
            raise HookNotFoundError(hook_id)
        return row


def _some_waiting() -> ColumnElement[bool]:
    found = select(deliveries.c.id).where(deliveries.c.hook_id == hooks.c.id, text("deliveries.state = 'waiting'"))
    return found.limit(1).correlate(hooks).scalar_subquery().is_not(None)


def _some_delivery() -> ColumnElement[bool]:
    found = select(deliveries.c.id).where(deliveries.c.hook_id == hooks.c.id)
    return found.limit(1).correlate(hooks).scalar_subquery().is_not(None)


def _listed() -> Select[Any]:
    last = (
        select(func.max(deliveries.c.id)).where(deliveries.c.hook_id == hooks.c.id).correlate(hooks).scalar_subquery()
    )
    columns = (
        deliveries.c.state.label("last_state"),
        deliveries.c.created_at.label("last_at"),
        deliveries.c.tries.label("last_tries"),
        deliveries.c.error.label("last_error"),
    )
    return select(hooks, *columns).outerjoin(deliveries, deliveries.c.id == last)


def _view(row: Record) -> Hook:
    return Hook(
        id=row.id,
        kind=row.kind,
        target=row.target,
        states=unpack_json(row.states),
        job=row.job_id,
        owner=row.owner,
        created_at=to_datetime(row.created_at),
        last_state=row.last_state,
        last_at=to_optional_datetime(row.last_at),
        last_tries=row.last_tries,
        last_error=row.last_error,
    )
