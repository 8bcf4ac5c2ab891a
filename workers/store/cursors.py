"""Cursors: where the next page starts, as opaque text that a client returns."""

from __future__ import annotations

import base64
import binascii
import json
from typing import Any

from geoswarm.workers.errors import InvalidCursorError
from geoswarm.workers.store.codec import pack_json

__all__ = ["decode_cursor", "encode_cursor"]


def encode_cursor(*key: float | str) -> str:
    """Return the cursor of a sort key."""
    return base64.urlsafe_b64encode(pack_json(key).encode()).decode().rstrip("=")


def decode_cursor(cursor: str, *types: type) -> Any:
    """Return the sort key of a cursor, whose parts must be of these types.

    Raises
    ------
    InvalidCursorError
    """
    try:
        padded = cursor.encode("ascii") + b"=" * (-len(cursor) % 4)
        key = json.loads(base64.b64decode(padded, altchars=b"-_", validate=True))
    except (binascii.Error, ValueError):
        raise InvalidCursorError(cursor) from None
    if not isinstance(key, list) or [type(part) for part in key] != list(types):
        raise InvalidCursorError(cursor)
    if not all("\0" not in part if isinstance(part, str) else 0 <= part < 2**40 for part in key):
        raise InvalidCursorError(cursor)
    return tuple(key)
