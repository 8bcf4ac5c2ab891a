"""The forward model of a body: from parameters to displacements of points over time and over periods."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from geoswarm.solver.arrays import FloatArray, IntArray
from geoswarm.solver.errors import InfeasibleError, Issue, ProblemError
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.fem.results import PhaseResult
from geoswarm.solver.fem.solve import solve_phases
from geoswarm.solver.forward.base import ForwardRun, ParameterInfo, SeriesInfo
from geoswarm.solver.forward.continuum.body import BodySections
from geoswarm.solver.forward.continuum.materials import SoilSection, UserSoil
from geoswarm.solver.forward.continuum.quantity import Quantity, quantities_in, value_of
from geoswarm.solver.forward.continuum.translation import control_of, material_of, phases_of
from geoswarm.solver.forward.isolation import run_isolated
from geoswarm.solver.user_laws.law import UserLaw

__all__ = ["BodyModel", "BodyRun"]

_SAME_TIME = 1.0e-9
_CURVE_POINTS = 60
_MOST_RECORDED = 10_000_000
_COMPONENTS = (("ux", "Horizontal displacement, positive to the right"), ("uy", "Displacement upwards"))


@dataclass(frozen=True)
class BodyRun:
    """One calculation with everything that figures and files need.

    Parameters
    ----------
    mesh
        The mesh of these parameters, undeformed.
    results
        One a phase.
    offsets
        By the name of a phase, (n, 2): displacement of all nodes before those that the phase's results count, m.
    """

    mesh: Mesh
    results: tuple[PhaseResult, ...]
    offsets: dict[str, FloatArray]

    def displacements(self, phase: str) -> FloatArray:
        """Displacement of all nodes at the end of a phase since the beginning of the first one, (n, 2), m."""
        (result,) = (result for result in self.results if result.name == phase)
        return self.offsets[phase] + result.displacements


class BodyModel(ABC):
    """Displacements of a body's points. A subclass gives the mesh for parameters by name."""

    def __init__(self, body: BodySections) -> None:
        self.body = body

    @property
    @abstractmethod
    def nominal(self) -> Mesh:
        """The mesh of the nominal geometry."""

    @abstractmethod
    def mesh(self, values: Mapping[str, float]) -> Mesh:
        """The mesh for parameters by name.

        Raises
        ------
        InfeasibleError
            There is no sound mesh for them.
        """

    @cached_property
    def _quantities(self) -> dict[str, list[Quantity]]:
        users: dict[str, list[Quantity]] = {}
        for quantity in quantities_in(self.body):
            for name in sorted(quantity.expression.names):
                users.setdefault(name, []).append(quantity)
        return users

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """All names in the expressions of the section, in their order."""
        return self._parameters

    @cached_property
    def _parameters(self) -> tuple[ParameterInfo, ...]:
        used = [one.soil_law for one in self.body.materials.values() if isinstance(one, SoilSection)]
        known = {info.name: info for law in reversed(used) for info in law.parameters}
        found = []
        for name, users in self._quantities.items():
            alone = [quantity for quantity in users if quantity.expression.text == name]
            unit = alone[0].limits.unit if alone else ""
            symbol, text = name, f"Used in {', '.join(dict.fromkeys(q.expression.text for q in users))}."
            typical = None
            if name in known:
                symbol, text, typical = known[name].symbol, known[name].description, known[name].typical
            default = self.body.nominal.get(name)
            found.append(ParameterInfo(name, symbol, unit, text, default=default, typical=typical))
        return tuple(found)

    @property
    def open_parameters(self) -> bool:
        """No parameters beyond those in the expressions."""
        return False

    @cached_property
    def _durations(self) -> dict[str, float]:
        """Durations of the phases that take time and follow the zero of time; a phase has one, known beforehand."""
        zero = self._zero_phase
        found = {}
        for number, phase in enumerate(self.body.phases):
            if phase.duration is not None and number >= zero:
                if isinstance(phase.duration, Quantity):
                    text = f"'{phase.duration.expression.text}' must be a number, not a parameter"
                    raise ProblemError([Issue(f"forward_model.phases[{number}].duration", text)])
                found[phase.name] = float(phase.duration)
        return found

    @cached_property
    def _zero_phase(self) -> int:
        names = [phase.name for phase in self.body.phases]
        if self.body.zero_at_phase is not None:
            return names.index(self.body.zero_at_phase)
        kinds = [phase.kind for phase in self.body.phases]
        return kinds.index("creep") if "creep" in kinds else 0

    @property
    def phase_ends(self) -> dict[str, float | None]:
        """Time at the end of each phase, day since the zero of time; None for those long before it."""
        ends: dict[str, float | None] = {}
        time = 0.0
        for number, phase in enumerate(self.body.phases):
            time += self._durations.get(phase.name, 0.0)
            ends[phase.name] = time if number >= self._zero_phase - 1 else None
        return ends

    @property
    def phase_before_zero(self) -> str | None:
        """The phase at whose end time and displacement are zero; None: they are from the beginning on."""
        return self.body.phases[self._zero_phase - 1].name if self._zero_phase > 0 else None

    @property
    def end(self) -> float:
        """Time at the end of the last phase, day since the zero of time."""
        return float(sum(self._durations.values()))

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Displacement components of every point over time, and of the vectors over the number of their point."""
        return self._series

    @cached_property
    def _series(self) -> tuple[SeriesInfo, ...]:
        found = []
        for point in self.nominal.points:
            for component, words in _COMPONENTS:
                text = f"{words}, of point {point} since the zero of time."
                end = self.end * (1.0 + _SAME_TIME)
                found.append(SeriesInfo(f"{point}.{component}", text, "time", "day", "displacement", "m", 0.0, end))
        for name, vector in self.body.vectors.items():
            places = ", ".join(f"{number} {point}" for number, point in enumerate(vector.points, start=1))
            for component, words in _COMPONENTS:
                text = f"{words}, from day {vector.start:g} to {vector.end:g}, over the point's number: {places}."
                count = float(len(vector.points))
                found.append(
                    SeriesInfo(
                        f"{name}.{component}",
                        text,
                        "point",
                        "",
                        "displacement",
                        "m",
                        1.0,
                        count,
                        True,
                        x_names=tuple(vector.points),
                    )
                )
        return tuple(found)

    def grid(self, series: str) -> FloatArray:
        """Points at which to show a whole curve: even over time, its phases' ends included; or the numbers."""
        vector = self.body.vectors.get(series.partition(".")[0])
        if vector is not None:
            return np.arange(1.0, len(vector.points) + 1.0)
        ends = np.cumsum(list(self._durations.values())) if self._durations else np.zeros(1)
        return np.unique(np.concatenate([np.linspace(0.0, self.end, _CURVE_POINTS), ends]))

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about these values in the section's expressions and materials, or None."""
        values = {**self.body.nominal, **parameters}
        try:
            for users in self._quantities.values():
                for quantity in users:
                    if quantity.expression.names <= values.keys():
                        quantity.value(values)
            for name, section in self.body.materials.items():
                complete = {inner for q in quantities_in(section) for inner in q.expression.names} <= values.keys()
                if isinstance(section, SoilSection):
                    message = _soil_fault(section, values)
                    if message is not None:
                        return f"material {name}: {message}"
                if complete and not isinstance(section, UserSoil):  # a library is not opened before a run
                    material_of(name, section, values)
        except InfeasibleError as error:
            return str(error)
        return None

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of the given series at the given points; see the protocol.

        Raises
        ------
        ProblemError
            A series is unknown, or a point is outside it.
        """
        wanted = _Wanted(self, points)

        def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            return wanted.responses(self.calculate(parameters, wanted.phase_times, wanted.observed))

        return run_isolated(run, [law for one in self.body.user_laws if isinstance(law := one.made, UserLaw)])

    def calculate(
        self,
        parameters: Mapping[str, float],
        times: Mapping[str, tuple[float, ...]] | None = None,
        observed: tuple[str, ...] = (),
    ) -> BodyRun:
        """Calculate all phases.

        Parameters
        ----------
        parameters
            Values by name.
        times
            By the name of a creep phase, when to record displacements, day since its beginning.
        observed
            Points whose displacements to record.

        Raises
        ------
        ForwardError
            The parameters are inadmissible, or no solution was found.
        """
        values = {**self.body.nominal, **parameters}
        mesh = self.mesh(values)
        phases = list(phases_of(self.body, mesh, values, times or {}))
        results = solve_phases(
            mesh, phases, geometry="plane_strain", observe=observed, control=control_of(self.body.control)
        )
        offsets: dict[str, FloatArray] = {}
        offset = np.zeros_like(mesh.nodes)
        last = np.zeros_like(mesh.nodes)
        for phase, result in zip(phases, results, strict=True):
            if phase.reset_displacements:
                offset = offset + last
            offsets[phase.name] = offset
            last = result.displacements
        return BodyRun(mesh, tuple(results), offsets)


def _soil_fault(section: SoilSection, values: Mapping[str, float]) -> str | None:
    """What is wrong with those soil parameters that are known."""
    known = {}
    for info in section.soil_law.parameters:
        given = section.given(info.name)
        if given is None or (isinstance(given, Quantity) and not given.expression.names <= values.keys()):
            continue
        known[info.name] = value_of(given, values)
    return section.soil_law.inadmissible(known)


class _Wanted:
    """Which points and times a prepared calculation records, and where the series find theirs."""

    def __init__(self, model: BodyModel, points: Mapping[str, FloatArray]) -> None:
        self._model = model
        known = {info.name: info for info in model.series}
        moments: list[FloatArray] = []
        names: list[str] = []
        for series, x in points.items():
            _refuse(known, series, x)
            name = series.rpartition(".")[0]
            vector = model.body.vectors.get(name)
            if vector is None:
                moments.append(np.asarray(x, dtype=np.float64))
                names.append(name)
                continue
            if vector.end > model.end * (1.0 + _SAME_TIME):
                text = f"end = {vector.end:g} day: the phases end at {model.end:g} day"
                raise ProblemError([Issue(f"forward_model.vectors.{name}.end", text)])
            moments.append(np.array([vector.start, vector.end]))
            names += [vector.points[int(number) - 1] for number in x]
        self._points = dict(points)
        self.observed = tuple(dict.fromkeys(names))
        self._times = np.unique(np.concatenate(moments)) if moments else np.zeros(0)
        recorded = len(self._times) * len(self.observed)
        if recorded > _MOST_RECORDED:
            raise ProblemError(
                [
                    Issue(
                        "observations",
                        f"{len(self._times)} different times of {len(self.observed)} points are {recorded} "
                        f"displacements to record; at most {_MOST_RECORDED} are accepted",
                    )
                ]
            )
        durations = np.array(list(model._durations.values()))
        ends = np.cumsum(durations)
        self._phase_names = list(model._durations)
        phase = np.searchsorted(ends * (1.0 + _SAME_TIME) + _SAME_TIME, self._times, side="left")
        self._phase: IntArray = np.minimum(phase, max(0, len(durations) - 1))
        self._at_end = np.zeros(len(self._times), dtype=np.bool_)
        self._inside = np.zeros(len(self._times))
        if durations.size:
            self._at_end = self._times >= ends[self._phase] * (1.0 - _SAME_TIME) - _SAME_TIME
            self._inside = self._times - (ends - durations)[self._phase]
        chosen = ~self._at_end & (self._times > _SAME_TIME)
        self.phase_times = {
            name: tuple(self._inside[chosen & (self._phase == number)].tolist())
            for number, name in enumerate(self._phase_names)
        }

    def responses(self, run: BodyRun) -> dict[str, FloatArray]:
        """Values of all series."""
        nodes = [run.mesh.points[name] for name in self.observed]
        history = self._history(run, nodes)
        column = {name: number for number, name in enumerate(self.observed)}
        found = {}
        for series, x in self._points.items():
            name, _, component = series.rpartition(".")
            axis = 0 if component == "ux" else 1
            vector = self._model.body.vectors.get(name)
            if vector is None:
                found[series] = history[np.searchsorted(self._times, x), column[name], axis]
                continue
            start, end = np.searchsorted(self._times, [vector.start, vector.end])
            columns = [column[vector.points[int(number) - 1]] for number in x]
            found[series] = history[end, columns, axis] - history[start, columns, axis]
        return found

    def _history(self, run: BodyRun, nodes: list[int]) -> FloatArray:
        """Displacements of the observed points at all moments since the zero of time, (m, k, 2)."""
        zero = self._model._zero_phase
        start = np.zeros((len(nodes), 2))
        if zero > 0:
            start = run.displacements(run.results[zero - 1].name)[nodes]
        if not self._phase_names:
            end = run.displacements(run.results[-1].name)[nodes]
            return np.repeat((end - start)[None], len(self._times), axis=0)
        results = {result.name: result for result in run.results}
        history = np.zeros((len(self._times), len(nodes), 2))
        for moment, number in enumerate(self._phase.tolist()):
            name = self._phase_names[number]
            if self._times[moment] <= _SAME_TIME:
                continue
            if self._at_end[moment]:
                history[moment] = run.displacements(name)[nodes] - start
                continue
            recorded = results[name].history
            row = int(np.argmin(np.abs(recorded.times - self._inside[moment])))
            history[moment] = run.offsets[name][nodes] + recorded.displacements[row] - start
        return history


def _refuse(known: Mapping[str, SeriesInfo], series: str, x: FloatArray) -> None:
    info = known.get(series)
    if info is None:
        raise ProblemError([Issue("series", f"{series!r} is unknown; known are {', '.join(known)}")])
    assert info.x_lower is not None
    assert info.x_upper is not None
    wrong = ~((x >= info.x_lower) & (x <= info.x_upper))
    if info.x_integer:
        wrong |= x != np.round(x)
    if wrong.any():
        accepted = f"{'whole numbers ' if info.x_integer else ''}from {info.x_lower:g} to {info.x_upper:g}"
        raise ProblemError([Issue(series, f"x must be {accepted}, got {x[wrong][0]:g} {info.x_unit}")])
