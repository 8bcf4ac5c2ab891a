"""Turns what pydantic finds wrong into issues in plain words, each with its path in the problem file."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, partial
from itertools import islice
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from geoswarm.solver.errors import Issue
from geoswarm.solver.forward.registry import find_spec
from geoswarm.solver.sentences import SentenceError
from geoswarm.solver.words import did_you_mean

__all__ = ["describe", "issues_of", "join_path", "number", "validated"]

Model = TypeVar("Model", bound=BaseModel)

_MOST_ISSUES = 20
_ABSENT = ("missing", "forward_model")  # errors whose place may be a key that is not there
_TYPES = {
    "float_type": "a number",
    "float_parsing": "a number",
    "int_type": "a whole number",
    "int_parsing": "a whole number",
    "int_from_float": "a whole number",
    "string_type": "text",
    "bool_type": "true or false",
    "bool_parsing": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a mapping",
    "model_type": "a mapping",
    "model_attributes_type": "a mapping",
    "none_required": "null",
}
_MAPPINGS = ("dict_type", "model_type", "model_attributes_type")
_TAGS = ("union_tag_invalid", "union_tag_not_found")
_MOST_KEYS = 8


def validated(model: type[Model], section: Any, path: str) -> tuple[Model | None, list[Issue]]:
    """Validate one section of a document strictly (no text or truth value as a number).

    Returns
    -------
    The model, or None with the issues.
    """
    try:
        # Through JSON because strict validation of Python objects would refuse a list where a tuple is meant.
        return model.model_validate_json(json.dumps(section), strict=True), []
    except ValidationError as error:
        return None, issues_of(error, section, path, model.model_json_schema)


def issues_of(error: ValidationError, section: Any, path: str, schema: Callable[[], dict[str, Any]]) -> list[Issue]:
    """Issues of a validation error, each once, at most 20 of them.

    Parameters
    ----------
    error, section, path
        What pydantic found, in which data, and where these are in the problem file.
    schema
        Function that gives the JSON schema of the section; called only to list the known keys.
    """
    found: dict[Issue, None] = {}
    schema = cache(schema)
    details = error.errors(include_url=False)
    details = [one for one in details if one["type"] != "too_short" or not _has_mistakes_inside(one, details)]
    for place, detail in enumerate(details):
        if len(found) == _MOST_ISSUES:
            return [*found, Issue(path, f"{len(details) - place} more mistakes like these")]
        steps = _steps(detail, section)
        around = steps if detail["type"] in _MAPPINGS or detail["type"] in _TAGS else steps[:-1]
        refused = detail.get("ctx", {}).get("error")
        if isinstance(refused, SentenceError):
            of_section = isinstance(detail["input"], Mapping)  # else of a field, the keys are beside it
            within = join_path(path, steps if of_section else steps[:-1])
            issue = Issue.about(join_path(path, steps), refused.sentence, f"{within}." if within else "")
        else:
            issue = Issue(join_path(path, steps), _message(detail, partial(_places_at, schema, section, around)))
        found[issue] = None
    return list(found)


def join_path(path: str, steps: Iterable[str | int]) -> str:
    """Path in the notation of issues: ``observations[0].points.y[3]``."""
    for step in steps:
        path += f"[{step}]" if isinstance(step, int) else f".{step}" if path else step
    return path


def number(value: float) -> str:
    """A number with all its digits, as a user would write it: 3, not 3.0."""
    return repr(value).removesuffix(".0")[:40]


def describe(value: Any) -> str:
    """A value as written in the file, shortened."""
    match value:
        case None:
            return "null"
        case bool():
            return "true" if value else "false"
        case float() if not math.isfinite(value):
            return str(value)
        case int() | float():
            return number(value)
        case str():
            return f"text '{value[:60]}{'...' if len(value) > 60 else ''}'"
        case Mapping():
            keys = ", ".join(str(key)[:60] for key in islice(value, 10))
            return f"a mapping with the keys {keys}" if value else "an empty mapping"
        case Sequence():
            return f"a list of {len(value)}" if value else "an empty list"
        case _:
            return type(value).__name__


def _steps(detail: ErrorDetails, section: Any) -> list[str | int]:
    """Steps of a location that are in the data; pydantic puts tags of unions between them."""
    steps: list[str | int] = []
    value, there = section, True
    for step in detail["loc"]:
        there = (isinstance(value, Mapping) and step in value) or (
            isinstance(value, list) and isinstance(step, int) and step < len(value)
        )
        if there:
            value = value[step]
            steps.append(step)
    if not there and detail["type"] in _ABSENT:
        steps.append(detail["loc"][-1])
    return steps


def _has_mistakes_inside(detail: ErrorDetails, details: Sequence[ErrorDetails]) -> bool:
    """Whether a list is too short for pydantic only because it left out entries that have mistakes."""
    place = detail["loc"]
    return any(len(one["loc"]) > len(place) and one["loc"][: len(place)] == place for one in details)


def _message(detail: ErrorDetails, places: Callable[[], _Places]) -> str:
    kind, value, context = detail["type"], detail["input"], detail.get("ctx", {})
    given = describe(value)
    if kind == "extra_forbidden":
        keys = places().keys()
        hint = did_you_mean(str(detail["loc"][-1]), keys)
        return f"unknown key{hint}{_listed('; accepted: ', keys)}"
    if kind == "missing":
        return "is missing"
    if kind in _TYPES:
        hint = "; write it without quotes" if isinstance(value, str) and _is_number(value) else ""
        keys = places().keys() if kind in _MAPPINGS else []
        known = _listed(" with keys such as " if keys[_MOST_KEYS:] else " with the keys ", keys[:_MOST_KEYS])
        return f"must be {_TYPES[kind]}{known}, got {given}{hint}"
    if kind == "finite_number":
        return f"must be a finite number, got {given}"
    if kind in ("literal_error", "enum"):
        hint = did_you_mean(value, _quoted(context["expected"])) if isinstance(value, str) else ""
        return f"must be {context['expected']}, got {given}{hint}"
    if kind in _TAGS:
        key = str(context["discriminator"]).strip("'")
        tag = value.get(key) if isinstance(value, Mapping) else None
        found = "is missing" if tag is None else f"is {describe(tag)}"
        tags = places().constants(key)
        return f"{key} {found}{did_you_mean(str(tag), tags)}{_listed('; accepted: ', tags)}"
    for limit, words in (("gt", "above"), ("ge", "at least"), ("lt", "below"), ("le", "at most")):
        if kind in ("greater_than", "greater_than_equal", "less_than", "less_than_equal") and limit in context:
            return f"must be {words} {number(context[limit])}, got {given}"
    if kind in ("too_short", "string_too_short"):
        unit = "characters" if kind.startswith("string") else "entries"
        return "must not be empty" if context["min_length"] == 1 else f"needs at least {context['min_length']} {unit}"
    if kind in ("too_long", "string_too_long"):
        unit = "characters" if kind.startswith("string") else "entries"
        return f"may have at most {context['max_length']} {unit}"
    if kind == "string_pattern_mismatch":
        return f"{given} must match {context['pattern']}"
    if kind == "value_error":
        return str(context.get("error", detail["msg"]))
    return str(detail["msg"])


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True


def _quoted(expected: str) -> list[str]:
    return expected.split("'")[1::2]


def _listed(before: str, names: Iterable[str]) -> str:
    listed = ", ".join(names)
    return f"{before}{listed}" if listed else ""


def _places_at(schema: Callable[[], dict[str, Any]], value: Any, steps: Iterable[str | int]) -> _Places:
    """What the schema knows of a place in the data."""
    places = _Places(schema(), value)
    for step in steps:
        value = value[step]
        places = places.step(step, value)
        if places.is_forward_model and isinstance(value, Mapping):
            # A part of a combined model: what it may hold depends on its kind.
            places = _Places(find_spec(str(value.get("kind"))).model_json_schema(), value)
    return places


class _Places:
    """All schemas that may apply to a value at one place in the data, with the document of their definitions."""

    def __init__(self, root: Mapping[str, Any], value: Any, nodes: Sequence[Mapping[str, Any]] | None = None) -> None:
        self._root, self._value = root, value
        self._nodes = [branch for node in nodes or [root] for branch in self._branches(node)]

    def _branches(self, node: Mapping[str, Any]) -> list[Mapping[str, Any]]:
        if "$ref" in node:
            return self._branches(self._root["$defs"][node["$ref"].rsplit("/", 1)[-1]])
        inner = [*node.get("anyOf", ()), *node.get("oneOf", ()), *node.get("allOf", ())]
        return [node, *(branch for part in inner for branch in self._branches(part))]

    @property
    def is_forward_model(self) -> bool:
        return any(node.get("x-forward-model") for node in self._nodes)

    def step(self, step: str | int, value: Any) -> _Places:
        """What applies to a value inside."""
        chosen = [node for node in self._nodes if _fits(node, self._value)]
        below = []
        for node in chosen:
            if isinstance(step, int):
                prefix = node.get("prefixItems", [])
                below.append(prefix[step] if step < len(prefix) else node.get("items"))
            else:
                named = node.get("properties", {}).get(step, node.get("additionalProperties"))
                below += [named, *node.get("patternProperties", {}).values()]
        nodes = [node for node in below if isinstance(node, Mapping)]
        return _Places(self._root, value, nodes or [{}])

    def keys(self) -> list[str]:
        """Keys that are known there."""
        chosen = [node for node in self._nodes if _fits(node, self._value)]
        return list(dict.fromkeys(key for node in chosen for key in node.get("properties", {})))

    def constants(self, key: str) -> list[str]:
        """Values of a key that tells several kinds of mapping apart."""
        rules = [node.get("properties", {}).get(key, {}) for node in self._nodes]
        return list(dict.fromkeys(str(rule["const"]) for rule in rules if "const" in rule))


def _fits(node: Mapping[str, Any], value: Any) -> bool:
    if not isinstance(value, Mapping):
        return True
    constants = ((key, rule["const"]) for key, rule in node.get("properties", {}).items() if "const" in rule)
    return all(key not in value or value[key] == constant for key, constant in constants)
