"""Steps of load and of time through one phase, with cutting where a step fails and growth where it is easy."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Final, TypeAlias

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.errors import DivergedError
from geoswarm.solver.fem.body import Body, State, copied
from geoswarm.solver.fem.multifrontal import Equations
from geoswarm.solver.fem.newton import CONVERGED, SINGULAR, Accuracy, Step, newton_step
from geoswarm.solver.fem.ordering import Fronts
from geoswarm.solver.fem.phases import Control, Phase
from geoswarm.solver.fem.results import Path
from geoswarm.solver.fem.strength import Begin, Strength, associated, missing_strength, strengthened

__all__ = ["PhaseSteps", "Recorder", "Work"]

Recorder: TypeAlias = Callable[[float, FloatArray], None]
"""Called with the time and the displacements (2 n,) since the beginning of the phase."""

_EASY: Final = 6
"""Iterations up to which the next step may be longer."""

_BLEND: Final = 0.08
"""Share of the elastic stiffness at plastic points that load steps begin with."""

_LAST_BLEND: Final = 0.1
_PATIENCE: Final = 6
"""The last attempt at a step: its share, and how many times the iterations."""

_STRICTER: Final = 0.1
"""Share of the tolerance on the way with which a load is approached again."""

_STRENGTH_STEP: Final = 0.01
"""Smallest step of a change of strength."""

_FIRST_CREEP: Final = 0.01
_SMALLEST_CREEP: Final = 1.0e-8
_NOISE: Final = 1.0e-3
"""Share of the displacements before a creep phase that its own are taken for at least when errors are judged."""


@dataclass
class Work:
    """How much was done."""

    steps: int = 0
    iterations: int = 0
    factorisations: int = 0
    assemblies: int = 0


@dataclass
class PhaseSteps:
    """One phase on its way: the state moves with every step that converges.

    ``start_forces`` and ``end_forces`` (2 n,) are the forces without followers at the beginning and at the end of the
    load, ``edge_loads`` (q, LOAD_NUMBERS) the follower loads at its end, ``target`` (2 n,) the prescribed changes,
    ``known`` the largest displacement before the phase, m.
    """

    phase: Phase
    control: Control
    body: Body
    plan: Fronts
    equations: Equations
    positions: FloatArray
    state: State
    spare: State
    start_forces: FloatArray
    end_forces: FloatArray
    edge_loads: FloatArray
    fixed: BoolArray
    target: FloatArray
    floor: float
    known: float
    record: Recorder
    moved: FloatArray = field(init=False)
    """(2 n,): displacement since the beginning of the phase."""
    work: Work = field(default_factory=Work)
    path: Path = field(default="direct", init=False)
    """How the load was applied."""
    _trouble: str = field(default="", init=False)
    _more: Strength | None = field(default=None, init=False)
    """What is added to the strength at the beginning of the load."""
    _begun: Work = field(default_factory=Work, init=False)
    """What was done before the present attempt at the load."""
    _most_assemblies: int = field(init=False)
    _farthest: float = field(default=math.inf, init=False)
    """m: a part that has lost its strength may be moved by more than the size of the body without any force."""
    _increment: FloatArray = field(init=False)
    _last: FloatArray = field(init=False)
    _last_length: float = field(default=0.0, init=False)
    _carried: FloatArray = field(init=False)
    """(2 n,): internal forces at the beginning of the step."""
    _inner: FloatArray = field(init=False)
    _left: float = field(default=math.inf, init=False)
    """Out of balance after the last step, over the forces."""

    def __post_init__(self) -> None:
        self.moved = np.zeros(self.fixed.shape[0])
        self._increment = np.zeros(self.fixed.shape[0])
        self._last = np.zeros(self.fixed.shape[0])
        self._carried = self.start_forces.copy()
        self._inner = np.zeros(self.fixed.shape[0])
        self._most_assemblies = self.control.largest_assemblies
        if self.body.elastic.any() or self.body.interfaces.size:
            self._farthest = float(np.ptp(self.positions, axis=0).max() + np.abs(self.target).max())

    def load(self) -> None:
        """Apply loads, weight and prescribed displacements without time.

        Where the materials cannot carry the stresses at the beginning, and the load leads to no end at once, strength
        is lowered to theirs in steps while the load is applied: first with their own flow, then with associated flow,
        which finds a balance wherever there is one. Limits do not depend on the flow: that balance is one for the
        materials as they are, too.

        Raises
        ------
        DivergedError
            No equilibrium; says how far it came and why.
        """
        begin = Begin(copied(self.state), self.positions, self.moved, self._carried.copy())
        body = self.body
        where, recorded = self._lead()
        more = missing_strength(body, begin.state) if where else None
        if more is not None:
            where, recorded = self._change_strength(begin, more, "steps")
            flowing = associated(body)
            same = np.array_equal(flowing.constants, body.constants)
            if where and not (same and np.array_equal(flowing.interface_constants, body.interface_constants)):
                self.body = flowing
                where, recorded = self._change_strength(begin, more, "associated")
                self.body = body
                if not where and self._balance(recorded) < 0:
                    where = "its whole load"
        if where:
            self._give_up(where, self._trouble)
        for done, moved in recorded:
            self.record(done, moved)
        self._last_length = 0.0

    def _change_strength(self, begin: Begin, more: Strength, path: Path) -> tuple[str, list[tuple[float, FloatArray]]]:
        """Apply the load from its beginning while ``more`` strength fades; as :meth:`_lead`."""
        self.path, self._more, self._begun = path, more, replace(self.work)
        self._most_assemblies = math.ceil(0.5 * self.control.largest_assemblies)
        self._restart(begin)
        where, recorded = self._lead()
        self._more = None
        self._most_assemblies = self.control.largest_assemblies
        return where, recorded

    def _lead(self) -> tuple[str, list[tuple[float, FloatArray]]]:
        """Apply the load; where steps on the way that were left out of balance lead to none at the end, more strictly.

        Returns where it ends without a balance, and what is to be recorded.
        """
        begin = Begin(copied(self.state), self.positions, self.moved, self.start_forces)
        where, recorded = self._approach(self.control.load_tolerance)
        if where and recorded and self.control.load_tolerance > 0.0:
            self._restart(begin)
            where, recorded = self._approach(_STRICTER * self.control.load_tolerance)
        return where, recorded

    def _restart(self, begin: Begin) -> None:
        self.state = copied(begin.state)
        self.positions, self.moved, self.start_forces = begin.positions, begin.moved, begin.forces
        self._carried = begin.forces.copy()
        self._last_length = 0.0

    def _approach(self, energy: float) -> tuple[str, list[tuple[float, FloatArray]]]:
        """Steps up to the whole load and its balance; where they end without one, and what is to be recorded."""
        done, size = 0.0, min(self.phase.load_step, self.phase.largest_load_step)
        own = self.body
        smallest = max(self.control.smallest_step, 0.0 if self._more is None else _STRENGTH_STEP)
        what = "its load" if self._more is None else "its load and of its change of strength"
        recorded: list[tuple[float, FloatArray]] = []
        while done < 1.0:
            excess = self._excess()
            if excess:
                self._trouble = excess
                return f"{done:.4g} of {what}", []
            end = 1.0 if done + size > 1.0 - 1.0e-9 else done + size
            self.body = own if self._more is None else strengthened(own, self._more, 1.0 - end)
            iterations = self._try(end - done, -math.inf, end, (end - done) * self.target, energy)
            self.body = own
            if iterations < 0:
                size = 0.5 * (end - done)
                if size < smallest:
                    return f"{done:.4g} of {what}", recorded
                continue
            self._accept(end - done)
            done = end
            recorded.append((done, self.moved))
            if iterations <= _EASY:
                size = min(2.0 * size, self.phase.largest_load_step)
        if self._left > self.control.tolerance and self._balance(recorded) < 0:
            return "its whole load", recorded
        return "", recorded

    def _balance(self, recorded: list[tuple[float, FloatArray]]) -> int:
        """Lead the end of the load to balance, without a load; iterations, -1 where there is none."""
        self._last_length = 0.0
        iterations = self._try(0.0, -math.inf, 1.0, 0.0 * self.target, 0.0)
        if iterations >= 0:
            yielded = self.state.plastic
            self._accept(0.0)
            # What has yielded in the last step of the load has yielded in it, balanced or not.
            self.state.plastic[:] |= yielded
            recorded[-1] = (1.0, self.moved)
        return iterations

    def creep(self, log_scale: float, ramp: bool, times: FloatArray) -> None:
        """Let time pass.

        Steps are taken in s = ln(1 + t/theta), in which creep under constant stress is a straight line. How far a
        step's end is from the extrapolation of the one before gives its error.

        Parameters
        ----------
        log_scale
            ln(theta/day).
        ramp
            Whether the load is applied linearly over the duration.
        times
            (m,) increasing, day, above 0: every one ends a step and is recorded, the last is the duration. Empty:
            every step is recorded, up to the duration.

        Raises
        ------
        DivergedError
            No equilibrium; says how far it came and why.
        """
        duration = self.phase.duration
        goals = times if times.size else np.array([duration])
        now, size = 0.0, _FIRST_CREEP
        for goal in goals:
            while now < goal:
                excess = self._excess()
                if excess:
                    self._give_up(f"{now:.6g} day", excess)
                # s counts from now on: t - now = (now + theta) (e^s - 1).
                log_age = np.logaddexp(math.log(now), log_scale) if now > 0.0 else log_scale
                whole = float(np.logaddexp(0.0, math.log(goal - now) - log_age))
                cut = size >= 0.999999 * whole
                length = whole if cut else size
                end = float(goal) if cut else now + math.exp(log_age + length + math.log(-math.expm1(-length)))
                log_time = math.log(end - now) if cut else log_age + length + math.log(-math.expm1(-length))
                load = end / duration if ramp else 1.0
                share = (end - now) / duration if ramp else 0.0
                iterations = self._try(length, log_time, load, share * self.target, 0.0)
                factor = 0.25
                accepted = iterations >= 0
                if accepted:
                    error = self._error(length)
                    factor = min(3.0, max(0.2, 0.9 / math.sqrt(error))) if error > 0.0 else 3.0
                    accepted = error <= 1.5
                if not accepted:
                    size = length * min(factor, 0.7)
                    self._trouble = self._trouble or "its error stays too large"
                    if size < _SMALLEST_CREEP:
                        self._give_up(f"{now:.6g} day", self._trouble)
                    continue
                self._accept(length)
                now = end
                following = min(length * factor, self.control.creep_step)
                size = max(following, size) if cut else following
                if not times.size or now >= goal:
                    self.record(now, self.moved)

    def _error(self, length: float) -> float:
        """Local error of a step over the admitted one; without a step before, that of the part that is not linear."""
        expected = self._last * (length / self._last_length) if self._last_length > 0.0 else 0.0 * self._last
        error = 0.5 * float(np.abs(self._increment - expected).max())
        size = max(float(np.abs(self.moved + self._increment).max()), _NOISE * self.known)
        return error / (self.control.time_tolerance * size) if size > 0.0 and self._last_length > 0.0 else 0.0

    def _try(self, length: float, log_time: float, load: float, target: FloatArray, energy: float) -> int:
        """Try a step, from the extrapolation of the last one or from rest; its iterations, -1 when it failed."""
        dead = self.start_forces + load * (self.end_forces - self.start_forces)
        step = Step(log_time, dead, load * self.edge_loads, self.fixed, target, self._carried)
        self._trouble = ""
        timeless = log_time == -math.inf
        rest = np.zeros(self.fixed.shape[0])
        guesses = [rest]
        if self._last_length > 0.0:
            guesses.insert(0, self._last * (length / self._last_length))
        attempts = [(guess, _BLEND, True, 1) for guess in guesses if timeless]
        attempts += [(guess, 0.0, False, 1) for guess in (guesses[-1:] if timeless else guesses)]
        if length <= self.control.blend_below:
            attempts.append((rest, _LAST_BLEND, False, _PATIENCE))
        for guess, blend, bold, patience in attempts:
            if self._granted() <= 0:
                break
            self._increment = guess.copy()
            accuracy = Accuracy(
                self.floor,
                self.control.tolerance,
                energy,
                # Rounding in the balance must not look like a change of the rate of creep.
                0 if timeless else 1,
                min(patience * self.control.iterations, self._granted()),
                self.control.modified,
                self.control.keep_ratio,
                blend,
                bold,
            )
            status, iterations, factorisations, assemblies, residual = newton_step(
                self.body,
                self.positions,
                self._increment,
                self.state,
                self.spare,
                step,
                accuracy,
                self.plan,
                self.equations,
                self._inner,
            )
            self.work.iterations += iterations
            self.work.factorisations += factorisations
            self.work.assemblies += assemblies
            if status == CONVERGED:
                if not timeless or float(np.abs(self._increment).max()) <= self._farthest:
                    self._left = residual
                    return int(iterations)
                status = SINGULAR
            self._trouble = self._words(status, residual)
        return -1

    def _accept(self, length: float) -> None:
        self.state, self.spare = self.spare, self.state
        self._carried, self._inner = self._inner, self._carried
        self.moved = self.moved + self._increment
        if self.body.updated:
            self.positions = self.positions + self._increment.reshape(-1, 2)
        self._last, self._last_length = self._increment, length
        self.work.steps += 1

    def _words(self, status: int, residual: float) -> str:
        count = self.body.triangles.shape[0]
        if status == SINGULAR:
            return "the stiffness is singular: a part is not held, or has lost its strength"
        if status < 0:
            return (
                f"Newton's method does not converge (out-of-balance {residual:.2g} of the forces): "
                "the load may be above the strength"
            )
        x, y = self.positions[self.body.triangles[status % count]].mean(axis=0)
        what = "is turned inside out" if status < count else "has a strain step without a stress"
        return f"triangle {status % count} at ({x:.4g}, {y:.4g}) m {what}"

    def _excess(self) -> str:
        """More work than is granted, in words."""
        control, why = self.control, f": {self._trouble}" if self._trouble else ""
        if self.work.steps - self._begun.steps >= control.largest_steps:
            return f"more than {control.largest_steps} steps are needed{why}"
        if self._granted() <= 0:
            return f"more than {self._most_assemblies} assemblies of the balance are needed{why}"
        return ""

    def _granted(self) -> int:
        """Assemblies that are left."""
        return self._most_assemblies - (self.work.assemblies - self._begun.assemblies)

    def _give_up(self, where: str, why: str) -> None:
        raise DivergedError(f"phase {self.phase.name!r}: no equilibrium beyond {where}: {why}")
