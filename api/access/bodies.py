"""Reads a problem document from a request body."""

from __future__ import annotations

from typing import Annotated, Any

import anyio.to_thread
from fastapi import Depends, Request
from starlette.requests import ClientDisconnect

from geoswarm.api.errors import DetailError
from geoswarm.solver.errors import ProblemError
from geoswarm.solver.problem import read_document
from geoswarm.solver.problem.text.reading import Form

__all__ = ["BODY_MEDIA_TYPES", "FileContent", "ProblemDocument", "ProblemText"]

BODY_MEDIA_TYPES: dict[str, Form] = {"application/json": "json", "application/yaml": "yaml"}

MAX_YAML_BYTES = 200_000
"""The YAML reader takes some 15 s of a core for a megabyte; JSON takes hundredths of a second."""


async def _problem_text(request: Request) -> tuple[str, Form]:
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    form = BODY_MEDIA_TYPES.get(media_type)
    if form is None:
        accepted = " or ".join(BODY_MEDIA_TYPES)
        raise DetailError(415, f"Content-Type {media_type!r} is not supported; send the problem as {accepted}.")
    body = await _file_content(request)
    if form == "yaml" and len(body) > MAX_YAML_BYTES:
        raise DetailError(
            413,
            f"YAML is read slowly, so at most {MAX_YAML_BYTES} bytes of it are accepted here; send larger problems as"
            " application/json.",
        )
    try:
        return body.decode("utf-8"), form
    except UnicodeDecodeError as error:
        raise DetailError(400, f"The body is not UTF-8 text: {error.reason} at byte {error.start}.") from None


async def _problem_document(given: Annotated[tuple[str, Form], Depends(_problem_text)]) -> dict[str, Any]:
    text, form = given
    try:
        return await anyio.to_thread.run_sync(read_document, text, form)
    except ProblemError as error:
        raise DetailError(400, str(error), kind="malformed-body", title="Malformed body", issues=error.issues) from None


async def _file_content(request: Request) -> bytes:
    try:
        return await request.body()  # limited and complete: see geoswarm.api.access.intake
    except ClientDisconnect:  # the client has left: no fault of the service
        raise DetailError(400, "The connection was closed before the request had arrived.") from None


ProblemDocument = Annotated[dict[str, Any], Depends(_problem_document)]
"""The problem that was sent, read but not yet judged."""

ProblemText = Annotated[tuple[str, Form], Depends(_problem_text)]
"""The text of a problem that was sent, and what it is written in."""

FileContent = Annotated[bytes, Depends(_file_content)]
"""A body of any type."""
