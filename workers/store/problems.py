"""The problems of stored jobs: their documents, and the problems themselves, each parsed once a process."""

from __future__ import annotations

import hashlib
import json
import threading
from dataclasses import replace
from typing import Any

from cachetools import LRUCache

from geoswarm.solver.forward.registry import BUILT_IN
from geoswarm.solver.problem import Problem, parse_problem

__all__ = ["problem_of", "unpack_problem"]

KEPT_LETTERS = 2**25
"""Of all documents whose problems are kept."""

_kept: LRUCache[bytes, tuple[Problem, int]] = LRUCache(KEPT_LETTERS, getsizeof=lambda kept: kept[1])
_lock = threading.Lock()


def unpack_problem(text: str, stopping: str | None = None, name: str | None = None) -> dict[str, Any]:
    """Return a stored problem document with what earlier versions did not write: their swarms were not accelerated.

    ``stopping`` replaces its stop criteria, where they were changed since, and ``name`` its name: that of its job.
    """
    document: dict[str, Any] = json.loads(text)
    if name is not None:
        document["name"] = name
    if stopping is not None:
        document["stopping"] = json.loads(stopping)
    method = document.get("method")
    if isinstance(method, dict) and method.get("kind") == "particle_swarm":
        method.setdefault("acceleration", "none")
    return document


def problem_of(text: str, stopping: str | None = None, name: str | None = None) -> Problem:
    """Return the problem of a stored document; the last ones are kept, unless packages or files define them.

    Parameters
    ----------
    text, stopping, name
        As in :func:`unpack_problem`.

    Raises
    ------
    ProblemError
        When this version cannot read it any more.
    """
    problem = _parsed(text, stopping)
    return problem if name is None or name == problem.name else replace(problem, name=name)


def _parsed(text: str, stopping: str | None) -> Problem:
    key = hashlib.sha256(f"{text}\n{stopping}".encode()).digest()
    with _lock:
        if key in _kept:
            return _kept[key][0]
    problem = parse_problem(unpack_problem(text, stopping))
    lasting = {part.kind for part in problem.forward_model.by_part().values()} <= BUILT_IN.keys() - {"registered"}
    if lasting and len(text) <= KEPT_LETTERS:
        with _lock:
            _kept[key] = problem, len(text)
    return problem
