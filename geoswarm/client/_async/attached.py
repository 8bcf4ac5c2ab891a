"""Files that are attached to a job: a photo of the specimen, the laboratory's PDF."""

from __future__ import annotations

import asyncio
from pathlib import Path

from geoswarm.client._async.connection import AsyncConnection
from geoswarm.client.calls import FILE_BODY, Call, job_path, nothing, reader
from geoswarm.client.files import partial_file
from geoswarm.records.job import Attachment

__all__ = ["attach", "attachments", "delete_attachment", "download_attachment"]


async def attachments(self: AsyncConnection, job_id: str) -> tuple[Attachment, ...]:
    """List the files that are attached to a job, oldest first.

    Examples
    --------
    >>> attached = await client.attach(job.id, "specimen.csv")
    >>> [file.name for file in await client.attachments(job.id)]
    ['specimen.csv']
    """
    read = reader(tuple[Attachment, ...], "items")
    return await self._send(Call("GET", f"{job_path(job_id)}/attachments", read))


async def attach(self: AsyncConnection, job_id: str, path: str | Path, name: str | None = None) -> Attachment:
    """Attach a file to a job: an image (PNG, JPEG, WebP), PDF, text, CSV, AGS, or a workbook (XLSX, ODS).

    A content that the job has already is not attached again.

    Parameters
    ----------
    name
        What it is called in the job; that of the file when not given.

    Examples
    --------
    >>> attached = await client.attach(job.id, "specimen.csv")
    >>> attached.name, attached.media_type, attached.size
    ('specimen.csv', 'text/csv', 16)
    """
    path = Path(path)
    content = await asyncio.to_thread(path.read_bytes)
    query = {"name": name or path.name}
    call = Call("POST", f"{job_path(job_id)}/attachments", reader(Attachment), query, FILE_BODY, content)
    return await self._send(call)


async def download_attachment(self: AsyncConnection, job_id: str, sha256: str, path: str | Path) -> Path:
    """Save a file that is attached to a job; the file appears only when it is complete.

    Examples
    --------
    >>> attached = await client.attach(job.id, "specimen.csv")
    >>> saved = await client.download_attachment(job.id, attached.sha256, "copy.csv")
    >>> saved.read_text()
    'height [mm];20.2'
    """
    target = Path(path)
    with partial_file(target) as file:
        await self._download(Call("GET", _path(job_id, sha256), nothing), file)
    return target


async def delete_attachment(self: AsyncConnection, job_id: str, sha256: str) -> None:
    """Delete a file of a job for good.

    Examples
    --------
    >>> attached = await client.attach(job.id, "specimen.csv")
    >>> await client.delete_attachment(job.id, attached.sha256)
    >>> len(await client.attachments(job.id))
    0
    """
    await self._send(Call("DELETE", _path(job_id, sha256), nothing))


def _path(job_id: str, sha256: str) -> str:
    if not sha256:
        raise ValueError("sha256 is empty; give that of a file of the job")
    return f"{job_path(job_id)}/attachments/{sha256}"
