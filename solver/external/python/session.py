"""Functions that live in this process alone: a lambda, a nested one, one of a notebook."""

from __future__ import annotations

import uuid
from collections.abc import Callable
from typing import Any

from geoswarm.solver.external.errors import RunFailedError

__all__ = ["function_of_session", "keep_function"]

_functions: dict[str, Callable[..., Any]] = {}


def keep_function(function: Callable[..., Any]) -> str:
    """Keep a function; return the word by which problems of this process find it again."""
    for word, known in _functions.items():
        if known is function:
            return word
    word = uuid.uuid4().hex
    _functions[word] = function
    return word


def function_of_session(word: str, name: str) -> Callable[..., Any]:
    """Return a function that was kept.

    Raises
    ------
    RunFailedError
        It was one of another process, or of an earlier one.
    """
    try:
        return _functions[word]
    except KeyError:
        raise RunFailedError(
            "bad_output",
            f"{name} was a function of a Python session that has ended; write it into a file (kind: python, file: "
            "model.py) to run it again",
        ) from None
