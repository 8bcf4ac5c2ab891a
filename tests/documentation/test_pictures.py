"""Every picture that a page shows is written by a script of the repository, and every picture kept is shown."""

from __future__ import annotations

import re
from fnmatch import fnmatch
from pathlib import Path

import pytest

from scripts.site_hooks import FENCE, MERMAID, diagram
from tests.contracts.repository import ROOT

WRITERS = {
    "docs/pictures/*.png": ("docs/take_pictures.py", 'f"{name}.png"'),
    "docs/pictures/comparison/*.png": ("docs/take_comparison.py", "PICTURES"),
    "docs/pictures/theory/*.svg": ("docs/draw_theory.py", "FOLDER"),
    "docs/pictures/diagrams/*.svg": ("docs/draw_diagrams.py", "PICTURES"),
    "docs/tutorials/pictures/*.png": ("scripts/tutorials.py", "shutil.copyfile"),
    "docs/verification/figures/*.svg": ("docs/generate_verification.py", "write_markdown"),
    "docs/search-profile.svg": ("benchmarks/search/report.py", '"search-profile.svg"'),
}
"""Pictures by path: the script that writes them, and words of it that do."""
ENDINGS = {".png", ".svg", ".jpg", ".jpeg", ".gif", ".webp"}
FOLDERS = ("docs", "examples", "deploy")
PICTURES = sorted(
    path.relative_to(ROOT).as_posix()
    for folder in FOLDERS
    for path in (ROOT / folder).rglob("*")
    if path.suffix in ENDINGS
)


def shown() -> set[str]:
    """Return the pictures that pages show, generated pages too; a diagram in Mermaid is its picture."""
    found = set()
    pages = [*ROOT.glob("*.md"), *(path for folder in FOLDERS for path in (ROOT / folder).rglob("*.md"))]
    for path in pages:
        text = path.read_text(encoding="utf-8")
        found |= {f"docs/pictures/diagrams/{diagram(source)}" for source in MERMAID.findall(text)}
        plain = FENCE.sub("", text)
        names = re.findall(r"!\[[^\]]*\]\(([^)\s]+)\)|<img[^>]+src=\"([^\"]+)\"", plain)
        found |= {(path.parent / (one or other)).resolve().relative_to(ROOT).as_posix() for one, other in names}
    return found


def writer(picture: str) -> str | None:
    scripts = [script for pattern, (script, _) in WRITERS.items() if fnmatch(picture, pattern)]
    return scripts[-1] if scripts else None


def test_every_picture_is_shown_and_has_a_script() -> None:
    assert {picture for picture in shown() | set(PICTURES) if writer(picture) is None} == set()
    assert shown() - set(PICTURES) == set()
    assert len(PICTURES) > 60


def test_every_picture_that_is_kept_is_shown() -> None:
    assert set(PICTURES) - shown() == set()


@pytest.mark.parametrize("pattern", WRITERS)
def test_a_script_writes_what_it_is_said_to(pattern: str) -> None:
    script, words = WRITERS[pattern]
    text = (ROOT / script).read_text(encoding="utf-8")
    assert words in text
    assert [picture for picture in PICTURES if fnmatch(picture, pattern)]


def test_pictures_of_the_dashboard_are_the_ones_that_are_taken() -> None:
    taken = re.findall(r'take\(page, [^)]*?", "(\w+)"', (ROOT / "docs" / "take_pictures.py").read_text())
    assert {f"docs/pictures/{name}.png" for name in taken} == {
        picture for picture in PICTURES if Path(picture).parent.as_posix() == "docs/pictures"
    }


def test_a_picture_without_a_script_is_noticed() -> None:
    assert writer("docs/by-hand.png") is None
    assert writer("docs/tutorials/pictures/new.png") == "scripts/tutorials.py"
