"""Files that people attach to a job: a photo of the specimen, the laboratory's PDF."""

from __future__ import annotations

import builtins
import hashlib
import os
import re
from collections.abc import Callable, Iterator
from functools import partial
from typing import IO, Any

from sqlalchemy import Connection

from geoswarm.records.job import Attachment
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.access.quotas import check_attachment_quotas, lock_quotas
from geoswarm.workers.errors import AttachmentNotFoundError, AttachmentRefusedError, StoreUnavailableError
from geoswarm.workers.operations.retention import empty_journal_now, overwrite_deleted
from geoswarm.workers.queries.attachments import (
    delete_attachment,
    find_attachment,
    hold_job,
    insert_attachment,
    list_attachments,
    read_piece,
)
from geoswarm.workers.service.media_types import PIECE_BYTES, checked_name, media_type_of
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import to_datetime
from geoswarm.workers.store.database import Record

__all__ = ["Attachments"]

SHA256 = re.compile("[0-9a-f]{64}")  # nothing else needs to reach the database


class Attachments:
    """Files of the jobs that somebody may see; ``find`` is :meth:`.job_service.JobService._row`.

    Every method may raise :class:`geoswarm.workers.errors.StoreUnavailableError` and
    :class:`geoswarm.workers.errors.JobNotFoundError`. None holds a whole file in memory.
    """

    def __init__(
        self, store: Store, find: Callable[[Connection, str], Any], settings: Settings, principal: Principal
    ) -> None:
        self._store = store
        self._find = find
        self._settings = settings
        self._principal = principal
        self._hidden = principal.job_id is not None  # a read-only link shows no files: see decision 0060

    def list(self, job_id: str) -> builtins.list[Attachment]:
        """Return the files of a job, oldest first."""

        def work(connection: Connection) -> builtins.list[Attachment]:
            self._find(connection, job_id)
            return [] if self._hidden else [_view(row) for row in list_attachments(connection, job_id)]

        return self._store.read(work)

    def add(self, job_id: str, name: str, content: IO[bytes]) -> tuple[Attachment, bool]:
        """Attach a file; return it and whether it is new. A content that the job has already keeps its name.

        Parameters
        ----------
        content
            A file that can be read from any place.

        Raises
        ------
        AttachmentRefusedError
            When the name is not acceptable, or the file is empty, too large, or of a type that is not accepted.
        QuotaExceededError
            When the job or its owner has as much as is granted.
        """
        self._store.read(lambda connection: self._find(connection, job_id))
        name = checked_name(name)
        size = content.seek(0, os.SEEK_END)
        most = self._settings.attachment_mb
        if size == 0:
            raise AttachmentRefusedError("content", f"{name!r} is empty (0 bytes)")
        if size > most * 1e6:
            has = f"{name!r} has {size / 1e6:.1f} MB; at most {most:g} MB are accepted (GEOSWARM_ATTACHMENT_MB)"
            raise AttachmentRefusedError("content", has)
        media_type = media_type_of(name, content)
        hashed = hashlib.sha256()
        for piece in _pieces(content):
            hashed.update(piece)
        sha256 = hashed.hexdigest()
        values = {"job_id": job_id, "sha256": sha256, "name": name, "media_type": media_type, "size": size}
        quota_of = None if self._principal.role == "admin" else self._principal.owner
        taken = 0 if quota_of is None else self._store.size_bytes()

        def work(connection: Connection) -> tuple[Attachment, bool]:
            lock_quotas(connection)  # before the look: its holder may attach the same file
            hold_job(connection, job_id)
            self._find(connection, job_id)
            row = find_attachment(connection, job_id, sha256)
            new = row is None
            if row is None:
                if shortage := self._store.shortage(self._settings.disk_reserve_mb * 1e6):
                    raise StoreUnavailableError(shortage)
                check_attachment_quotas(connection, job_id, quota_of, size, self._settings, taken=taken)
                insert_attachment(connection, values, _pieces(content))
                row = find_attachment(connection, job_id, sha256)
            return _view(row), new

        return self._store.write(work)

    def get(self, job_id: str, sha256: str) -> Attachment:
        """Return one file, without its content.

        Raises
        ------
        AttachmentNotFoundError
        """
        return self._store.read(lambda connection: self._get(connection, job_id, sha256))

    def _get(self, connection: Connection, job_id: str, sha256: str) -> Attachment:
        self._find(connection, job_id)
        known = not self._hidden and SHA256.fullmatch(sha256)
        row = find_attachment(connection, job_id, sha256) if known else None
        if row is None:
            raise AttachmentNotFoundError(job_id, sha256[:80])
        return _view(row)

    def content(self, job_id: str, sha256: str) -> Iterator[bytes]:
        """Return the content of one file, in pieces.

        Raises
        ------
        AttachmentNotFoundError
            Also in mid-file, when it is deleted meanwhile.
        """
        size = self.get(job_id, sha256).size
        return self._content(job_id, sha256, size)

    def _content(self, job_id: str, sha256: str, size: int) -> Iterator[bytes]:
        for number in range(-(-size // PIECE_BYTES)):
            piece = self._store.read(partial(read_piece, job_id=job_id, sha256=sha256, number=number))
            if piece is None:
                raise AttachmentNotFoundError(job_id, sha256)
            yield piece

    def delete(self, job_id: str, sha256: str) -> None:
        """Remove a file for good.

        Raises
        ------
        AttachmentNotFoundError
        """

        def work(connection: Connection) -> None:
            self._get(connection, job_id, sha256)
            overwrite_deleted(connection)
            delete_attachment(connection, job_id, sha256)

        self._store.write(work)
        empty_journal_now(self._store)


def _pieces(content: IO[bytes]) -> Iterator[bytes]:
    """The content as it is stored: in pieces of the same size, but the last one."""
    content.seek(0)
    while piece := content.read(PIECE_BYTES):
        yield piece


def _view(row: Record) -> Attachment:
    return Attachment(
        sha256=row.sha256,
        name=row.name,
        media_type=row.media_type,
        size=row.size,
        created_at=to_datetime(row.created_at),
    )
