"""A name as a part of a file name."""

from __future__ import annotations

import re

__all__ = ["slug"]

_LONGEST = 100


def slug(name: str) -> str:
    """Return the letters, digits and signs of a name that every file system takes.

    >>> slug("later stage, 40 mm")
    'later-stage-40-mm'
    """
    return re.sub(r"[^A-Za-z0-9_-]+", "-", name)[:_LONGEST].strip("-") or "unnamed"
