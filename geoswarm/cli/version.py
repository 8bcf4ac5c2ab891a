"""The version of this installation."""

from __future__ import annotations

from importlib.metadata import PackageNotFoundError
from importlib.metadata import version as installed_version

__all__ = ["version"]


def version() -> str:
    """Return the version of the installed package; ``unknown`` in a checkout that is not installed."""
    try:
        return installed_version("geoswarm")
    except PackageNotFoundError:
        return "unknown (not installed)"
