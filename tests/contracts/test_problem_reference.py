"""The reference of the problem file is generated: the committed page must be the one that follows from the models."""

from __future__ import annotations

import importlib.util
from pathlib import Path

GENERATOR = Path(__file__).parents[2] / "docs" / "generate_problem_reference.py"


def test_the_committed_page_is_current() -> None:
    spec = importlib.util.spec_from_file_location(GENERATOR.stem, GENERATOR)
    assert spec is not None
    assert spec.loader is not None
    generator = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(generator)
    committed = generator.PAGE.read_text(encoding="utf-8")
    assert committed == generator.page(), "run: python docs/generate_problem_reference.py"


def test_the_page_names_what_users_write() -> None:
    page = (GENERATOR.parent / "problem-file.md").read_text(encoding="utf-8")
    for word in (
        "lambda_star",
        "isotropic_compression",
        "zero_at_stage",
        "stage_void_ratio",
        "latin_hypercube",
        "x_unit",
    ):
        assert f"`{word}`" in page
