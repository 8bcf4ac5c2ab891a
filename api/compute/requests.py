"""Which requests calculate: they read problems and tables, build models, run them, or look at whole histories."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

__all__ = ["is_compute", "job_of"]

_ALWAYS = re.compile(
    r"/api/v1/(?:"
    r"problems/(?:check|warm-starts|read|tests)|measurements(?:/(?:points|ags(?:/problem)?))?|forward-models(?:/[^/]+)?"
    r"|jobs/[^/]+/(?:fit|diagrams|points|statistics|reweight|report\.(?:html|pdf)|figures(?:/[^/]+)?|sensitivity|profile"
    r"|jackknife|explore|predict|design|follow-ups|global-sensitivity|uncertainty|posterior|mesh(?:/fields)?)"
    r")"
)
_CHANGES = {"POST": re.compile(r"/api/v1/jobs"), "PATCH": re.compile(r"/api/v1/jobs/[^/]+")}
_JOB = re.compile(r"/api/v1/jobs/([^/]+)")


def is_compute(scope: Mapping[str, Any]) -> bool:
    """Whether a request of an ASGI scope calculates.

    >>> is_compute({"type": "http", "method": "GET", "path": "/api/v1/jobs/1f/statistics"})
    True
    >>> is_compute({"type": "http", "method": "GET", "path": "/api/v1/jobs"})
    False
    """
    if scope["type"] != "http":
        return False
    changing = _CHANGES.get(scope["method"])
    return _ALWAYS.fullmatch(scope["path"]) is not None or (
        changing is not None and changing.fullmatch(scope["path"]) is not None
    )


def job_of(path: str) -> str | None:
    """The job that a request is about."""
    found = _JOB.match(path)
    return None if found is None else found[1]
