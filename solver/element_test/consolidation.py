"""Consolidation of a column of points of any laws: what water meets, states of the points, a stage of loading."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray, IntArray
from geoswarm.solver.element_test.column import (
    CONDUCT,
    GROUND_ROWS,
    GROWTH,
    LIFT,
    PROFILE,
    RESIST,
    SHARE,
    SINK,
    WEIGHT,
    Soils,
    profile,
)
from geoswarm.solver.element_test.column_steps import lead_column
from geoswarm.solver.element_test.load_paths import Path, PointState
from geoswarm.solver.element_test.step_control import AS_FOUND, DONE, NO_STEP, PAUSED
from geoswarm.solver.errors import DivergedError
from geoswarm.solver.laws.base import Soil

__all__ = ["Column", "Ground", "Movement", "Watched", "follow_loads", "follow_movement"]

_CHUNK: Final = 16
_MOST_STEPS: Final = 5_000
_FIRST: Final = 1.0e-4
_FIRST_GROWING: Final = 2.0e-2
_FIRST_AFTER: Final = 2.0e-3
"""First length to try, as a part of a stage: after a load at once, while a load grows, and after it has grown."""
_LEFT: Final = 1.0e-5
"""What Newton's method may leave of a balance of water, over the tolerance."""
_LEAST_LEFT: Final = 1.0e-13


@dataclass(frozen=True)
class Ground:
    """What water meets on its way through a column whose points are counted from its base.

    Parameters
    ----------
    share
        Part of the height that each point stands for, (j,).
    conduct
        k_0/(gamma_w H d), 1/(kPa day), (j,): H is the height of the column, d the way from the point to the next part.
    growth
        Of ln k with the present over the initial length, (j,).
    weight
        Effective stress at the points before the first movement, kPa, (j,), where points differ; or zeros.
    lift
        Fall of the total stress for a unit of lost length of each part, kPa, (j,): buoyancy.
    sink, resist
        What drains take for each part of the height, 1/(kPa day), and the share of their resistance in it, (j,).
    open_base, large
        Whether the base is drained, and whether strain is logarithmic.
    """

    share: FloatArray
    conduct: FloatArray
    growth: FloatArray
    weight: FloatArray
    lift: FloatArray
    sink: FloatArray
    resist: FloatArray
    open_base: bool
    large: bool

    @cached_property
    def rows(self) -> FloatArray:
        """As the kernel takes them, (7, j)."""
        rows = np.empty((GROUND_ROWS, self.share.size))
        rows[SHARE], rows[CONDUCT], rows[GROWTH] = self.share, self.conduct, self.growth
        rows[WEIGHT], rows[LIFT] = self.weight, self.lift
        rows[SINK], rows[RESIST] = self.sink, self.resist
        return rows


@dataclass
class Column:
    """Soils and states of the points of a column, from its base: stress (j, n), strain (j,), internal (j, s)."""

    soils: Sequence[Soil]
    stress: FloatArray
    strain: FloatArray
    internal: FloatArray

    @classmethod
    def of(cls, points: Sequence[tuple[Soil, PointState]]) -> Column:
        """Points without strain; those with fewer state variables than others have zeros in their place."""
        count, most = len(points), max(state.internal.size for _, state in points)
        internal = np.zeros((count, most))
        for row, (_, state) in zip(internal, points, strict=True):
            row[: state.internal.size] = state.internal
        stress = np.array([state.stress for _, state in points])
        return cls([soil for soil, _ in points], stress, np.zeros(count), internal)

    @cached_property
    def _groups(self) -> list[tuple[Soil, IntArray]]:
        """Each soil with its points."""
        found: dict[int, list[int]] = {}
        for place, soil in enumerate(self.soils):
            found.setdefault(id(soil), []).append(place)
        return [(self.soils[places[0]], np.array(places)) for places in found.values()]

    @cached_property
    def laws(self) -> Soils:
        """Addresses of the stress updates (j,) and constants (j, c)."""
        addresses = np.zeros(len(self.soils), dtype=np.int64)
        constants = np.zeros((len(self.soils), max(soil.constants.size for soil, _ in self._groups)))
        for soil, places in self._groups:
            addresses[places] = soil.law.update.address
            constants[places, : soil.constants.size] = soil.constants
        return addresses, constants

    @cached_property
    def state_weights(self) -> FloatArray:
        """Strain that one unit of each state variable stands for, (j, s); of flags and counters :data:`AS_FOUND`."""
        weights = np.zeros(self.internal.shape)
        for soil, places in self._groups:
            of_law = soil.law.state_weights(soil.constants)
            if soil.law.discrete is not None:
                of_law = np.where(soil.law.discrete, AS_FOUND, of_law)
            weights[places, : of_law.size] = of_law
        return weights

    def bulk_moduli(self) -> FloatArray:
        """Elastic bulk moduli at the present stresses, (j,), kPa."""
        moduli, p = np.empty(len(self.soils)), self.stress[:, :3].mean(axis=1)
        for soil, places in self._groups:
            law, constants = soil.law, soil.constants
            moduli[places] = [law.elastic_moduli(constants, one)[0] for one in p[places].tolist()]
        return moduli

    def profile(self, large: bool) -> FloatArray:
        """Vertical stress, loss of length over the initial one, and horizontal stress of the points, (3 j,)."""
        output = np.empty(PROFILE * self.strain.size)
        profile(self.stress, self.strain, large, output)
        return output


