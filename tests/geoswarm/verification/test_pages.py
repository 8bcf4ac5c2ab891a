"""The manual as files: what is on a page, and that the committed pages are those of the declared cases."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest

from geoswarm.verification.case import Curve, Plot
from geoswarm.verification.catalogue import CHAPTERS, find_cases
from geoswarm.verification.figure import plot_figure
from geoswarm.verification.pages import INDEX, declared, page_name, write_pages
from geoswarm.verification.provenance import provenance
from geoswarm.verification.run import CaseResult, run_cases
from tests.contracts.repository import ROOT

DOCS = ROOT / "docs" / "verification"
NAMES = ("creep-relaxation", "strength-triaxial", "statistics-sobol")


@pytest.fixture(scope="module")
def outcomes() -> list[CaseResult]:
    found = list(run_cases(find_cases(NAMES)))
    found[-1] = CaseResult(found[-1].case, None, 0.0, "needs the extra statistics", "left out")
    return found


def test_pages_hold_what_the_cases_say(outcomes: list[CaseResult], tmp_path: Path) -> None:
    where = provenance(machine="a machine <of> tests")
    page = write_pages(outcomes, where, tmp_path)
    html = page.read_text(encoding="utf-8")
    assert html.count("<svg ") == 2
    assert "<script" not in html
    assert "a machine &lt;of&gt; tests" in html
    assert html.count("2 of 3 cases hold, 1 left out") == 1
    ids = re.findall(r'\bid="([^"]+)"', html)
    assert len(ids) == len(set(ids))
    assert {link for link in re.findall(r'href="#([^"]+)"', html) if not link.startswith("v")} == set(NAMES)
    assert {path.name for path in tmp_path.iterdir()} == {
        *("README.md", "index.html", "results.json", "figures"),
        *("creep.md", "strength.md", "inference.md"),
    }
    assert {path.stem for path in (tmp_path / "figures").iterdir()} == set(NAMES[:2])
    index = (tmp_path / INDEX).read_text(encoding="utf-8")
    assert "(creep.md#relaxation-at-constant-volume)" in index
    assert all(number in index for number in where.versions.values())
    text = (tmp_path / "creep.md").read_text(encoding="utf-8")
    assert "p = p₀ (1 + λ\\* t/(κ\\* τ))^(−μ\\*/λ\\*)" in text
    assert "needs the extra statistics" in (tmp_path / "inference.md").read_text(encoding="utf-8")
    results = json.loads((tmp_path / "results.json").read_text(encoding="utf-8"))
    assert [one["name"] for one in results["cases"]] == list(NAMES)
    assert results["provenance"]["machine"] == "a machine <of> tests"


def test_curves_that_coincide_can_be_told_apart() -> None:
    x = np.arange(3.0)
    curves = tuple(Curve(f"curve {number}", x, x) for number in range(6))
    (axes,) = plot_figure(Plot("x", "y", curves)).axes
    looks = [(line.get_color(), line.get_linestyle()) for line in axes.get_lines()[:6]]
    assert len(set(looks)) == 6
    assert len({style for _, style in looks[:2]}) == 2


def test_the_name_of_the_machine_is_reported() -> None:
    where = provenance()
    assert re.search(r", \d+ cores$", where.machine)
    assert {"geoswarm", "numpy", "scipy", "numba", "matplotlib"} <= where.versions.keys()
    assert re.fullmatch(r"\d{4}-\d\d-\d\d \d\d:\d\d UTC", where.date)


def test_the_committed_pages_are_those_of_the_declared_cases() -> None:
    """Their numbers are those of the machine that ran them; a run here is in tests/verification/test_cases.py."""
    again = "run: python docs/generate_verification.py"
    assert {path.name for path in DOCS.glob("*.md")} == {INDEX, *(page_name(chapter) for chapter in CHAPTERS)}, again
    assert {path.stem for path in (DOCS / "figures").iterdir()} == {one.name for one in find_cases()}, again
    menu = (ROOT / "mkdocs.yml").read_text(encoding="utf-8")
    index = (DOCS / INDEX).read_text(encoding="utf-8")
    for chapter in CHAPTERS:
        text = (DOCS / page_name(chapter)).read_text(encoding="utf-8")
        assert f"- verification/{page_name(chapter)}\n" in menu
        assert re.findall(r"^## (.*)$", text, re.MULTILINE) == [one.title for one in chapter.cases], again
        for one in chapter.cases:
            assert "\n\n".join(declared(one)) in text, again
            assert f"(figures/{one.name}.svg)" in text, again
            assert f"[{one.title}]({page_name(chapter)}#" in index, again
    assert "fails" not in index


@pytest.mark.parametrize("path", ["README.md", "docs/index.md", "docs/summary.md"])
def test_pages_that_count_cases_count_rightly(path: str) -> None:
    text = (ROOT / path).read_text(encoding="utf-8")
    told = re.findall(r"\[?(\d+)\s+(?:cases|of these\s+checks)", text)
    assert told == [str(len(find_cases()))]
