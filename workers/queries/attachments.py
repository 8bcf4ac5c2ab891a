"""Queries on files that are attached to jobs."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from sqlalchemy import ColumnElement, Connection, and_, delete, func, insert, select

from geoswarm.workers.store.clock import database_now
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.tables import attachment_pieces, attachments, jobs

__all__ = [
    "attached_bytes",
    "count_attachments",
    "delete_attachment",
    "find_attachment",
    "hold_job",
    "insert_attachment",
    "list_attachments",
    "read_piece",
]


def hold_job(connection: Connection, job_id: str) -> None:
    """Keep a job from being deleted until the end of the transaction; SQLite has one writer anyway."""
    connection.execute(select(jobs.c.id).where(jobs.c.id == job_id).with_for_update(read=True, key_share=True))


def list_attachments(connection: Connection, job_id: str) -> Sequence[Record]:
    """Return the files of a job, oldest first."""
    order = (attachments.c.created_at, attachments.c.name)
    return connection.execute(select(attachments).where(attachments.c.job_id == job_id).order_by(*order)).all()


def find_attachment(connection: Connection, job_id: str, sha256: str) -> Record | None:
    """Return one file of a job."""
    return connection.execute(select(attachments).where(_is(job_id, sha256))).one_or_none()


def read_piece(connection: Connection, job_id: str, sha256: str, number: int) -> bytes | None:
    """Return a piece of a file; None: there is none of this number."""
    pieces = attachment_pieces.c
    found = and_(pieces.job_id == job_id, pieces.sha256 == sha256, pieces.number == number)
    return connection.scalar(select(pieces.content).where(found))


def insert_attachment(connection: Connection, values: Mapping[str, Any], pieces: Iterable[bytes]) -> None:
    """Store a file, one piece at a time."""
    connection.execute(insert(attachments).values(**values, created_at=database_now()))
    key = {"job_id": values["job_id"], "sha256": values["sha256"]}
    for number, content in enumerate(pieces):
        connection.execute(insert(attachment_pieces), {**key, "number": number, "content": content})


def delete_attachment(connection: Connection, job_id: str, sha256: str | None = None) -> bool:
    """Remove a file of a job, any one of its files if none is named; return whether there was one."""
    if sha256 is None:
        sha256 = connection.scalar(select(attachments.c.sha256).where(attachments.c.job_id == job_id).limit(1))
    if sha256 is None:
        return False
    return connection.execute(delete(attachments).where(_is(job_id, sha256))).rowcount > 0


def count_attachments(connection: Connection, job_id: str) -> tuple[int, int]:
    """Return the number of files of a job, and their bytes."""
    bytes_of = func.coalesce(func.sum(attachments.c.size), 0)
    number, size = connection.execute(select(func.count(), bytes_of).where(attachments.c.job_id == job_id)).one()
    return number, int(size)


def attached_bytes(connection: Connection, owner: str) -> int:
    """Return the bytes of all files that are attached to the jobs of an owner."""
    size = select(func.sum(attachments.c.size)).join(jobs, jobs.c.id == attachments.c.job_id)
    return int(connection.scalar(size.where(jobs.c.owner == owner)) or 0)


def _is(job_id: str, sha256: str) -> ColumnElement[bool]:
    return and_(attachments.c.job_id == job_id, attachments.c.sha256 == sha256)
