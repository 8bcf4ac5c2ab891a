"""How deeply a problem may be nested, in YAML and in JSON."""

from __future__ import annotations

from geoswarm.solver.errors import Issue, ProblemError

__all__ = ["MAX_DEPTH", "too_deep"]

MAX_DEPTH = 30
"""Levels of nesting that a problem may have."""


def too_deep(path: str) -> ProblemError:
    """Return the error for a value at a path that is nested too deeply."""
    return ProblemError([Issue(path[:100], f"nested more than {MAX_DEPTH} levels deep")])
