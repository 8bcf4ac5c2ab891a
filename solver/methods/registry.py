"""Finds methods: the built-in ones, and those of other packages by their entry points (``geoswarm.methods``)."""

from __future__ import annotations

from geoswarm.solver.errors import SolverError
from geoswarm.solver.methods.base import Method, Role
from geoswarm.solver.system.installed import Installed

__all__ = ["BUILT_IN", "GROUP", "UnknownMethodError", "built_in_methods", "find_method", "forget", "kinds", "kinds_of"]

GROUP = "geoswarm.methods"
BUILT_IN = {
    "particle_swarm": "geoswarm.solver.methods.particle_swarm:ParticleSwarmMethod",
    "differential_evolution": "geoswarm.solver.methods.differential_evolution:DifferentialEvolutionMethod",
    "monte_carlo": "geoswarm.solver.methods.monte_carlo:MonteCarloMethod",
    "sensitivity": "geoswarm.solver.methods.sensitivity:SensitivityMethod",
    "profile": "geoswarm.solver.methods.profile:ProfileMethod",
    "jackknife": "geoswarm.solver.methods.jackknife:JackknifeMethod",
    "explore": "geoswarm.solver.methods.explore:ExploreMethod",
    "predict": "geoswarm.solver.methods.predict:PredictMethod",
    "design": "geoswarm.solver.methods.design:DesignMethod",
    "sobol": "geoswarm.solver.methods.global_designs:SobolMethod",
    "morris": "geoswarm.solver.methods.global_designs:MorrisMethod",
}
"""Where the built-in methods are, by kind."""


class UnknownMethodError(SolverError):
    """No such method is installed, or it cannot be loaded."""


_installed: Installed[type[Method]] = Installed(
    "method",
    GROUP,
    BUILT_IN,
    lambda: Method,
    lambda found: found,
    "unknown kind '{kind}'{hint}; known: {known}",
    UnknownMethodError,
    UnknownMethodError,
)


def kinds() -> tuple[str, ...]:
    """Kinds of methods that are installed, loaded or not, the built-in ones first."""
    return _installed.kinds()


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
    return _installed.find(kind)


def forget() -> None:
    """Look for installed methods anew on the next use, for example after a package was installed."""
    _installed.forget()
