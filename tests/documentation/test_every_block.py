"""Every block of every page is run or checked by a test that exists, or listed with the reason why not."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

from tests.contracts.repository import ROOT
from tests.documentation.pages import PAGES, blocks_of, is_meant
from tests.documentation.where import BLOCKS

TESTS = sorted({place for page in BLOCKS.values() for place in page.values() if place.startswith("tests/")})
REASONS = sorted({place for page in BLOCKS.values() for place in page.values() if not place.startswith("tests/")})


@pytest.mark.parametrize("page", PAGES)
def test_every_block_is_run_or_listed(page: str) -> None:
    keys = {one.line: [key for key in BLOCKS.get(page, {}) if is_meant(key, one)] for one in blocks_of(page)}
    assert {f"{page}:{line}": found for line, found in keys.items() if len(found) != 1} == {}


def test_nothing_is_listed_that_is_gone() -> None:
    gone = [
        f"{page}: {key}"
        for page, keys in BLOCKS.items()
        for key in keys
        if page not in PAGES or not any(is_meant(key, one) for one in blocks_of(page))
    ]
    assert gone == []


@pytest.mark.parametrize("place", TESTS)
def test_a_test_that_is_named_exists(place: str) -> None:
    path, _, name = place.partition("::")
    tree = ast.parse((ROOT / path).read_text(encoding="utf-8"))
    assert name in {node.name for node in tree.body if isinstance(node, ast.FunctionDef)}


@pytest.mark.parametrize("reason", REASONS)
def test_a_reason_is_a_sentence_and_names_tests_that_exist(reason: str) -> None:
    assert re.match(r"[A-Z].*\.$", reason)
    assert len(reason.split()) > 5
    assert [path for path in re.findall(r"tests/[\w/]+(?:\.py)?", reason) if not Path(ROOT / path).exists()] == []
