"""A change of strength in steps, from what the old stresses need down to what the new materials have.

A point that gets less strength than its stress needs is returned to its new limit at once. What that leaves out of
balance is all there from the first step of a phase on, however short the step is. With cohesion and tension cut-off
raised to what the old stresses need, and lowered while the load is applied, every step is short. By convexity each of
them has a balance with associated flow if the last one has.
"""

from __future__ import annotations

from typing import Final, NamedTuple

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.body import Body, State
from geoswarm.solver.fem.materials import INTERFACE_STRENGTH

__all__ = ["Begin", "Strength", "associated", "missing_strength", "strengthened"]

_NOTICED: Final = 1.0e-6
"""Part of the largest stress below which missing strength is rounding."""


class Begin(NamedTuple):
    """Where a phase begins: state, nodes (n, 2), displacement in the phase and forces that stresses carry (2 n,)."""

    state: State
    positions: FloatArray
    moved: FloatArray
    forces: FloatArray


class Strength(NamedTuple):
    """Cohesion and tension cut-off, kPa, in addition to those of soils (m, 2) and interfaces (k, 2)."""

    soils: FloatArray
    interfaces: FloatArray


def missing_strength(body: Body, state: State) -> Strength | None:
    """What the stresses need in addition to what the materials of the body have; None: they carry them."""
    soils = np.zeros((body.constants.shape[0], 2))
    interfaces = np.zeros((body.interface_constants.shape[0], 2))
    largest = max(float(np.abs(state.stress).max(initial=0.0)), float(np.abs(state.traction).max(initial=0.0)))
    for number, (constants, places) in enumerate(zip(body.constants, body.strength, strict=True)):
        if places[0] >= 0:
            c, sine, cosine, _, cutoff = constants[places]
            stress = -state.stress[body.material == number]
            centre, half = 0.5 * (stress[..., 0] + stress[..., 1]), 0.5 * (stress[..., 0] - stress[..., 1])
            radius = np.hypot(half, stress[..., 3])
            major, minor = np.maximum(centre + radius, stress[..., 2]), np.minimum(centre - radius, stress[..., 2])
            needed = (major * (1.0 - sine) - minor * (1.0 + sine)) / (2.0 * cosine)
            soils[number] = needed.max(initial=0.0) - c, (-minor).max(initial=0.0) - cutoff
    for number, constants in enumerate(body.interface_constants):
        c, friction, _, cutoff = constants[list(INTERFACE_STRENGTH)]
        normal, shear = np.moveaxis(state.traction[body.interface_material == number], -1, 0)
        needed = np.abs(shear) + normal * friction
        interfaces[number] = needed.max(initial=0.0) - c, normal.max(initial=0.0) - cutoff
    most = max(soils.max(initial=0.0), interfaces.max(initial=0.0))
    if not most > _NOTICED * largest:
        return None
    return Strength(np.maximum(soils, 0.0), np.maximum(interfaces, 0.0))


def strengthened(body: Body, more: Strength, share: float) -> Body:
    """The body with a share of more strength."""
    constants, interface_constants = body.constants.copy(), body.interface_constants.copy()
    for number, (cohesion, _, _, _, cutoff) in enumerate(body.strength.tolist()):
        if cohesion >= 0:
            constants[number, [cohesion, cutoff]] += share * more.soils[number]
    cohesion, _, _, cutoff = INTERFACE_STRENGTH
    interface_constants[:, [cohesion, cutoff]] += share * more.interfaces
    return body._replace(constants=constants, interface_constants=interface_constants)


def associated(body: Body) -> Body:
    """The body with dilatancy angles as large as the friction angles."""
    constants, interface_constants = body.constants.copy(), body.interface_constants.copy()
    for number, (_, friction, _, dilatancy, _) in enumerate(body.strength.tolist()):
        if friction >= 0:
            constants[number, dilatancy] = constants[number, friction]
    _, friction, dilatancy, _ = INTERFACE_STRENGTH
    interface_constants[:, dilatancy] = interface_constants[:, friction]
    return body._replace(constants=constants, interface_constants=interface_constants)
