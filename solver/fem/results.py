"""What a calculation by finite elements gives."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

from geoswarm.solver.arrays import BoolArray, FloatArray

__all__ = ["History", "Path", "PhaseResult"]

Path: TypeAlias = Literal["direct", "steps", "associated"]
"""How a load was applied: with the strength of the materials from its beginning, with strength lowered to theirs in
steps, or with that and associated flow."""


@dataclass(frozen=True)
class History:
    """Displacements of the observed points at the recorded moments of a phase.

    Parameters
    ----------
    times
        (m,): day since the beginning of the phase; without time, the part of the load that is applied.
    displacements
        (m, k, 2), m: since the last phase that reset displacements.
    """

    times: FloatArray
    displacements: FloatArray


@dataclass(frozen=True)
class PhaseResult:
    """State at the end of a phase, and its history.

    Parameters
    ----------
    name
        Of the phase.
    history
        Of the observed points.
    displacements
        (n, 2), m: since the last phase that reset displacements.
    positions
        (n, 2), m: of the nodes; the mesh as it was given unless a phase updated it.
    stress
        (e, 3, 4), kPa, tension positive: xx, yy, zz, xy at the integration points; 0 in inactive regions.
    internal
        (e, 3, s): the state variables of the regions' laws, in their order; 0 beyond them.
    plastic
        (e, 3): points at a strength limit.
    interface_tractions
        (k, 3, 2), kPa: normal (tension positive) and shear traction at start, mid and end.
    reactions
        (n, 2), kN/m, in axisymmetry kN/rad: forces that the fixities exert.
    steps, iterations, factorisations
        How much work it was.
    path
        How its load was applied.
    """

    name: str
    history: History
    displacements: FloatArray
    positions: FloatArray
    stress: FloatArray
    internal: FloatArray
    plastic: BoolArray
    interface_tractions: FloatArray
    reactions: FloatArray
    steps: int
    iterations: int
    factorisations: int
    path: Path
