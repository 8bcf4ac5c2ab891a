"""What happened in a shear test: the states after consolidation, the trace of shearing, the water in each load path."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.element_test.load_paths import LoadPath, Path, PointState, follow_load_path, point_in_words
from geoswarm.solver.element_test.trace import Sample, Trace
from geoswarm.solver.errors import DivergedError, InfeasibleError
from geoswarm.solver.laboratory.shear_stages import Axes, Drainage, ShearStage, shear_leg, value_led
from geoswarm.solver.laws.base import Soil

__all__ = ["Record", "Voids", "consolidated", "no_voids", "sheared"]

_MOST_STRAIN: Final = 1.0
"""Normal strain beyond which a specimen is none any more, as one of liquefied sand that goes on flowing."""


@dataclass(frozen=True)
class Voids:
    """Void ratio of a specimen from its strain since the beginning, and the stiffness of the water in it.

    ``initial`` None: not known. ``water_modulus`` kPa, None: the water is rigid.
    """

    initial: float | None
    fixed: bool
    water_modulus: float | None

    def ratio(self, strain: FloatArray) -> FloatArray:
        """Void ratio, (m,), at volume strains (m,); nan where it is not known."""
        return self.of_settlement(strain if self.fixed else -np.expm1(-strain))

    def of_settlement(self, share: FloatArray) -> FloatArray:
        """Void ratio, (m,), after a loss of volume, (m,), over the volume at the beginning; nan where not known."""
        initial = math.nan if self.initial is None else self.initial
        return initial - (1.0 + initial) * share

    def water(self, strain: FloatArray) -> float:
        """Stiffness of the pore water for each volume of soil, kPa, at a strain (n,): modulus over porosity."""
        if self.water_modulus is None:
            return math.inf
        e = float(self.ratio(strain[:3].sum(keepdims=True))[0])
        return self.water_modulus * (1.0 + e) / e

    def check(self, name: str, strain: FloatArray) -> None:
        """Refuse volume strains (m,) that leave no voids.

        Raises
        ------
        InfeasibleError
            The void ratio falls to 0; names the stage.
        """
        if self.initial is None:
            return
        largest = float(strain.max())
        share = largest if self.fixed else -math.expm1(-largest)
        if self.initial - (1.0 + self.initial) * share <= 0.0:
            raise no_voids(name, self.initial, share)


def no_voids(stage: str, initial: float, share: float, of: str = "") -> InfeasibleError:
    """What is said where a loss of volume, over that at the beginning, leaves no voids."""
    return InfeasibleError(
        f"stage {stage}: the void ratio{of} falls to {initial - (1.0 + initial) * share:.3g}; above 0 is accepted: a "
        f"higher initial void ratio than {initial:g}, or a stiffer soil"
    )


@dataclass(frozen=True)
class Record:
    """A shear test that was calculated.

    Parameters
    ----------
    initial
        State before the first stage of consolidation, a row (w,).
    consolidation
        States at the ends of its stages, (c, w).
    trace
        Of shearing.
    undrained, pore, kept
        For each load path of it: whether the volume is kept, the pore pressure at its beginning less the back pressure,
        kPa, and the total stress that stays as it is without drainage, (l,), (l,), (l, n).
    last_legs, cycles
        Last load path of each stage, and first and last load path of each cycle, (s,), (z, 2).
    voids, back_pressure
        Void ratio from the strain since the beginning; kPa.
    """

    initial: FloatArray
    consolidation: FloatArray
    trace: Trace
    undrained: BoolArray
    pore: FloatArray
    kept: FloatArray
    last_legs: IntArray
    cycles: IntArray
    voids: Voids
    back_pressure: float

    @property
    def components(self) -> int:
        """n, of stress and strain."""
        return int(self.kept.shape[1])

    @property
    def reference(self) -> FloatArray:
        """State at the beginning of shearing, a row (w,)."""
        return self.consolidation[-1] if self.consolidation.size else self.initial

    def excess(self, sample: Sample) -> FloatArray:
        """Pore pressure less the back pressure, (m,), kPa: what the total stress that is kept leaves for the water."""
        n = self.components
        first = np.array([path.ends[0, :n] for path in self.trace.paths])
        held, load_path = self.kept[sample.load_path], sample.load_path
        fallen = (held * (first[load_path] - sample.rows[:, :n])).sum(axis=1)
        return self.pore[load_path] + np.where(self.undrained[load_path], fallen, 0.0)


def row_of(state: PointState) -> FloatArray:
    """A state as a row of numbers."""
    return np.concatenate([state.stress, state.strain, state.internal])


def consolidated(
    soil: Soil, start: PointState, stages: Sequence[Sequence[LoadPath]], voids: Voids, tolerance: float
) -> tuple[FloatArray, PointState]:
    """Lead a specimen through stages of consolidation: states at their ends (c, w), and the last one.

    Raises
    ------
    DivergedError, InfeasibleError
        A stage has no solution, leaves no voids, or strains the specimen beyond 1.
    """
    state, rows = start, [np.empty((0, row_of(start).size))]
    for load_paths in stages:
        for load_path in load_paths:
            path = follow_load_path(soil, load_path, state, tolerance, dense=False)
            _check(path, load_path.name, voids)
            state = path.end
        rows.append(row_of(state)[np.newaxis])
    return np.concatenate(rows), state


def sheared(
    soil: Soil,
    axes: Axes,
    start: PointState,
    consolidation: FloatArray,
    state: PointState,
    stages: Sequence[ShearStage],
    voids: Voids,
    back_pressure: float,
    tolerance: float,
    dense: bool,
) -> Record:
    """Shear a specimen.

    Parameters
    ----------
    start, consolidation, state
        State before the test, rows at the ends of its consolidation (c, w), and the state after it.
    dense
        Whether values between the ends of steps will be wanted.

    Raises
    ------
    DivergedError, InfeasibleError
        A stage has no solution, leaves no voids, or strains the specimen beyond 1.
    """
    reference, pressure = state.strain, 0.0
    paths: list[Path] = []
    undrained, pore, kept, last_legs, cycles = [], [], [], [], []
    for stage in stages:
        base = value_led(axes, stage.control, state, reference)
        for number in range(len(stage.targets)):
            water = voids.water(state.strain) if stage.undrained else math.inf
            drainage = Drainage(stage.undrained, axes.kept[stage.path], water)
            load_path = shear_leg(axes, stage, number, drainage, state, reference, base)
            path = follow_load_path(soil, load_path, state, tolerance, dense=dense)
            _check(path, stage.name, voids)
            undrained.append(stage.undrained)
            pore.append(pressure)
            kept.append(drainage.kept)
            if stage.undrained:
                pressure += float(drainage.kept @ (state.stress - path.end.stress))
            state = path.end
            paths.append(path)
            if stage.in_cycle and (number + 1) % stage.in_cycle == 0:
                cycles.append((len(paths) - stage.in_cycle, len(paths) - 1))
        last_legs.append(len(paths) - 1)
    return Record(
        row_of(start),
        consolidation,
        Trace(paths),
        np.array(undrained, dtype=np.bool_),
        np.array(pore),
        np.array(kept).reshape(-1, start.stress.size),
        np.array(last_legs, dtype=np.int64),
        np.array(cycles, dtype=np.int64).reshape(-1, 2),
        voids,
        back_pressure,
    )


def _check(path: Path, name: str, voids: Voids) -> None:
    """Refuse a path that leaves no voids, or deforms the specimen so far that it is none any more."""
    n = path.components
    strains = path.ends[:, n : n + 3]
    voids.check(name, strains.sum(axis=1))
    beyond = np.flatnonzero(np.abs(strains).max(axis=1) > _MOST_STRAIN)
    if beyond.size:
        there = path.ends[beyond[0]]
        raise DivergedError(f"stage {name}: strain beyond {_MOST_STRAIN:g}, {point_in_words(there, there[n:])}")
