"""Places in a JSON document: ``results.time``, ``results[*].uy``, ``steps[-1]["total force"]``."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, TypeAlias

__all__ = ["JsonPath", "parse_json_path"]

_STEP = re.compile(r"""\.?(?P<name>[^.\[\]"'\s]+)|\[(?:(?P<index>-?\d+)|(?P<all>\*)|"(?P<quoted>[^"]*)")\]""", re.ASCII)

_Step: TypeAlias = str | int | None  # None: every entry of a list


@dataclass(frozen=True, slots=True)
class JsonPath:
    """A path that was read; ``text`` as written."""

    text: str
    steps: tuple[_Step, ...]

    def numbers(self, document: Any) -> list[tuple[str, float]]:
        """Return what the path leads to, each with its own path: a number, or all numbers of a list.

        Raises
        ------
        ValueError
            A step does not exist, or something else than numbers stands there; the message says what.
        """
        found = []
        for where, value in _follow(document, self.steps, ""):
            entries = [(f"{where}[{at}]", one) for at, one in enumerate(value)] if isinstance(value, list) else None
            for name, one in entries or [(where, value)]:
                if isinstance(one, bool) or not isinstance(one, int | float):
                    raise ValueError(f"{name} is {_what(one)}; a number is expected")
                found.append((name, _float(name, one)))
        return found


def parse_json_path(text: str) -> JsonPath:
    """Read a path: names with ``.`` between them, ``[2]`` or ``[-1]`` for an entry, ``[*]`` for each, ``["a b"]``.

    Raises
    ------
    ValueError
        It is none; the message says where.
    """
    steps: list[_Step] = []
    position = 0
    while position < len(text):
        found = _STEP.match(text, position)
        if found is None or (found["name"] and (not position) == text.startswith(".", position)):
            raise ValueError(f"'{text}' is not a path at character {position + 1}; write for example results[*].uy")
        steps.append(_step(found))
        position = found.end()
    if not steps:
        raise ValueError("path is empty; write for example results.time")
    return JsonPath(text, tuple(steps))


def _step(found: re.Match[str]) -> _Step:
    if found["all"]:
        return None
    if found["index"]:
        return int(found["index"])
    return found["name"] or found["quoted"]


def _follow(value: Any, steps: tuple[_Step, ...], where: str) -> Iterator[tuple[str, Any]]:
    if not steps:
        yield where or "the document", value
        return
    step, rest = steps[0], steps[1:]
    here = where or "the document"
    if isinstance(step, str):
        if not isinstance(value, dict):
            raise ValueError(f"{here} is {_what(value)}; a mapping with the key {step} is expected")
        if step not in value:
            keys = ", ".join(list(value)[:20]) or "none"
            raise ValueError(f"{here} has no key {step}; its keys: {keys}")
        yield from _follow(value[step], rest, f"{where}.{step}" if where else step)
        return
    if not isinstance(value, list):
        raise ValueError(f"{here} is {_what(value)}; a list is expected")
    if step is None:
        for at, one in enumerate(value):
            yield from _follow(one, rest, f"{where}[{at}]")
        return
    if not -len(value) <= step < len(value):
        raise ValueError(f"{here} has {len(value)} entries; [{step}] does not exist")
    yield from _follow(value[step], rest, f"{where}[{step}]")


def _float(name: str, value: float) -> float:
    try:
        return float(value)
    except OverflowError:
        raise ValueError(f"{name} is larger than any number that can be calculated with") from None


def _what(value: Any) -> str:
    if value is None:
        return "null"
    if isinstance(value, dict):
        return f"a mapping with the keys {', '.join(list(value)[:10])}" if value else "an empty mapping"
    if isinstance(value, list):
        return f"a list of {len(value)}"
    return f"the text '{value[:40]}'" if isinstance(value, str) else str(value).lower()[:40]
