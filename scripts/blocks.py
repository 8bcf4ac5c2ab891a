"""Read the blocks of a page in Markdown, and say whether an output is the one that a page tells."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterator
from dataclasses import dataclass

BLOCK = re.compile(
    r"^(?P<indent>[ ]*)```(?P<kind>\w+)(?: title=\"(?P<title>[^\"]+)\")?[^\n]*\n(?P<text>.*?)^(?P=indent)```$"
    r"|(?<=\n\n)(?P<plain>[ ]{4,}\S[^\n]*\n(?:(?:[ ]{4}[^\n]*)?\n)*)",
    re.DOTALL | re.MULTILINE,
)
INDENTED = "indented"
"""Kind of a block without fences: four blanks before each line, after an empty one."""


@dataclass(frozen=True)
class Block:
    """A block of a page, with its first line there."""

    kind: str
    title: str | None
    text: str
    line: int


def blocks(page: str) -> Iterator[Block]:
    """Yield the blocks of a page in their order."""
    for match in BLOCK.finditer(page):
        line = page.count("\n", 0, match.start()) + 1
        if match["plain"]:
            yield Block(INDENTED, None, textwrap.dedent(match["plain"]).rstrip() + "\n", line)
        else:
            yield Block(match["kind"], match["title"], textwrap.dedent(match["text"]), line)


def printed_as_told(told: str, printed: str) -> bool:
    """Return whether an output contains what a page shows of it: `...` is anything, white space does not count."""
    pattern = ".*".join(r"\s+".join(map(re.escape, part.split())) for part in told.split("..."))
    return re.search(pattern, " ".join(printed.split()), re.DOTALL) is not None
