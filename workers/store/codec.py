"""How values are stored in the database: exact floats, no pickle, no NaN in JSON."""

from __future__ import annotations

import json
import zlib
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any

from geoswarm.solver.arrays import FloatArray, pack_array, unpack_array
from geoswarm.solver.words import visible

__all__ = [
    "clean_text",
    "pack_array",
    "pack_json",
    "pack_responses",
    "text_of_program",
    "to_datetime",
    "to_optional_datetime",
    "unpack_array",
    "unpack_json",
    "unpack_responses",
]

RAW = b"\x00"
DEFLATED = b"\x01"
WORTH_DEFLATING = 4096  # bytes; smaller ones cost more time than they save
ENCODER = json.JSONEncoder(allow_nan=False, separators=(",", ":"))


def clean_text(text: str) -> str:
    """Return text that every database takes: no NUL, no lone surrogates."""
    return text.replace("\x00", "").encode("utf-8", "replace").decode("utf-8")


def text_of_program(text: str) -> str:
    """Return what a program wrote, for the database: nothing in it steers a terminal or turns the direction of a page.

    A carriage return, behind which a progress bar is written again, ends a line.
    """
    return visible(clean_text(text).replace("\r\n", "\n").replace("\r", "\n"), lines=True)


def pack_json(value: Any) -> str:
    """Return JSON text; floats come back exactly.

    Raises
    ------
    ValueError
        When a number is NaN or infinite.
    """
    return ENCODER.encode(value)


def unpack_json(text: str) -> Any:
    """Invert :func:`pack_json`."""
    return json.loads(text)


def pack_responses(responses: Mapping[str, FloatArray]) -> bytes:
    """Return a mark, the lengths by series as one JSON line, and the float64 values, deflated when that pays."""
    header = pack_json({name: len(values) for name, values in responses.items()})
    body = header.encode() + b"\n" + b"".join(pack_array(values) for values in responses.values())
    if len(body) < WORTH_DEFLATING:
        return RAW + body
    deflated = zlib.compress(body, 1)
    return DEFLATED + deflated if len(deflated) < len(body) else RAW + body


def unpack_responses(data: bytes) -> dict[str, FloatArray]:
    """Invert :func:`pack_responses`: values of shape (m_g,) by series."""
    body = zlib.decompress(data[1:]) if data[:1] == DEFLATED else data[1:]
    header, _, values = body.partition(b"\n")
    responses: dict[str, FloatArray] = {}
    start = 0
    for name, length in json.loads(header).items():
        responses[name] = unpack_array(values[start : start + 8 * length])
        start += 8 * length
    return responses


def to_datetime(seconds: float) -> datetime:
    """Return the aware UTC time of seconds since 1970."""
    return datetime.fromtimestamp(seconds, UTC)


def to_optional_datetime(seconds: float | None) -> datetime | None:
    """Like :func:`to_datetime`, None for None."""
    return None if seconds is None else to_datetime(seconds)
