"""Versions of what a result depends on: the same seed gives the same numbers to the last bit under the same ones."""

from __future__ import annotations

import platform
from collections.abc import Mapping
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from types import MappingProxyType

__all__ = ["PACKAGES", "differences", "versions"]

PACKAGES = ("geoswarm", "numpy", "scipy", "numba", "cmaes")
"""Packages whose code a search or a forward calculation runs through."""


@cache
def versions() -> Mapping[str, str]:
    """Return the versions that calculate here: of :data:`PACKAGES`, ``python``, and ``machine`` (system, processor)."""
    found = {"geoswarm": "", "python": platform.python_version()}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed as a package"
    return MappingProxyType(found | {"machine": f"{platform.system()} {platform.machine()}"})


def differences(recorded: Mapping[str, str], other: Mapping[str, str]) -> list[str]:
    """Return what may change numbers from one set of versions to another, as ``numpy 2.4.6 instead of 2.3.5``.

    Python's third number is left out: such releases mend and do not calculate otherwise. What only one of the two
    knows is left out as well.
    """
    return [
        f"{name} {other[name]} instead of {before}"
        for name, before in recorded.items()
        if name in other and _matters(name, before) != _matters(name, other[name])
    ]


def _matters(name: str, number: str) -> str:
    return ".".join(number.split(".")[:2]) if name == "python" else number
