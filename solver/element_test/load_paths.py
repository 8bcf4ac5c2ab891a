"""Load paths of a material point: a movement of its controls or a hold, and the states along it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.element_test.advance import advance
from geoswarm.solver.element_test.step_control import AS_FOUND, DONE, NO_STEP
from geoswarm.solver.errors import DivergedError, InfeasibleError
from geoswarm.solver.laws.base import Soil
from geoswarm.solver.words import per_cent

__all__ = [
    "LoadPath",
    "Path",
    "PointState",
    "between",
    "follow_load_path",
    "point_in_words",
    "point_under",
    "points_under",
    "share_of",
]

_MOST_STEPS: Final = 200_000
_CHUNK: Final = 32
_HOLD_CHUNK: Final = 4
"""Steps of a hold after which the law is asked for its time scale again."""
_FIRST_MOVE: Final = 1.0e-2
_FIRST_HOLD: Final = 0.02


@dataclass(frozen=True)
class PointState:
    """State of a material point: stress (n,), kPa; strain (n,); the law's state variables (s,); n is 4 or 6."""

    stress: FloatArray
    strain: FloatArray
    internal: FloatArray


def point_under(stress: Sequence[float] | FloatArray, soil: Soil) -> PointState:
    """Unstrained state under a stress (4,) or (6,), kPa, in which the soil is placed; raises as the next function."""
    return points_under(np.array([stress], dtype=np.float64), soil)[0]


def points_under(stress: FloatArray, soil: Soil) -> list[PointState]:
    """Unstrained states under stresses (m, 4) or (m, 6), kPa, in which the soil is placed.

    Raises
    ------
    InfeasibleError
        The law has no stress update for that many components, or no state under a stress.
    """
    count = stress.shape[-1]
    if count not in soil.law.components:
        known = " or ".join(map(str, sorted(soil.law.components)))
        raise InfeasibleError(
            f"{soil.law.title} ({soil.law.kind}) has no stress update for element tests of {count} "
            f"components, only for {known}"
        )
    internal = soil.law.initial_state(stress, soil.constants)
    return [PointState(one, np.zeros(count), state) for one, state in zip(stress, internal, strict=True)]


@dataclass(frozen=True)
class LoadPath:
    """A movement of n controls at constant rate, or a hold.

    Parameters
    ----------
    name
        For messages.
    stress_rows, strain_rows
        Shapes (n, n): each control is a combination of stress plus one of the strain since the beginning of the load
        path. Those without stress are numbers, the others kPa.
    goal
        (n,): values at the end of the load path. Of a control without stress this is a change of strain. nan: the value
        at the beginning.
    duration
        Day; 0: an instantaneous movement.
    hold
        Whether the controls stay as they are, so that ``goal`` does not matter.
    """

    name: str
    stress_rows: FloatArray
    strain_rows: FloatArray
    goal: FloatArray
    duration: float
    hold: bool = False

    @property
    def of_stress(self) -> BoolArray:
        """Which controls have a part of stress, (n,)."""
        of_stress: BoolArray = (self.stress_rows != 0.0).any(axis=1)
        return of_stress


@dataclass(frozen=True)
class Path:
    """The states along one load path: steps with their ends and middles, and a parabola through each.

    ``places`` (k, 4): beginning and end of each step as fractions of the load path, ln(theta/day) and length in
    logarithmic time of a hold (theta nan: a movement); ``middles`` (k, m) and ``ends`` (k + 1, m): stress, strain and
    state variables in a row, the first of ``ends`` being the beginning of the load path.
    """

    duration: float
    places: FloatArray
    middles: FloatArray
    ends: FloatArray
    components: int

    def at(self, fractions: FloatArray) -> FloatArray:
        """Stress, strain and state variables, (q, m), at fractions (q,) of the load path, from 0 to 1."""
        if not self.places.shape[0]:
            return np.repeat(self.ends[:1], fractions.size, axis=0)
        step = np.minimum(np.searchsorted(self.places[:, 1], fractions, side="left"), self.places.shape[0] - 1)
        share = share_of(self.places[step], np.full(fractions.size, self.duration), fractions)
        return between(self.ends[step], self.middles[step], self.ends[step + 1], share)

    def seen(self, look: Callable[[FloatArray], FloatArray]) -> Path:
        """The path of what is observed, one component of stress and strain each, from rows of this one."""
        return Path(self.duration, self.places, look(self.middles), look(self.ends), 1)

    @property
    def end(self) -> PointState:
        """State at the end of the load path."""
        n, last = self.components, self.ends[-1]
        return PointState(last[:n].copy(), last[n : 2 * n].copy(), last[2 * n :].copy())


def share_of(places: FloatArray, duration: FloatArray, fractions: FloatArray) -> FloatArray:
    """Part of its step (q,), from 0 to 1, that lies before each fraction (q,) of a load path of ``duration`` (q,), day.

    ``places`` (q, 4): the step of each, as in a path.
    """
    begin, end, log_theta, length = places.T
    with np.errstate(divide="ignore", invalid="ignore"):
        share = (fractions - begin) / (end - begin)
    holds = ~np.isnan(log_theta)
    if holds.any():
        elapsed = np.maximum(fractions - begin, 0.0) * duration
        with np.errstate(divide="ignore", over="ignore", invalid="ignore"):
            in_time = np.logaddexp(0.0, np.log(elapsed) - log_theta) / length
        share = np.where(holds, np.where(fractions >= end, 1.0, in_time), share)
    clipped: FloatArray = np.clip(share, 0.0, 1.0)
    return clipped


