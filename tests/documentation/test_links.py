"""Links lead to files and headings, on every page as it stands in the repository.

The strict build of the site (tests/contracts) checks them once more for what is on it.
"""

from __future__ import annotations

import re
import unicodedata
from functools import cache
from pathlib import Path

import pytest

from scripts.site_hooks import FENCE
from tests.contracts.repository import ROOT
from tests.documentation.pages import PAGES, text_of

LINK = re.compile(r"\]\(<?([^)\s>]+)>?(?: \"[^\"]*\")?\)")
CODE = re.compile(r"`[^`\n]*`")


def without_code(page: str) -> str:
    return CODE.sub("", FENCE.sub("", text_of(page)))


@cache
def anchors(path: Path) -> frozenset[str]:
    """Names of the headings of a page, as MkDocs and GitHub make them."""
    names = set()
    text = path.read_text(encoding="utf-8")
    for heading in re.findall(r"^#{1,6} (.*)$", FENCE.sub("", text), re.MULTILINE):
        plain = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("`", "").strip().lower()
        ours = re.sub(r"[^\w\s-]", "", unicodedata.normalize("NFKD", plain).encode("ascii", "ignore").decode())
        names |= {re.sub(r"[-\s]+", "-", ours.strip()), re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", plain))}
    return frozenset(names)


def broken(page: str, link: str) -> bool:
    """Return whether a link of a page leads to nothing."""
    name, _, anchor = link.partition("#")
    target = (ROOT / page).parent / name if name else ROOT / page
    if not target.exists():
        return True
    if target.is_dir():
        target = target / "README.md"
    return bool(anchor) and target.suffix == ".md" and anchor not in anchors(target)


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page: str) -> None:
    links = [link for link in LINK.findall(without_code(page)) if not re.match(r"[a-z]+:", link)]
    assert [link for link in links if broken(page, link)] == []


@pytest.mark.parametrize("page", PAGES)
def test_links_by_reference_are_defined(page: str) -> None:
    text = without_code(page)
    defined = set(re.findall(r"^\[([^\]]+)\]: ", text, re.MULTILINE))
    assert set(re.findall(r"\]\[([^\]]+)\]", text)) <= defined


def test_a_dead_link_is_noticed() -> None:
    assert not broken("README.md", "docs/statistics.md#whether-the-model-describes-the-data")
    assert broken("README.md", "docs/statistics.md#no-such-heading")
    assert broken("README.md", "docs/no-such-page.md")
    assert broken("docs/agents.md", "#no-such-heading")
