"""What is wrong with a section of series, in plain words, each with its path."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from geoswarm.solver.errors import Issue
from geoswarm.solver.words import did_you_mean, visible

__all__ = ["issues_of"]

_MOST = 20
_WORDS = {
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "string_type": "text",
    "bool_type": "true or false",
    "tuple_type": "a list",
    "list_type": "a list",
    "dict_type": "a mapping",
}
_LIMITS = {"ge": "at least", "gt": "above", "le": "at most", "lt": "below"}


def issues_of(error: ValidationError, section: Any, path: str, told_by: str) -> list[Issue]:
    """Return the issues of a section: alternatives of one place together, at most 20.

    Parameters
    ----------
    section, path
        What was validated, and its path in the problem.
    told_by
        The sort of reader, in words.
    """
    places: dict[str, list[ErrorDetails]] = {}
    for detail in error.errors(include_url=False):
        places.setdefault(_path(path, detail, section), []).append(detail)
    return [Issue(place, _message(details, told_by)) for place, details in list(places.items())[:_MOST]]


def _path(path: str, detail: ErrorDetails, section: Any) -> str:
    """Path of a detail, without what pydantic calls the branches of unions."""
    value = section
    for step in detail["loc"]:
        if isinstance(value, dict) and step in value:
            value = value[step]
            path += f".{step}"
        elif isinstance(value, list | tuple) and isinstance(step, int) and step < len(value):
            value = value[step]
            path += f"[{step}]"
    return f"{path}.{detail['loc'][-1]}" if detail["type"] == "missing" else path


def _message(details: list[ErrorDetails], told_by: str) -> str:
    first = details[0]
    if first["type"] == "missing":
        return f"is missing; {told_by} needs it"
    if first["type"] == "value_error":
        return first["msg"].removeprefix("Value error, ")
    wanted = list(dict.fromkeys(words for detail in details for words in _wanted(detail)))
    if not wanted:
        return first["msg"]
    given = first["input"]
    hint = did_you_mean(given, _quoted(wanted)) if isinstance(given, str) else ""
    return f"must be {' or '.join(wanted)}, not {_given(given)}{hint}"


def _wanted(detail: ErrorDetails) -> list[str]:
    kind, context = detail["type"], detail.get("ctx", {})
    if kind in _WORDS:
        return [_WORDS[kind]]
    if kind == "literal_error":
        return [str(context["expected"])]
    for key in ("min_length", "max_length"):
        if key in context:
            unit = "characters" if kind.startswith("string") else "entries"
            return [f"{'at least' if key == 'min_length' else 'at most'} {context[key]} {unit} long"]
    return [f"{words} {context[key]}" for key, words in _LIMITS.items() if key in context]


def _quoted(wanted: Iterable[str]) -> list[str]:
    return [word for text in wanted for word in text.split("'")[1::2]]


def _given(value: Any) -> str:
    if value is None or isinstance(value, bool):
        return {None: "null", True: "true", False: "false"}[value]
    if isinstance(value, dict):
        return f"a mapping with {len(value)} keys"
    if isinstance(value, list | tuple):
        return f"a list of {len(value)}"
    return f"'{visible(value[:60])}'" if isinstance(value, str) else str(value)[:40]
