"""Where in a YAML text something stands."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.problem.issues import join_path

__all__ = ["line_of", "lines_of"]


def lines_of(text: str) -> dict[str, int]:
    """Line, counted from 1, of every path (``parameters.c.lower``, ``observations[0]``) of a YAML text.

    The text has been read before, so it is known to be sound.
    """
    from ruamel.yaml import YAML

    lines: dict[str, int] = {}
    node = YAML(typ="safe", pure=True).compose(text)
    if node is not None:
        _walk(node, "", lines, 0)
    return lines


def line_of(path: str, lines: dict[str, int]) -> int | None:
    """Line of a path, or of the nearest thing around it that is there."""
    while path:
        if path in lines:
            return lines[path]
        path = path[: max(path.rfind("."), path.rfind("["), 0)]
    return None


_MOST_DEPTH = 30


def _walk(node: Any, path: str, lines: dict[str, int], depth: int) -> None:
    if depth > _MOST_DEPTH:
        return
    if node.id == "mapping":
        for key, value in node.value:
            inner = join_path(path, [str(key.value)])
            lines.setdefault(inner, key.start_mark.line + 1)
            _walk(value, inner, lines, depth + 1)
    elif node.id == "sequence":
        for index, value in enumerate(node.value):
            inner = join_path(path, [index])
            lines.setdefault(inner, value.start_mark.line + 1)
            _walk(value, inner, lines, depth + 1)
