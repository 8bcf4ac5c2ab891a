"""Usual ranges and correlations in the documentation are generated: the committed pages must be what is declared."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from types import ModuleType

GENERATOR = Path(__file__).parents[2] / "docs" / "generate_ranges.py"


def generator() -> ModuleType:
    spec = importlib.util.spec_from_file_location(GENERATOR.stem, GENERATOR)
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_committed_pages_are_current() -> None:
    for page, text in generator().pages().items():
        assert page.read_text(encoding="utf-8") == text, "run: python docs/generate_ranges.py"


def test_pages_name_ranges_and_sources() -> None:
    folder = GENERATOR.parent
    assert "Herle & Gudehus (1999)" in (folder / "laws" / "hypoplastic-sand.md").read_text(encoding="utf-8")
    assert "0.009 (w_L - 10)" in (folder / "index-properties.md").read_text(encoding="utf-8")
