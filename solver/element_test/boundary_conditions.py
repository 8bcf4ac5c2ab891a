"""What is prescribed at a material point during a stage: six combinations of stress or strain components.

Components as in :mod:`geoswarm.solver.constitutive.tensors` (xx, yy, zz, xy, yz, zx; engineering shear strains),
compression positive, zz axial. Strain is logarithmic where axes do not turn; read as small strain, the equations are
the same.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray

__all__ = ["AXIAL", "COMPONENTS", "Control", "Stage", "strain_change", "stress_value"]

COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")
AXIAL = 2
"""Index of the axial component."""


@dataclass(frozen=True, slots=True)
class Control:
    """One prescribed combination ``coefficients . stress`` or ``coefficients . strain``.

    ``value`` is the combination's stress at the end of the stage, kPa, or the *change* of its strain in the stage.
    """

    coefficients: tuple[float, ...]
    value: float
    stress: bool


def stress_value(value: float, **coefficients: float) -> Control:
    """Prescribe a stress combination, kPa: ``stress_value(100.0, zz=1)``, ``stress_value(50.0, zz=1, xx=-1)``."""
    return Control(_row(coefficients), value, stress=True)


def strain_change(value: float, **coefficients: float) -> Control:
    """Prescribe the change of a strain combination: ``strain_change(0.0, xx=1, yy=1, zz=1)`` keeps the volume."""
    return Control(_row(coefficients), value, stress=False)


def _row(coefficients: dict[str, float]) -> tuple[float, ...]:
    unknown = sorted(set(coefficients) - set(COMPONENTS))
    if unknown or not coefficients:
        raise ValueError(f"components must be one or more of {', '.join(COMPONENTS)}, got {unknown or 'none'}")
    return tuple(float(coefficients.get(name, 0.0)) for name in COMPONENTS)


@dataclass(frozen=True, slots=True)
class Stage:
    """A period with six controls that are linearly independent.

    ``instant``: the values are reached at once and then kept for ``duration`` days (which may be 0: an instantaneous
    load); otherwise they are approached at constant rate over ``duration``, which must be above 0.
    """

    name: str
    duration: float
    controls: tuple[Control, ...]
    instant: bool = False

    def __post_init__(self) -> None:
        if not (0.0 <= self.duration < float("inf")) or (self.duration == 0.0 and not self.instant):
            raise ValueError(
                f"stage {self.name}: duration must be above 0, or 0 when instant; got {self.duration:g} day"
            )
        if len(self.controls) != len(COMPONENTS):
            raise ValueError(
                f"stage {self.name}: exactly {len(COMPONENTS)} controls are needed, got {len(self.controls)}"
            )

    def arrays(self) -> tuple[FloatArray, BoolArray, FloatArray]:
        """Coefficients (6, 6), whether each row is of stress (6,), and values (6,)."""
        controls: Sequence[Control] = self.controls
        return (
            np.array([control.coefficients for control in controls]),
            np.array([control.stress for control in controls]),
            np.array([control.value for control in controls], dtype=np.float64),
        )