@dataclass(frozen=True)
class Movement:
    """A stage: what leads the top of a column, :data:`geoswarm.solver.element_test.column.BY_LOAD` for instance.

    ``begin`` and ``goal`` are its values at the beginning and at the end, ``duration`` is in days.
    """

    name: str
    lead: int
    begin: float
    goal: float
    duration: float


@dataclass(frozen=True)
class Watched:
    """Combinations of a profile (w, 3 j) whose error within steps is controlled, and the point of each (w,).

    Where a point is given the combination is a stress, and its error counts as a strain by the stiffness there; -1: it
    is a strain.
    """

    combinations: FloatArray
    points: IntArray

    @property
    def of_stress(self) -> BoolArray:
        """Which are stresses, (w,)."""
        found: BoolArray = self.points >= 0
        return found


def follow_movement(
    column: Column,
    ground: Ground,
    movement: Movement,
    watched: Watched,
    tolerance: float,
    check: Callable[[str, FloatArray], None],
    first: float = _FIRST,
) -> Path:
    """Lead a column through a stage, to whose end it is brought; a path of profiles (3 j,).

    Parameters
    ----------
    tolerance
        Error aimed at in each step, as strain, of stress over the bulk modulus.
    check
        Called now and then with the name of the stage and the strains (j,); raises what is wrong with them.
    first
        Length to try first, as a part of the stage.

    Raises
    ------
    DivergedError
        No step was found; names the stage and how far it came.
    """
    count = column.strain.size
    guess, limits = np.zeros((2, count)), np.full(count, -1, dtype=np.int64)
    now, length, steps = 0.0, first, 0
    width = PROFILE * count
    pieces = [(np.empty((0, 4)), np.empty((0, width)), column.profile(ground.large)[np.newaxis])]
    outcome = PAUSED if movement.duration > 0.0 else DONE
    of_state = np.where(column.state_weights == AS_FOUND, AS_FOUND, column.state_weights / tolerance)
    precision = max(_LEAST_LEFT, _LEFT * tolerance)
    while outcome == PAUSED:
        of_stress = 1.0 / (tolerance * column.bulk_moduli())
        of_watched = np.where(watched.of_stress, of_stress[watched.points], 1.0 / tolerance)
        room = (np.empty((_CHUNK, 4)), np.empty((_CHUNK, width)), np.empty((_CHUNK, width)))
        done, outcome, length = lead_column(
            movement.begin,
            movement.goal,
            movement.duration,
            now,
            length,
            (ground.rows, movement.lead, ground.open_base, ground.large, precision),
            (column.stress, column.strain, column.internal),
            column.laws,
            guess,
            limits,
            (of_stress, 1.0 / tolerance, of_state),
            (watched.combinations, of_watched),
            *room,
        )
        pieces.append((room[0][:done], room[1][:done], room[2][:done]))
        now = float(room[0][done - 1, 1]) if done else now
        steps += done
        check(movement.name, column.strain)
        if outcome == NO_STEP or steps > _MOST_STEPS:
            most = int(np.abs(column.strain).argmax())
            raise DivergedError(
                f"stage {movement.name}: no solution {now * movement.duration:.6g} day after its beginning, at "
                f"vertical effective stress {column.stress[most, 1]:.4g} kPa and strain {column.strain[most]:.4g} "
                "where it is strained most"
            )
    places, middles, ends = (np.concatenate([piece[i] for piece in pieces]) for i in range(3))
    return Path(movement.duration, places, middles, ends, 1)


def follow_loads(
    column: Column,
    ground: Ground,
    movements: Sequence[Movement],
    watched: Watched,
    tolerance: float,
    check: Callable[[str, FloatArray], None],
) -> list[Path]:
    """Lead a column through changes of the load: paths of rows (3 j + 1,), profiles with the change of the load, kPa.

    One without duration is a path of its own, along which water takes the load; parameters and errors are those of
    :func:`follow_movement`.
    """
    paths, grown = [], False
    for movement in movements:
        grows = movement.begin != movement.goal and movement.duration > 0.0
        first = _FIRST_GROWING if grows else (_FIRST_AFTER if grown else _FIRST)
        grown = grows
        if movement.duration > 0.0:
            path = follow_movement(column, ground, movement, watched, tolerance, check, first)
        else:
            rows = np.tile(column.profile(ground.large), (2, 1))
            path = Path(0.0, np.array([[0.0, 1.0, np.nan, 1.0]]), rows[:1], rows, 1)
        at = np.append(path.places[:1, 0], path.places[:, 1])
        loads = movement.begin + (movement.goal - movement.begin) * at
        middles = np.column_stack([path.middles, 0.5 * (loads[:-1] + loads[1:])])
        paths.append(Path(path.duration, path.places, middles, np.column_stack([path.ends, loads]), 1))
    return paths
