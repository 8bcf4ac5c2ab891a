"""Writes a problem as YAML the way one would by hand: short things on one line, long lists wrapped."""

from __future__ import annotations

import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any

from geoswarm.solver.problem.issues import number

__all__ = ["problem_yaml"]

_WIDTH = 100
_PLAIN = re.compile(r"[^\W\d][\w./*+^()<>-]*(?: [\w./*+^()<>-]+)*")
_LONGEST_KEY = 1000  # YAML 1.2, 7.4.2: a key of more than 1024 characters needs a question mark
_WORDS = frozenset({"true", "false", "null", "yes", "no", "on", "off"})


def problem_yaml(document: Mapping[str, Any]) -> str:
    """Write a document of plain values (as JSON knows them) as YAML 1.2.

    Reading it again gives an equal document: numbers have all their digits.
    """
    return "".join(f"{line}\n" for line in _block(document, 0)) or "{}\n"


def _block(value: Any, depth: int) -> Iterator[str]:
    """Lines of a value that begins on a line of its own."""
    indent = "  " * depth
    if isinstance(value, Mapping):
        for key, inner in value.items():
            name = _text(str(key))
            head = f"{indent}{name}:" if len(name) <= _LONGEST_KEY else f"{indent}? {name}\n{indent}:"
            yield from _entry(head, inner, depth)
    else:
        for inner in value:
            lines = list(_entry(f"{indent}-", inner, depth))
            if isinstance(inner, Mapping) and len(lines) > 1 and lines[0] == f"{indent}-":
                lines[:2] = [f"{indent}- {lines[1].strip()}"]  # the first key beside the dash
            yield from lines


def _entry(head: str, value: Any, depth: int) -> Iterator[str]:
    flow = _flow(value, _WIDTH - len(head))
    if flow is not None:
        yield f"{head} {flow}"
    elif isinstance(value, list) and all(isinstance(item, int | float) for item in value):
        yield from _wrapped(head, value, "  " * (depth + 1))
    else:
        yield head
        yield from _block(value, depth + 1)


def _flow(value: Any, room: int) -> str | None:
    """A value on one line; None when it is too long or too deep for that."""
    if not isinstance(value, Mapping | list) or not value:
        return _scalar(value)
    if isinstance(value, Mapping):
        if any(isinstance(inner, Mapping | list) and inner for inner in value.values()):
            return None
        text = "{" + ", ".join(f"{_text(str(key))}: {_scalar(inner)}" for key, inner in value.items()) + "}"
    else:
        if len(value) > room or any(isinstance(inner, Mapping) and inner for inner in value):
            return None
        inner = [_flow(item, room) for item in value]
        if None in inner:
            return None
        text = f"[{', '.join(map(str, inner))}]"
    return text if len(text) < room else None


def _wrapped(head: str, values: list[float], indent: str) -> Iterator[str]:
    line = f"{head} ["
    last = len(values) - 1
    for index, value in enumerate(values):
        word = _scalar(value) + ("]" if index == last else ",")
        if len(line) + len(word) >= _WIDTH:
            yield line.rstrip()
            line = indent
        line += word if line.endswith("[") or line == indent else f" {word}"
    yield line


def _scalar(value: Any) -> str:
    if isinstance(value, bool) or value is None:
        return json.dumps(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return number(value) if math.isfinite(value) else f"{value:+}".replace("+nan", ".nan").replace("inf", ".inf")
    if isinstance(value, str):
        return _text(value)
    return "{}" if isinstance(value, Mapping) else "[]"


def _text(text: str) -> str:
    """Text without quotes where it cannot be taken for something else."""
    if _PLAIN.fullmatch(text) and text.lower() not in _WORDS:
        return text
    quoted = json.dumps(text, ensure_ascii=False)
    return "".join(sign if sign.isprintable() else f"\\U{ord(sign):08x}" for sign in quoted)
