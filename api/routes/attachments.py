"""Files that people attach to a job: list, attach, download, delete."""

from __future__ import annotations

import io
from typing import Annotated, Any
from urllib.parse import quote

from fastapi import APIRouter, Depends, Path, Query, Request, Response
from fastapi.responses import StreamingResponse

from geoswarm.api.dependencies import JobId, Service, problems_of
from geoswarm.api.headers import ATTACHMENT_POLICY
from geoswarm.api.schemas.responses import AttachmentList
from geoswarm.records.job import Attachment
from geoswarm.workers.service.attachments import Attachments

__all__ = ["router"]

router = APIRouter(prefix="/jobs/{job_id}/attachments", tags=["jobs"])

FILE_BODY = {
    "required": True,
    "description": "the file as it is; its type is decided by its content: PNG, JPEG, WebP, PDF, XLSX, ODS, or text "
    "(CSV, TSV, AGS, TXT, MD, LOG, DAT, ASC by the name)",
    "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
}
CONTENT: dict[int | str, dict[str, Any]] = {
    200: {"content": {"application/octet-stream": {}}, "description": "The file"}
}


async def _attachments(service: Service) -> Attachments:
    return service.attachments


Own = Annotated[Attachments, Depends(_attachments)]
Sha256 = Annotated[str, Path(description="SHA-256 of the content")]


@router.get("", responses=problems_of(404))
def attachments(job_id: JobId, own: Own) -> AttachmentList:
    """List the files that are attached to a job, oldest first."""
    return AttachmentList(items=own.list(job_id))


@router.post(
    "",
    status_code=201,
    responses={
        200: {"model": Attachment, "description": "The same content is attached already"},
        **problems_of(404, 408, 413, 422),
    },
    openapi_extra={"requestBody": FILE_BODY},
)
def attach(
    job_id: JobId,
    own: Own,
    request: Request,
    response: Response,
    name: Annotated[str, Query(max_length=1000, description="name of the file, of at most 200 bytes")],
) -> Attachment:
    """Attach a file to a job, at any time. A content that the job has already is not attached again."""
    found, new = own.add(job_id, name, getattr(request.state, "body", None) or io.BytesIO())
    response.status_code = 201 if new else 200
    path = request.app.url_path_for("attachment", job_id=job_id, sha256=found.sha256)
    response.headers["Location"] = str(path)
    return found


@router.get(
    "/{sha256}",
    response_class=StreamingResponse,
    responses={**CONTENT, 304: {"description": "It is the one of If-None-Match"}, **problems_of(404)},
)
def attachment(job_id: JobId, sha256: Sha256, own: Own, request: Request) -> Response:
    """Download a file. Images may be shown by a browser, everything else is saved."""
    found = own.get(job_id, sha256)
    headers = _headers(found)
    if headers["ETag"] in request.headers.get("if-none-match", ""):
        del headers["Content-Length"]
        return Response(status_code=304, headers=headers)  # the browser takes its policy for that of the file
    return StreamingResponse(own.content(job_id, sha256), headers=headers)


@router.head("/{sha256}", include_in_schema=False)
def attachment_head(job_id: JobId, sha256: Sha256, own: Own) -> Response:
    """The headers of a download."""
    return Response(headers=_headers(own.get(job_id, sha256)))


@router.delete("/{sha256}", status_code=204, response_class=Response, responses=problems_of(404))
def delete_attachment(job_id: JobId, sha256: Sha256, own: Own) -> None:
    """Delete a file of a job for good."""
    own.delete(job_id, sha256)


def _headers(found: Attachment) -> dict[str, str]:
    """Headers under which nothing in a file can act as a page of this service."""
    disposition = "inline" if found.media_type.startswith("image/") else "attachment"
    return {
        "Content-Type": found.media_type,
        "Content-Length": str(found.size),
        "Content-Disposition": f"{disposition}; filename*=UTF-8''{quote(found.name, safe='')}",
        "Content-Security-Policy": ATTACHMENT_POLICY,
        "Cross-Origin-Resource-Policy": "same-origin",
        "Cache-Control": "private, no-cache",  # kept by a browser, which asks each time whether it may still see it
        "ETag": f'"{found.sha256}"',
    }
