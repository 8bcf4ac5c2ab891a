"""The tutorials do what they say: every block is run as a reader would, and every picture is made and kept."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from scripts.blocks import Block, blocks, printed_as_told
from scripts.reader import ReaderError, left_over
from scripts.tutorials import PAGES, PICTURE, follow

NAMES = sorted(path.stem for path in PAGES.glob("*.md") if path.stem != "README")
QUICK = ["python-function"]
"""Runs by default: 10 seconds of processor time."""


@pytest.mark.slow
@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", [name for name in NAMES if name not in QUICK])
def test_a_tutorial_runs_from_its_first_line_to_its_last(name: str, tmp_path: Path) -> None:
    assert follow(PAGES / f"{name}.md", tmp_path) > 2


@pytest.mark.timeout(900)
@pytest.mark.parametrize("name", QUICK)
def test_the_quick_ones_run(name: str, tmp_path: Path) -> None:
    assert follow(PAGES / f"{name}.md", tmp_path) > 2


@pytest.mark.parametrize("name", NAMES)
def test_pictures_are_kept_and_shown_once(name: str) -> None:
    page = (PAGES / f"{name}.md").read_text(encoding="utf-8")
    shown = re.findall(r"!\[[^\]]+\]\(([^)]+)\)", page)
    assert shown
    assert sorted(shown) == sorted(match["target"] for match in PICTURE.finditer(page))
    assert all((PAGES / target).is_file() for target in shown)


def test_every_tutorial_is_listed_and_every_picture_is_shown() -> None:
    listed = re.findall(r"\]\(([\w-]+)\.md\)", (PAGES / "README.md").read_text(encoding="utf-8"))
    assert sorted(listed) == NAMES
    pages = "".join((PAGES / f"{name}.md").read_text(encoding="utf-8") for name in NAMES)
    assert {path.name for path in (PAGES / "pictures").iterdir()} == set(re.findall(r"\(pictures/([^)]+)\)", pages))


def test_blocks_are_told_apart() -> None:
    page = 'text\n\n```yaml title="a.yaml"\nx: 1\n```\n\n```bash\nls\n```\n\n```text\na.yaml\n```\n'
    page += "\n    make\n\n    all\n\n1. so:\n   ```sh\n   ls\n   ```\n"
    assert list(blocks(page)) == [
        Block("yaml", "a.yaml", "x: 1\n", 3),
        Block("bash", None, "ls\n", 7),
        Block("text", None, "a.yaml\n", 11),
        Block("indented", None, "make\n\nall\n", 15),
        Block("sh", None, "ls\n", 20),
    ]


@pytest.mark.parametrize(
    ("told", "printed", "same"),
    [
        ("a  1\nb", "before a 1\n b after", True),
        ("a ... c", "a\nb\nc", True),
        ("a ... c", "c then a", False),
        ("(1.5)", "(105)", False),
    ],
)
def test_what_is_told_is_looked_for_in_what_is_printed(told: str, printed: str, *, same: bool) -> None:
    assert printed_as_told(told, printed) is same


def test_what_a_page_leaves_running_is_ended(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```bash\nsleep 300 > log 2>&1 &\necho $!\n```\n\n```bash\nfalse\n```\n")
    folder = tmp_path / "reader"
    folder.mkdir()
    with pytest.raises(ReaderError):
        follow(page, folder)
    assert left_over(folder) == []


def test_a_page_that_tells_something_else_is_refused_with_its_line(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text("```bash\necho 1\n```\n\n```text\n2\n```\n")
    folder = tmp_path / "reader"
    folder.mkdir()
    with pytest.raises(ReaderError, match=r"page\.md, line 5"):
        follow(page, folder)
    page.write_text("```bash\nfalse\n```\n")
    other = tmp_path / "other"
    other.mkdir()
    with pytest.raises(ReaderError, match=r"page\.md, line 1: ended with 1"):
        follow(page, other)
