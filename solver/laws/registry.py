"""Finds laws: the built-in ones, and those of other packages by their entry points (``geoswarm.laws``)."""

from __future__ import annotations

import logging
from importlib import import_module
from typing import TYPE_CHECKING

from geoswarm.solver.errors import SolverError
from geoswarm.solver.system.installed import Installed

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law
    from geoswarm.solver.laws.binary import StressUpdate

__all__ = [
    "BUILT_IN",
    "GROUP",
    "USER_LAWS",
    "UnknownLawError",
    "find_law",
    "forget",
    "installed_laws",
    "kinds",
    "user_update",
]

log = logging.getLogger(__name__)

GROUP = "geoswarm.laws"
BUILT_IN = {
    "elastic": "geoswarm.solver.laws.elastic:Elastic",
    "drucker_prager": "geoswarm.solver.laws.perfect_plasticity.smooth_cones:DruckerPrager",
    "hardening_soil": "geoswarm.solver.laws.hardening_soil:HardeningSoilLaw",
    "hardening_soil_small": "geoswarm.solver.laws.hardening_soil_small:HardeningSoilSmallLaw",
    "hypoplastic_clay": "geoswarm.solver.laws.hypoplasticity.clay:HypoplasticClay",
    "hypoplastic_sand": "geoswarm.solver.laws.hypoplasticity.sand:HypoplasticSand",
    "matsuoka_nakai": "geoswarm.solver.laws.perfect_plasticity.smooth_cones:MatsuokaNakai",
    "modified_cam_clay": "geoswarm.solver.laws.modified_cam_clay:ModifiedCamClay",
    "mohr_coulomb": "geoswarm.solver.laws.perfect_plasticity.mohr_coulomb:MohrCoulomb",
    "soft_soil": "geoswarm.solver.laws.soft_soil_creep:SoftSoilLaw",
    "soft_soil_creep": "geoswarm.solver.laws.soft_soil_creep:SoftSoilCreepLaw",
}
"""Where the built-in laws are, by kind."""

USER_LAWS = {
    "umat": "geoswarm.solver.laws.libraries.umat_bridge:umat_update",
    "mfront": "geoswarm.solver.laws.libraries.mfront_bridge:mfront_update",
}
"""Laws in libraries of the user's, by kind, and the thin function around each. A problem describes them, see
:mod:`geoswarm.solver.user_laws`; they have no name under which they could be found."""


class UnknownLawError(SolverError):
    """No such law is installed, or it cannot be loaded."""


def _base() -> type:
    from geoswarm.solver.laws.base import Law  # with Numba, for which a formula should not wait

    return Law


_installed: Installed[Law] = Installed(
    "law",
    GROUP,
    BUILT_IN,
    _base,
    lambda found: found(),
    "unknown law '{kind}'{hint}; known: {known}",
    UnknownLawError,
    UnknownLawError,
)


def kinds() -> tuple[str, ...]:
    """Kinds of laws that are installed, loaded or not, the built-in ones first."""
    return _installed.kinds()


def installed_laws() -> tuple[Law, ...]:
    """Laws that are installed and can be loaded; what cannot is logged."""
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
    return _installed.find(kind)


def user_update(kind: str) -> StressUpdate:
    """Return the thin function around laws of a kind in libraries."""
    module, _, name = USER_LAWS[kind].partition(":")
    found: StressUpdate = getattr(import_module(module), name)
    return found


def forget() -> None:
    """Look for installed laws anew on the next use, for example after a package was installed."""
    _installed.forget()
