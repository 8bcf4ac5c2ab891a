"""The site of the documentation: built strictly, whole, and without requests to others."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import geoswarm
from scripts.site_hooks import DOCS, MERMAID, diagram
from tests.contracts.repository import ROOT


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("site")
    command = [sys.executable, "-m", "mkdocs", "build", "--strict", "--quiet", "--site-dir", str(folder)]
    environment = {**os.environ, "NO_MKDOCS_2_WARNING": "1"}
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False, timeout=280)
    assert done.returncode == 0, done.stderr + done.stdout
    return folder


@pytest.mark.slow  # the service's own pages come from the same texts: tests/api/test_documentation.py
def test_every_page_is_there(site: Path) -> None:
    for path in DOCS.rglob("*.md"):
        name = path.relative_to(DOCS).with_suffix("")
        place = name.parent if name.name in ("index", "README") else name
        assert (site / place / "index.html").is_file() or name.name == "template", name
    assert (site / "examples" / "oedometer" / "index.html").is_file()


@pytest.mark.slow  # the service's own pages come from the same texts: tests/api/test_documentation.py
def test_a_page_loads_nothing_from_others(site: Path) -> None:
    loaded = re.compile(
        r"<(?:script|img|iframe|link(?= [^>]*rel=\"?(?:stylesheet|icon|preconnect)))[^>]*?(?:src|href)=\"?https?://"
    )
    found = {str(path.relative_to(site)) for path in site.rglob("*.html") if loaded.search(path.read_text("utf-8"))}
    assert found == set()


@pytest.mark.slow  # the service's own pages come from the same texts: tests/api/test_documentation.py
def test_docstrings_of_all_public_names_are_on_it(site: Path) -> None:
    pages = "".join((site / "reference" / name / "index.html").read_text("utf-8") for name in ("python", "plug-ins"))
    shown = {name.rpartition(".")[2] for name in re.findall(r'id="?(geoswarm\.[\w.]+)', pages)}
    assert set(geoswarm.__all__) - shown == set()


def test_diagrams_have_the_pictures_of_their_text() -> None:
    sources = [text for path in [ROOT / "README.md", *DOCS.rglob("*.md")] for text in MERMAID.findall(path.read_text())]
    assert {diagram(text) for text in sources} == {path.name for path in (DOCS / "pictures" / "diagrams").glob("*.svg")}
    assert len(sources) >= 4
