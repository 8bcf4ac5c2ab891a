"""Runs that are offered to a search."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from geoswarm.solver.arrays import FloatArray

__all__ = ["Offer"]


@dataclass(frozen=True, slots=True)
class Offer:
    """Runs of earlier jobs with the same forward model that a search may learn from.

    Parameters
    ----------
    parameters
        Natural values of this problem's free parameters, shape (k, d).
    responses
        Calculated values of every observed series, k of them.
    """

    parameters: FloatArray
    responses: Sequence[Mapping[str, FloatArray]]
