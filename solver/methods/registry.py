"""Finds methods: the built-in ones, and those of other packages by their entry points (``geoswarm.methods``)."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from typing import Any

from geoswarm.solver.errors import SolverError
from geoswarm.solver.methods.base import Method, Role
from geoswarm.solver.words import did_you_mean

__all__ = ["BUILT_IN", "GROUP", "UnknownMethodError", "built_in_methods", "find_method", "forget", "kinds", "kinds_of"]

GROUP = "geoswarm.methods"
BUILT_IN = {
    "particle_swarm": "geoswarm.solver.methods.particle_swarm:ParticleSwarmMethod",
    "differential_evolution": "geoswarm.solver.methods.differential_evolution:DifferentialEvolutionMethod",
    "monte_carlo": "geoswarm.solver.methods.monte_carlo:MonteCarloMethod",
    "sensitivity": "geoswarm.solver.methods.sensitivity:SensitivityMethod",
    "profile": "geoswarm.solver.methods.profile:ProfileMethod",
    "sobol": "geoswarm.solver.methods.global_designs:SobolMethod",
    "morris": "geoswarm.solver.methods.global_designs:MorrisMethod",
}
"""Where the built-in methods are, by kind."""


class UnknownMethodError(SolverError):
    """No such method is installed, or it cannot be loaded."""


@cache
def _installed() -> dict[str, EntryPoint]:
    built_in = {kind: EntryPoint(kind, place, GROUP) for kind, place in BUILT_IN.items()}
    found = {entry.name: entry for entry in entry_points(group=GROUP)}
    return built_in | {kind: entry for kind, entry in sorted(found.items()) if kind not in built_in}


def kinds() -> tuple[str, ...]:
    """Kinds of methods that are installed, loaded or not, the built-in ones first."""
    return tuple(_installed())


def kinds_of(role: Role) -> tuple[str, ...]:
    """Kinds of methods with a role, of those that can be loaded."""
    found = []
    for kind in kinds():
        try:
            method = find_method(kind)
        except UnknownMethodError:
            continue
        if method.role == role:
            found.append(kind)
    return tuple(found)


def built_in_methods() -> tuple[type[Method], ...]:
    """Classes of the built-in methods."""
    return tuple(find_method(kind) for kind in BUILT_IN)


def find_method(kind: str) -> type[Method]:
    """Find the class that describes the ``method`` section of a kind.

    Raises
    ------
    UnknownMethodError
        No such kind is installed (the message lists the known ones), or it cannot be loaded.
    """
    entry = _installed().get(kind)
    if entry is None:
        raise UnknownMethodError(f"unknown kind '{kind}'{did_you_mean(kind, kinds())}; known: {', '.join(kinds())}")
    return _load(entry)


@cache
def _load(entry: EntryPoint) -> type[Method]:
    source = f"method '{entry.name}' ({entry.value}) is installed but"
    try:
        found: Any = import_module(entry.module)
        for attribute in entry.attr.split("."):
            found = getattr(found, attribute)
    except Exception as error:  # anybody's code; a fault of our own is shown as one
        if entry.name in BUILT_IN:
            raise
        raise UnknownMethodError(f"{source} cannot be loaded: {error}") from error
    if not (isinstance(found, type) and issubclass(found, Method)):
        raise UnknownMethodError(f"{source} is not a subclass of geoswarm.solver.methods.base.Method")
    return found


def forget() -> None:
    """Look for installed methods anew on the next use, for example after a package was installed."""
    _installed.cache_clear()
    _load.cache_clear()
