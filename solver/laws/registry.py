"""Finds laws: the built-in ones, and those of other packages by their entry points (``geoswarm.laws``)."""

from __future__ import annotations

import logging
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import TYPE_CHECKING, Any

from geoswarm.solver.errors import SolverError
from geoswarm.solver.words import did_you_mean

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["BUILT_IN", "GROUP", "UnknownLawError", "find_law", "forget", "installed_laws", "kinds"]

log = logging.getLogger(__name__)

GROUP = "geoswarm.laws"
BUILT_IN = {
    "elastic": "geoswarm.solver.laws.elastic:Elastic",
    "mohr_coulomb": "geoswarm.solver.laws.mohr_coulomb:MohrCoulomb",
    "soft_soil_creep": "geoswarm.solver.laws.soft_soil_creep:SoftSoilCreepLaw",
}
"""Where the built-in laws are, by kind."""


class UnknownLawError(SolverError):
    """No such law is installed, or it cannot be loaded."""


@cache
def _installed() -> dict[str, EntryPoint]:
    built_in = {kind: EntryPoint(kind, place, GROUP) for kind, place in BUILT_IN.items()}
    found = {entry.name: entry for entry in entry_points(group=GROUP)}
    return built_in | {kind: entry for kind, entry in sorted(found.items()) if kind not in built_in}


def kinds() -> tuple[str, ...]:
    """Kinds of laws that are installed, loaded or not, the built-in ones first."""
    return tuple(_installed())


def installed_laws() -> tuple[Law, ...]:
    """Laws that are installed and can be loaded; what cannot is told in the log."""
    found = []
    for kind in kinds():
        try:
            found.append(find_law(kind))
        except UnknownLawError as error:
            log.warning("%s", error)
    return tuple(found)


def find_law(kind: str) -> Law:
    """Find a law by its kind.

    Raises
    ------
    UnknownLawError
        No such law is installed (the message lists the known ones), or it cannot be loaded.
    """
    entry = _installed().get(kind)
    if entry is None:
        raise UnknownLawError(f"unknown law '{kind}'{did_you_mean(kind, kinds())}; known: {', '.join(kinds())}")
    return _load(entry)


@cache
def _load(entry: EntryPoint) -> Law:
    from geoswarm.solver.laws.base import Law  # with Numba, for which a formula should not wait

    source = f"law '{entry.name}' ({entry.value}) is installed but"
    try:
        found: Any = import_module(entry.module)
        for attribute in entry.attr.split("."):
            found = getattr(found, attribute)
    except Exception as error:  # anybody's code; a fault of our own is shown as one
        if entry.name in BUILT_IN:
            raise
        raise UnknownLawError(f"{source} cannot be loaded: {error}") from error
    if not (isinstance(found, type) and issubclass(found, Law)):
        raise UnknownLawError(f"{source} is not a subclass of geoswarm.solver.laws.base.Law")
    return found()


def forget() -> None:
    """Look for installed laws anew on the next use, for example after a package was installed."""
    _installed.cache_clear()
    _load.cache_clear()
