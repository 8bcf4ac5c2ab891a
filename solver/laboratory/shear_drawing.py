"""What tests that are sheared draw alike: the shear modulus over the logarithm of strain, and parts of the sketch."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from pydantic import BaseModel

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.forward.diagram import Derived, Diagram

__all__ = ["is_timed", "over_strain", "shear_modulus_diagram"]

_SMALL: Final = 1.0e-3
"""Shear strain: where none as small was read, the diagram shows less than the curve of stress over strain."""


def over_strain(stress: FloatArray, strain: FloatArray) -> FloatArray:
    """Stress over strain, (m,); nan without strain."""
    found: FloatArray = np.divide(stress, strain, out=np.full(np.shape(strain), np.nan), where=np.abs(strain) > 0.0)
    return found


def shear_modulus_diagram(series: str, derived: tuple[Derived, ...]) -> Diagram:
    """Secant shear modulus, a series of this name, over ``shear_strain``; ``derived``: by what it is found else."""
    caption = (
        "Secant shear modulus since the beginning of shearing over the logarithm of the shear strain; where it was not "
        "read itself, from stress and strain."
    )
    return Diagram(
        "shear_modulus", "Shear modulus", caption, "shear_strain", series, log=True, small=_SMALL, derived=derived
    )


_PACES = ("duration", "rate", "period")


def is_timed(stages: Sequence[BaseModel]) -> bool:
    """Whether all stages of shearing say how long they take."""
    return all(any(getattr(stage, name, None) is not None for name in _PACES) for stage in stages)
