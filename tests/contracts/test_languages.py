"""Catalogues of the dashboard's languages: each phrase takes what its English text inserts."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CATALOGUES = sorted((ROOT / "api" / "static" / "languages").glob("*.json"))
PLACE = re.compile(r"\{(\d*)\}")
NAMED = re.compile(r"(?<!\{)\{[a-z_]+(?:[.:!][^{} ]*)?\}(?!\})|\{:[^}]*\}")
"""A place as a program names it; `{E: kPa}` and `{{E}}` are what people write in a problem file."""

SOURCES = {"api": "py js html", "solver": "py yaml json toml", "workers": "py", "geoswarm/examples": "py yaml"}
"""Where the texts of the pages come from."""
WORD = re.compile(r"[^\W\d_]+")
ELSEWHERE = {"autoscale", "pan", "lev", "pres"}
"""Words of Plotly's buttons, and of the groups of AGS in the tests' files."""


@pytest.fixture(scope="module")
def source_words() -> set[str]:
    found: set[str] = set()
    for folder, endings in SOURCES.items():
        for path in (ROOT / folder).rglob("*"):
            if path.suffix[1:] in endings.split() and "languages" not in path.parts:
                found.update(WORD.findall(path.read_text(encoding="utf-8").lower().replace("\\n", " ")))
    return found


def phrases(path: Path) -> dict[str, str]:
    found: dict[str, str] = json.loads(path.read_text())["phrases"]
    return found


@pytest.mark.parametrize("path", CATALOGUES, ids=lambda path: path.stem)
def test_a_catalogue_says_its_name_and_its_decimal_point(path: Path) -> None:
    catalogue = json.loads(path.read_text())
    assert set(catalogue) == {"name", "decimal", "phrases"}
    assert re.fullmatch("[a-z]{2}", path.stem)
    assert catalogue["decimal"] in (".", ",")


@pytest.mark.parametrize("path", CATALOGUES, ids=lambda path: path.stem)
def test_a_phrase_has_the_places_of_its_english_text(path: Path) -> None:
    wrong = []
    for english, phrase in phrases(path).items():
        numbers = PLACE.findall(phrase)
        count = len(PLACE.findall(english))
        if ("".join(numbers) and sorted(numbers) != [str(i + 1) for i in range(count)]) or len(numbers) != count:
            wrong.append((english, phrase))
    assert wrong == []


@pytest.mark.parametrize("path", CATALOGUES, ids=lambda path: path.stem)
def test_places_have_no_names(path: Path) -> None:
    """A text of a page has something in the place, not its name: such a phrase would never be found."""
    assert [text for text in phrases(path) if NAMED.search(text)] == []


@pytest.mark.parametrize("path", CATALOGUES, ids=lambda path: path.stem)
def test_phrases_are_sorted_and_as_the_page_looks_them_up(path: Path) -> None:
    texts = list(phrases(path))
    assert texts == sorted(texts)
    assert [text for text in texts if text != re.sub(r"\s+", " ", text).strip()] == []
    assert [text for text, phrase in phrases(path).items() if not phrase.strip()] == []


@pytest.mark.parametrize("path", CATALOGUES, ids=lambda path: path.stem)
def test_each_word_of_an_english_text_is_in_the_sources(path: Path, source_words: set[str]) -> None:
    """No page has a text with another word: it was changed, has a wrong plural, or somebody's name."""
    known = source_words | ELSEWHERE
    assert [text for text in phrases(path) if not known.issuperset(WORD.findall(text.lower()))] == []
