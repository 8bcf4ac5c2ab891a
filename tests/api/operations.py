"""Every operation that the service has, for tests of who may ask for what."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

__all__ = ["OPEN", "operations"]

OPEN = ("/health/", "/openapi.json", "/sign-in")
"""Everybody sees them."""


def operations(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return method and path of every operation of an OpenAPI document, with something in place of each name."""
    fill = {"{lease}": "0" * 32, "{sha256}": "0" * 64, "{job_id}": "0" * 16, "{key_id}": "0" * 12}
    return [
        (method.upper(), re.sub(r"\{\w+\}", lambda name: fill.get(name[0], "1"), path))
        for path, operations in document["paths"].items()
        for method in operations
    ]
