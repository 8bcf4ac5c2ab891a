"""Files of measurements, before they are part of a problem."""

from __future__ import annotations

from typing import Annotated

import anyio.to_thread
from fastapi import APIRouter, Query, Request

from geoswarm.api.access.bodies import FileContent
from geoswarm.api.dependencies import limiter, problems_of
from geoswarm.api.errors import DetailError
from geoswarm.api.schemas.drafts import MeasuredPoints, MeasuredStages, MeasurementFile
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import TableError, measured_points, measured_stages, read_measurements

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
        str | None, Query(max_length=200, description="of a workbook; the first one with numbers if absent")
    ] = None,
) -> MeasurementFile:
    """Read columns, numbers, probable units and meaning of a file. Nothing is stored."""
    try:
        slot = limiter(request, "files")
        found = await anyio.to_thread.run_sync(read_measurements, content, name, sheet, limiter=slot)
    except TableError as error:
        raise DetailError(
            422, str(error), kind="unreadable-file", title="File cannot be read", issues=error.issues()
        ) from None
    return MeasurementFile.model_validate(found)


@router.post("/points", responses=problems_of(408, 413, 422), openapi_extra={"requestBody": FILE_BODY})
async def read_points(
    content: FileContent,
    request: Request,
    observation: Annotated[
        str,
        Query(
            max_length=8000,
            description="which of the file is read, as JSON: an observation of a problem file without file and points, "
            '{"series": "settlement", "x_column": "Zeit", "y_column": "B:B", "where": {"specimen": "S2"}}',
        ),
    ],
    name: Annotated[str, Query(max_length=200, description="name of the file, for messages and notes")] = "file",
    forward_model: Annotated[
        str | None,
        Query(
            max_length=20000,
            description="the forward model, as JSON, which says when the loads of a test in stages are applied: for "
            "blocks with stage, and means that are not taken across a load",
        ),
    ] = None,
) -> MeasuredPoints:
    """Read the points of one series from a file, as a problem file would. Nothing is stored.

    A unit that neither the observation nor the file names is `unstated`: a problem with it is refused unless the
    quantity needs no unit, as a void ratio; a strain needs one.
    """
    try:
        slot = limiter(request, "files")
        points, units = await anyio.to_thread.run_sync(
            measured_points, observation, content, name, forward_model, limiter=slot
        )
    except ProblemError as error:
        raise DetailError(
            422, str(error), kind="unreadable-file", title="File cannot be read", issues=error.issues
        ) from None
    return MeasuredPoints(
        **dict.fromkeys(("weight", "readings", "independent", "range"))
        | points.document()
        | {"inputs": points.inputs}
        | units,
        gross_errors=[place + 1 for place in points.gross_errors],
        notes=list(points.notes),
    )


@router.post("/stages", responses=problems_of(408, 413, 422), openapi_extra={"requestBody": FILE_BODY})
async def read_stages(
    content: FileContent,
    request: Request,
    observation: Annotated[
        str,
        Query(
            max_length=8000,
            description='where the times are, as JSON as for points: {"x_column": "Zeit", "x_unit": "min"}',
        ),
    ],
    load_column: Annotated[str, Query(max_length=500, description="the column of the loads")],
    load_unit: Annotated[str | None, Query(max_length=100, description="where its heading names none")] = None,
    name: Annotated[str, Query(max_length=200, description="name of the file, for messages")] = "file",
) -> MeasuredStages:
    """Read the stages of a test from a column of loads, each constant over its stage. Nothing is stored."""
    try:
        slot = limiter(request, "files")
        given = observation, content, name, load_column, load_unit
        found = await anyio.to_thread.run_sync(measured_stages, *given, limiter=slot)
    except ProblemError as error:
        raise DetailError(
            422, str(error), kind="unreadable-file", title="File cannot be read", issues=error.issues
        ) from None
    return MeasuredStages.model_validate(found)
