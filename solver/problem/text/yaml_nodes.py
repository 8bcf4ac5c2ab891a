"""A YAML reader that counts what aliases and merge keys repeat before anything is built of it.

Half a kilobyte of them can stand for a document that no machine holds.
"""

from __future__ import annotations

from typing import Any

from ruamel.yaml import YAML
from ruamel.yaml.composer import Composer
from ruamel.yaml.nodes import MappingNode, SequenceNode
from ruamel.yaml.scanner import Scanner

from geoswarm.solver.errors import Issue, ProblemError

__all__ = ["MAX_DEPTH", "MAX_REPEATED", "reader", "too_deep"]

MAX_REPEATED = 100_000
"""Keys and values that the aliases and merge keys of a text may repeat."""


MAX_DEPTH = 30
"""Levels of nesting that a problem may have."""


def reader() -> YAML:
    """Make a reader for one text: YAML 1.2, no tags.

    Besides errors of YAML it raises a ProblemError, before anything is built, for what is nested too deeply, contains
    itself, or repeats too much.
    """
    yaml = YAML(typ="safe", pure=True)
    yaml.Composer = _Composer
    yaml.Scanner = _Scanner
    return yaml


class _Composer(Composer):
    def get_single_node(self) -> Any:
        node = super().get_single_node()
        if node is not None:
            _refuse_repetition(node)
        return node


class _Scanner(Scanner):
    def fetch_flow_collection_start(self, TokenClass: Any, to_push: str) -> None:
        if self.flow_level > MAX_DEPTH:  # every level costs time with every token behind it
            raise too_deep("")
        super().fetch_flow_collection_start(TokenClass, to_push)


def _refuse_repetition(root: Any) -> None:
    sizes: dict[int, int | None] = {}  # nodes in a node, itself included, aliases followed; None: not known yet

    def size(node: Any) -> int:
        if id(node) in sizes:
            known = sizes[id(node)]
            if known is None:
                place = f"line {node.start_mark.line + 1}, column {node.start_mark.column + 1}"
                raise ProblemError([Issue("", f"what starts in {place} contains itself by an alias (*)")])
            return known
        sizes[id(node)] = None
        total = 1
        if isinstance(node, MappingNode):
            total += sum(size(key) + size(value) for key, value in node.value)
        elif isinstance(node, SequenceNode):
            total += sum(map(size, node.value))
        sizes[id(node)] = total
        return total

    if size(root) - len(sizes) > MAX_REPEATED:
        message = f"aliases and merge keys (*name, <<) repeat more than {MAX_REPEATED} values, the maximum"
        raise ProblemError([Issue("", f"{message}")])


def too_deep(path: str) -> ProblemError:
    """Return the error for a value at a path that is nested too deeply."""
    return ProblemError([Issue(path[:100], f"nested more than {MAX_DEPTH} levels deep")])
