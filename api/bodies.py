"""Reads a problem document from a request body."""

from __future__ import annotations

import asyncio
from typing import Annotated, Any, Literal

from fastapi import Depends, Request

from api.errors import DetailError
from api.settings import ApiSettings
from solver.errors import ProblemError
from solver.problem import read_document

__all__ = ["BODY_MEDIA_TYPES", "ProblemDocument"]

BODY_MEDIA_TYPES: dict[str, Literal["json", "yaml"]] = {"application/json": "json", "application/yaml": "yaml"}

MAX_YAML_BYTES = 200_000
"""The YAML reader takes some 15 s of a core for a megabyte; JSON takes hundredths of a second."""


async def _problem_document(request: Request) -> dict[str, Any]:
    settings: ApiSettings = request.app.state.settings
    media_type = request.headers.get("content-type", "").partition(";")[0].strip().lower()
    form = BODY_MEDIA_TYPES.get(media_type)
    if form is None:
        accepted = " or ".join(BODY_MEDIA_TYPES)
        raise DetailError(415, f"Content-Type {media_type!r} is not understood; send the problem as {accepted}.")
    try:
        async with asyncio.timeout(settings.body_seconds):
            body = await _read(request, settings.max_body_bytes)
    except TimeoutError:
        raise DetailError(408, f"The body did not arrive within {settings.body_seconds:g} s.") from None
    if form == "yaml" and len(body) > MAX_YAML_BYTES:
        raise DetailError(
            413,
            f"YAML is read slowly, so at most {MAX_YAML_BYTES} bytes of it are accepted here; send larger problems as"
            " application/json.",
        )
    try:
        text = body.decode("utf-8")
    except UnicodeDecodeError as error:
        raise DetailError(400, f"The body is not UTF-8 text: {error.reason} at byte {error.start}.") from None
    try:
        return await asyncio.to_thread(read_document, text, form)
    except ProblemError as error:
        raise DetailError(400, str(error), kind="malformed-body", title="Malformed body", issues=error.issues) from None


async def _read(request: Request, limit: int) -> bytes:
    """Read the body, never more than ``limit`` bytes of it."""
    too_large = DetailError(413, f"The body is larger than {limit} bytes, which is the most that is accepted.")
    declared = request.headers.get("content-length", "")
    if declared.isdigit() and int(declared) > limit:
        raise too_large
    body = bytearray()
    async for chunk in request.stream():
        body += chunk
        if len(body) > limit:
            raise too_large
    return bytes(body)


ProblemDocument = Annotated[dict[str, Any], Depends(_problem_document)]
"""The problem that was sent, read but not yet judged."""
