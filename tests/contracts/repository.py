"""What the contract tests know about the repository."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

__all__ = ["PACKAGES", "ROOMS", "ROOT", "module_name", "project", "python_files"]

ROOT = Path(__file__).parents[2]
ROOMS = ("api", "workers", "solver")
PACKAGES = ("geoswarm", *ROOMS)
"""Folders of sources at the top; the rooms are linked into ``geoswarm`` (docs/decisions/0015-one-name.md)."""


def project() -> dict[str, Any]:
    """Read pyproject.toml."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))


def module_name(path: Path) -> str:
    """Return the name under which a source is imported."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    inside = ("geoswarm", *parts) if parts[0] in ROOMS else parts
    return ".".join(inside[:-1] if inside[-1] == "__init__" else inside)


def python_files(*folders: str) -> list[Path]:
    """Return all Python sources below some folders of the repository."""
    return sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py"))
