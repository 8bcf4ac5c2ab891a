"""The pages of the repository and their blocks."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

from scripts.blocks import Block, blocks
from tests.contracts.repository import ROOT

__all__ = ["PAGES", "Block", "block", "blocks_of", "inline_code", "text_of"]

FOLDERS = ("docs", "deploy", "examples")
KINDS = frozenset(
    [
        "bash",
        "console",
        "csv",
        "http",
        "indented",
        "json",
        "mermaid",
        "nginx",
        "powershell",
        "python",
        "sh",
        "text",
        "toml",
        "yaml",
    ]
)
WRITTEN = "docs/verification/"
"""Pages that a program writes; tests/geoswarm/verification compares them."""


def names() -> list[str]:
    """Return the pages, the generated ones apart; licences of others are no page of ours."""
    found = [*ROOT.glob("*.md"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.md"))]
    kept = {path.relative_to(ROOT).as_posix() for path in found} - {"THIRD-PARTY-LICENSES.md"}
    return sorted(name for name in kept if not name.startswith(WRITTEN))


PAGES = names()


@cache
def text_of(page: str) -> str:
    """Return the text of a page."""
    return (ROOT / Path(page)).read_text(encoding="utf-8")


@cache
def blocks_of(page: str) -> tuple[Block, ...]:
    """Return the blocks of a page in their order."""
    return tuple(blocks(text_of(page)))


def is_meant(key: str, one: Block) -> bool:
    """Return whether a key means a block: by its kind, or else by words that it contains."""
    return key == one.kind if key in KINDS else key in one.text


def block(page: str, key: str) -> Block:
    """Return the block of a page that contains some words."""
    (found,) = [one for one in blocks_of(page) if is_meant(key, one)]
    return found


def inline_code(page: str) -> list[str]:
    """Return what stands between single backticks in a page."""
    return re.findall(r"(?<!`)`([^`\n]+)`(?!`)", text_of(page))
