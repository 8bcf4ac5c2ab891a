"""Where in a YAML text something stands."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.problem.issues import join_path

__all__ = ["line_of", "lines_of"]


def lines_of(text: str) -> dict[str, int]:
    """Line, counted from 1, of every path (``parameters.c.lower``, ``observations[0]``) of a YAML text.

    The text has been read before, so it is known to be sound.
    """
    from geoswarm.solver.problem.text.yaml_nodes import reader

    lines: dict[str, int] = {}
    node = reader().compose(text)
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
_LONGEST_PATH = 200  # issues shorten theirs: longer ones are not looked for


def _walk(node: Any, path: str, lines: dict[str, int], depth: int) -> None:
    if depth > _MOST_DEPTH or len(path) > _LONGEST_PATH:
        return
    if node.id == "mapping":
        for key, value in node.value:
            inner = join_path(path, [str(key.value)[:_LONGEST_PATH]])
            lines.setdefault(inner, key.start_mark.line + 1)
            _walk(value, inner, lines, depth + 1)
    elif node.id == "sequence":
        for index, value in enumerate(node.value):
            inner = join_path(path, [index])
            lines.setdefault(inner, value.start_mark.line + 1)
            _walk(value, inner, lines, depth + 1)