def between(first: FloatArray, middle: FloatArray, last: FloatArray, share: FloatArray) -> FloatArray:
    """Values (q, m) on the parabolas through beginnings, middles and ends (q, m) of steps, at parts (q,) of them."""
    x = share[:, np.newaxis]
    bend = first - 2.0 * middle
    bend += last
    bend *= 2.0 * x
    values: FloatArray = 4.0 * middle
    values -= 3.0 * first
    values -= last
    values += bend
    values *= x
    values += first
    return values


def point_in_words(stress: FloatArray, strain: FloatArray) -> str:
    """Normal stresses, kPa, and strains of a point, for messages; components x, y, z first."""
    stresses, strains = (", ".join(f"{value:.4g}" for value in values[:3]) for values in (stress, strain))
    return f"at normal stresses {stresses} kPa and strains {strains} (x, y, z)"


def _elastic_guess(load_path: LoadPath, change: FloatArray, soil: Soil, state: PointState) -> FloatArray:
    """Strain (n,) of a movement of the controls by ``change`` (n,), were the soil elastic.

    Where a soil that softens is unloaded by stress, going on to yield is a solution, too: the first guess decides.
    """
    bulk, shear = soil.law.elastic_moduli(soil.constants, float(state.stress[:3].mean()))
    n = change.size
    stiffness = np.diag([2.0 * shear] * 3 + [shear] * (n - 3))
    stiffness[:3, :3] += bulk - 2.0 / 3.0 * shear
    try:
        return np.asarray(
            np.linalg.solve(load_path.stress_rows @ stiffness + load_path.strain_rows, change), np.float64
        )
    except np.linalg.LinAlgError:
        return np.zeros(n)


def follow_load_path(
    soil: Soil, load_path: LoadPath, state: PointState, tolerance: float, *, dense: bool = True
) -> Path:
    """Follow a load path with error-controlled steps.

    Parameters
    ----------
    state
        At the beginning.
    tolerance
        Error admitted in strain; of stress over the bulk modulus, of state variables by their weights.
    dense
        Whether values between the ends of steps will be wanted.

    Raises
    ------
    DivergedError
        No step was found, for instance because a load is above the strength; names the load path, the place in it,
        stress and strain there.
    """
    law, constants, duration, n = soil.law, soil.constants, load_path.duration, state.stress.size
    of_stress = load_path.of_stress
    start = load_path.stress_rows @ state.stress
    goal = start if load_path.hold else np.where(np.isnan(load_path.goal), start, load_path.goal)
    controls = (load_path.stress_rows, load_path.strain_rows, of_stress, start, goal)
    stress, strain, internal = state.stress.copy(), np.zeros(n), state.internal.copy()
    guess = np.zeros(n) if load_path.hold else _elastic_guess(load_path, goal - start, soil, state)
    now, length = 0.0, _FIRST_HOLD if load_path.hold else _FIRST_MOVE
    log_duration = math.log(duration) if duration > 0.0 else -math.inf
    of_state, of_strain = law.state_weights(constants) / tolerance, np.full(n, 1.0 / tolerance)
    if law.discrete is not None:
        of_state = np.where(law.discrete, AS_FOUND, of_state)
    pieces: list[tuple[FloatArray, FloatArray, FloatArray]] = []
    steps = 0
    while now < 1.0:
        log_theta = math.nan
        scale = law.log_time_scale(stress, internal, constants) if load_path.hold else None
        if load_path.hold:
            log_theta = log_duration if scale is None else float(scale)
        p = float(stress[:3].mean())
        bulk = law.elastic_moduli(constants, p)[0]
        weights = (np.full(n, 1.0 / (tolerance * bulk)), of_strain, of_state)
        room = _CHUNK if scale is None else _HOLD_CHUNK
        places, middles, ends = (np.empty((room, width)) for width in (4, *[2 * n + internal.size] * 2))
        count, outcome, length = advance(
            controls,
            log_duration,
            log_theta,
            now,
            length,
            stress,
            strain,
            internal,
            guess,
            law.update.address,
            constants,
            weights,
            (0.5 * p - 1.0, 2.0 * p + 1.0),
            dense,
            places,
            middles,
            ends,
        )
        steps += count
        pieces.append((places[:count], middles[:count], ends[:count]))
        now = float(places[count - 1, 1]) if count else now
        if outcome == NO_STEP or (outcome != DONE and steps > _MOST_STEPS):
            where = f"{now * duration:.6g} day after its beginning" if duration else f"at {per_cent(now)} of its load"
            raise DivergedError(
                f"stage {load_path.name}: no solution {where}, {point_in_words(stress, state.strain + strain)}"
            )
    first = np.concatenate([state.stress, np.zeros(n), state.internal])[np.newaxis]
    places, middles = (np.concatenate([piece[i] for piece in pieces]) for i in (0, 1))
    ends = np.concatenate([first, *(piece[2] for piece in pieces)])
    for values in (middles, ends):
        values[:, n : 2 * n] += state.strain
    return Path(duration, places, middles, ends, n)
