# Generated from geoswarm/client/_async/attached.py by scripts/generate_client.py; `make format` renews it.
"""Files that are attached to a job: a photo of the specimen, the laboratory's PDF."""

from __future__ import annotations

from pathlib import Path

from geoswarm.client._sync.connection import Connection
from geoswarm.client.calls import FILE_BODY, Call, job_path, nothing, reader
from geoswarm.client.files import partial_file
from geoswarm.records.job import Attachment

__all__ = ["attach", "attachments", "delete_attachment", "download_attachment"]


def attachments(self: Connection, job_id: str) -> tuple[Attachment, ...]:
    """List the files that are attached to a job, oldest first.

    Examples
    --------
    >>> attached = client.attach(job.id, "specimen.csv")
    >>> [file.name for file in client.attachments(job.id)]
    ['specimen.csv']
    """
    read = reader(tuple[Attachment, ...], "items")
    return self._send(Call("GET", f"{job_path(job_id)}/attachments", read))


def attach(self: Connection, job_id: str, path: str | Path, name: str | None = None) -> Attachment:
    """Attach a file to a job: an image (PNG, JPEG, WebP), PDF, text, CSV, AGS, or a workbook (XLSX, ODS).

    A content that the job has already is not attached again.

    Parameters
    ----------
    name
        What it is called in the job; that of the file when not given.

    Examples
    --------
    >>> attached = client.attach(job.id, "specimen.csv")
    >>> attached.name, attached.media_type, attached.size
    ('specimen.csv', 'text/csv', 16)
    """
    path = Path(path)
    content = path.read_bytes()
    query = {"name": name or path.name}
    call = Call("POST", f"{job_path(job_id)}/attachments", reader(Attachment), query, FILE_BODY, content)
    return self._send(call)


def download_attachment(self: Connection, job_id: str, sha256: str, path: str | Path) -> Path:
    """Save a file that is attached to a job; the file appears only when it is complete.

    Examples
    --------
    >>> attached = client.attach(job.id, "specimen.csv")
    >>> saved = client.download_attachment(job.id, attached.sha256, "copy.csv")
    >>> saved.read_text()
    'height [mm];20.2'
    """
    target = Path(path)
    with partial_file(target) as file:
        self._download(Call("GET", _path(job_id, sha256), nothing), file)
    return target


def delete_attachment(self: Connection, job_id: str, sha256: str) -> None:
    """Delete a file of a job for good.

    Examples
    --------
    >>> attached = client.attach(job.id, "specimen.csv")
    >>> client.delete_attachment(job.id, attached.sha256)
    >>> len(client.attachments(job.id))
    0
    """
    self._send(Call("DELETE", _path(job_id, sha256), nothing))


def _path(job_id: str, sha256: str) -> str:
    if not sha256:
        raise ValueError("sha256 is empty; give that of a file of the job")
    return f"{job_path(job_id)}/attachments/{sha256}"
