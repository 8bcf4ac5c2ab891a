"""Stages of shearing: what is led, how fast, with or without drainage; in the terms that all shear tests share.

A test leads one strain or the stress that belongs to it: the axial strain or the deviator stress of a triaxial test,
the shear strain or the shear stress of a simple shear test.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, TypeAlias

import numpy as np
from pydantic import BaseModel

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.forward.diagram import Derived, Diagram

if TYPE_CHECKING:
    from geoswarm.solver.element_test.load_paths import LoadPath, PointState

__all__ = [
    "Axes",
    "Control",
    "Drainage",
    "ShearStage",
    "is_timed",
    "over_strain",
    "shear_leg",
    "shear_modulus_diagram",
    "value_led",
]

Control: TypeAlias = Literal["strain", "stress"]
"""Whether the strain or the stress of a test is led."""


@dataclass(frozen=True)
class ShearStage:
    """One stage of shearing, as one movement after the other.

    Parameters
    ----------
    name
        For messages.
    control
        What is led.
    targets
        Values at the ends of the movements: engineering strain since the beginning of shearing, or stress, kPa.
    relative
        Whether targets count from the value at the beginning of the stage.
    durations
        Of the movements, day; None where ``rate`` gives them.
    rate
        Change of the value led in a day, above 0; None where ``durations`` are given.
    undrained
        Whether the volume is kept.
    path
        Which stress is kept, of those that the test knows: an effective one with drainage, a total one without.
    hold
        Whether nothing moves, so that only time passes.
    in_cycle
        Number of movements that make a cycle; 0: the stage has none.
    """

    name: str
    control: Control
    targets: tuple[float, ...]
    durations: tuple[float, ...] | None
    rate: float | None = None
    relative: bool = False
    undrained: bool = False
    path: str = ""
    hold: bool = False
    in_cycle: int = 0


@dataclass(frozen=True)
class Axes:
    """How a test leads its specimen, in n components.

    Parameters
    ----------
    strain, stress
        (n,): the strain led, and the stress that belongs to it, as combinations of components.
    kept
        By path (n,): the stress that is kept.
    alike
        Further combinations of strain that stay as they are, (n - 2, n).
    volume
        (n,): the combination of strain that is kept without drainage.
    inner, engineering
        From engineering strains to those inside, and back.
    largest
        Engineering strain below which targets are accepted.
    """

    strain: FloatArray
    stress: FloatArray
    kept: dict[str, FloatArray]
    alike: FloatArray
    volume: FloatArray
    inner: Callable[[FloatArray], FloatArray]
    engineering: Callable[[FloatArray], FloatArray]
    largest: float


@dataclass(frozen=True)
class Drainage:
    """What the pore water does during a load path.

    ``kept`` (n,) is the total stress that stays as it is without drainage; ``water`` the stiffness of the pore water
    for each volume of soil, kPa, inf where it is rigid.
    """

    undrained: bool
    kept: FloatArray
    water: float


def value_led(axes: Axes, control: Control, state: PointState, reference: FloatArray) -> float:
    """Engineering strain since the strain ``reference`` (n,), or stress, kPa, that a test leads."""
    if control == "stress":
        return float(axes.stress @ state.stress)
    return float(axes.engineering(axes.strain @ (state.strain - reference)))


def shear_leg(
    axes: Axes,
    stage: ShearStage,
    number: int,
    drainage: Drainage,
    state: PointState,
    reference: FloatArray,
    base: float,
) -> LoadPath:
    """One movement of a stage.

    Parameters
    ----------
    number
        Of the movement, 0-based.
    state, reference
        Present state, and strain at the beginning of shearing (n,).
    base
        Value from which relative targets count.
    """
    from geoswarm.solver.element_test.load_paths import LoadPath

    n = axes.strain.size
    stress_rows, strain_rows, goal = np.zeros((n, n)), np.zeros((n, n)), np.zeros(n)
    now = value_led(axes, stage.control, state, reference)
    target = stage.targets[number] + (base if stage.relative else 0.0)
    if stage.control == "strain":
        strain_rows[0] = axes.strain
        if not target < axes.largest:
            raise InfeasibleError(f"stage {stage.name}: strain must be below {axes.largest:g}, got {target:g}")
        goal[0] = axes.inner(np.array(target)) - axes.inner(np.array(now))
    else:
        stress_rows[0] = axes.stress
        goal[0] = target
    if drainage.undrained and math.isinf(drainage.water):
        strain_rows[1] = axes.volume
    else:
        stress_rows[1] = drainage.kept
        goal[1] = math.nan
        if drainage.undrained:
            strain_rows[1] = drainage.water * axes.volume
    strain_rows[2:] = axes.alike
    duration = stage.durations[number] if stage.durations is not None else 0.0
    if stage.rate is not None:
        duration = abs(target - now) / stage.rate
    return LoadPath(stage.name, stress_rows, strain_rows, goal, duration, hold=stage.hold)


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
