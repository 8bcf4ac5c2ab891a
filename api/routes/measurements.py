"""Files of measurements, before they are part of a problem."""

from __future__ import annotations

from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Query, Request

from geoswarm.api.access.bodies import FileContent
from geoswarm.api.dependencies import limiter, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.drafts import MeasurementFile
from geoswarm.solver.errors import Issue
from geoswarm.solver.problem import TableError, read_measurements

__all__ = ["router"]

router = APIRouter(prefix="/measurements", tags=["problems"])

FILE_BODY = {
    "required": True,
    "description": "the file as it is: CSV (comma, semicolon, tab) or a workbook (XLSX, ODS), as its content says",
    "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
}


@router.post("", responses=problems_of(408, 413, 422), openapi_extra={"requestBody": FILE_BODY})
async def read_file(
    content: FileContent,
    request: Request,
    name: Annotated[str, Query(max_length=200, description="name of the file, for messages")] = "file",
    sheet: Annotated[
        str | None, Query(max_length=200, description="of a workbook; the first one with cells if absent")
    ] = None,
) -> MeasurementFile:
    """Read columns, numbers and probable units of a file. Nothing is stored."""
    try:
        slot = limiter(request, "files")
        found = await anyio.to_thread.run_sync(read_measurements, content, name, sheet, limiter=slot)
    except TableError as error:
        issues = [Issue("", message) for message in error.messages]
        raise DetailError(422, str(error), kind="unreadable-file", title="File cannot be read", issues=issues) from None
    return MeasurementFile.model_validate(found)
