"""Catalogues of the dashboard's languages: each phrase takes what its English text inserts."""

from __future__ import annotations

import json
import re
from pathlib import Path

import pytest

CATALOGUES = sorted((Path(__file__).parents[2] / "api" / "static" / "languages").glob("*.json"))
PLACE = re.compile(r"\{(\d*)\}")
NAMED = re.compile(r"(?<!\{)\{[a-z_]+(?:[.:!][^{} ]*)?\}(?!\})|\{:[^}]*\}")
"""A place as a program names it; `{E: kPa}` and `{{E}}` are what people write in a problem file."""


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
