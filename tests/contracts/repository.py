"""What the contract tests know about the repository."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

__all__ = ["PACKAGES", "ROOT", "project", "python_files"]

ROOT = Path(__file__).parents[2]
PACKAGES = ("geoswarm", "api", "workers", "solver")


def project() -> dict[str, Any]:
    """Read pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def python_files(*folders: str) -> list[Path]:
    """Return all Python sources below some folders of the repository."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))
