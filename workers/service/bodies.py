"""Meshes and displacement fields of jobs: the mesh at once, the fields by one forward run, made once and kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import Connection

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.fem.mesh.mesh import Mesh
from geoswarm.solver.forward.continuum.fields import body_of, parts_with_body, shear_strain
from geoswarm.solver.forward.continuum.model import BodyModel
from geoswarm.solver.problem import Problem
from geoswarm.workers.cache import Cache
from geoswarm.workers.errors import JobNotFoundError, NoBodyError
from geoswarm.workers.execution.sandbox import Sandbox
from geoswarm.workers.queries import jobs
from geoswarm.workers.queries.evaluations import get_evaluation
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import unpack_array, unpack_responses
from geoswarm.workers.store.problems import problem_of

__all__ = ["EvaluatedBody", "BodyService", "Fields", "Vector"]

FindRow = Callable[[Connection, str], Any]

_ALIKE = 1e-6


@dataclass(frozen=True, slots=True)
class Vector:
    """Displacement of a point in a period, (ux, uy) in m, nan where a component was not measured or calculated."""

    name: str
    point: str
    place: tuple[float, float]
    start: float
    end: float
    measured: tuple[float, float]
    calculated: tuple[float, float]


@dataclass(frozen=True, slots=True)
class EvaluatedBody:
    """The body of one evaluation.

    Parameters
    ----------
    part, parts
        The part of a combined model, and all that have a body; empty names where the model is none.
    mesh
        Undeformed, for the parameters of the evaluation; of the nominal geometry while there is none.
    generation, particle, objective, free
        Of the evaluation; None while none has succeeded and none was named.
    vectors
        At its observed points.
    """

    problem: Problem
    model: BodyModel
    part: str
    parts: tuple[str, ...]
    mesh: Mesh
    generation: int | None
    particle: int | None
    objective: float | None
    free: FloatArray | None
    vectors: tuple[Vector, ...]

    @property
    def period(self) -> tuple[str | None, str]:
        """Phases at whose ends the usual period begins and ends: that of the vectors, or from the zero of time on.

        None: it begins before the first phase.
        """
        begin, last = self.model.phase_before_zero, self.model.body.phases[-1].name
        if self.vectors:
            begin = self._ending(self.vectors[0].start) or begin
            last = self._ending(self.vectors[0].end) or last
        return begin, last

    def _ending(self, time: float) -> str | None:
        """The last phase that ends at a time after the zero of time, day."""
        ends = self.model.phase_ends.items()
        found = [name for name, end in ends if end is not None and end > 0 and abs(end - time) <= _ALIKE * end]
        return found[-1] if found else None


@dataclass(frozen=True, slots=True)
class Fields:
    """Displacements (n, 2), m, and largest shear strains at the nodes of the triangles (e, 6), of a period."""

    start: str | None
    end: str
    displacement: FloatArray
    shear_strain: FloatArray


class BodyService:
    """Shows bodies of jobs; ``find`` and ``cache`` are those of :class:`.statistics.StatisticsService`."""

    def __init__(self, store: Store, find: FindRow, cache: Cache, trials: Sandbox) -> None:
        self._store = store
        self._find = find
        self._cache = cache
        self._trials = trials

    def body(
        self, job_id: str, *, part: str | None = None, generation: int | None = None, particle: int | None = None
    ) -> EvaluatedBody:
        """Return the body of an evaluation, the best one unless another is named; no forward run.

        Raises
        ------
        JobNotFoundError
        NoBodyError
            When the forward model has none, or there is no such evaluation.
        """
        row, evaluation = self._store.read(lambda c: self._rows(c, job_id, generation, particle))
        problem = self._problem(row.id)
        parts = parts_with_body(problem.model)
        if not parts:
            raise NoBodyError(
                f"the forward model {problem.forward_model.kind} has no mesh; section and finite_element do"
            )
        chosen = parts[0] if part is None else part
        if chosen not in parts:
            raise NoBodyError(f"there is no part {chosen!r} with a mesh; there are: {', '.join(map(repr, parts))}")
        if evaluation is None and (generation is not None or particle is not None):
            raise NoBodyError(f"there is no evaluation of particle {particle} in generation {generation}")
        free = None if evaluation is None else unpack_array(evaluation.parameters)
        values = {} if free is None else problem.values(free.tolist())
        found = body_of(problem.model, chosen, values)
        assert found is not None
        model, own = found
        mesh = model.nominal if free is None else model.mesh({**model.body.nominal, **own})
        responses = {} if evaluation is None or evaluation.responses is None else unpack_responses(evaluation.responses)
        return EvaluatedBody(
            problem,
            model,
            chosen,
            parts,
            mesh,
            None if evaluation is None else evaluation.generation,
            None if evaluation is None else evaluation.particle,
            None if evaluation is None else evaluation.objective,
            free,
            _vectors(problem, model, mesh, f"{chosen}." if chosen else "", responses),
        )

    def fields(self, job_id: str, body: EvaluatedBody, start: str | None, end: str) -> Fields:
        """Return displacements and strains between the ends of two phases; runs the forward model unless it has.

        Parameters
        ----------
        body
            As :meth:`body` returned it.
        start
            None: since the beginning.

        Raises
        ------
        NoBodyError
            When there is no evaluation, a phase is unknown, or the forward run fails or exceeds its limits.
        """
        names = list(body.model.phase_ends)
        unknown = [name for name in (start, end) if name is not None and name not in names]
        if unknown:
            raise NoBodyError(f"there is no phase {unknown[0]!r}; there are: {', '.join(names)}")
        if body.free is None:
            raise NoBodyError("no evaluation has succeeded yet, so there is nothing to deform")
        free = body.free
        self._store.read(lambda c: self._find(c, job_id))
        phases = self._cache.once(
            (job_id, "fields", body.part, body.generation, body.particle),
            lambda: self._run(body.problem, free, body.part),
        )
        displacement = phases[end] - (phases[start] if start is not None else 0.0)
        return Fields(start, end, displacement, shear_strain(body.mesh, displacement))

    def _run(self, problem: Problem, free: FloatArray, part: str) -> dict[str, FloatArray]:
        made = self._trials.fields(problem, free, part)
        if made.reason is not None:
            raise NoBodyError(f"the forward run for the fields has failed ({made.reason}): {made.message}")
        return {name: values.reshape(-1, 2) for name, values in made.responses.items()}

    def _rows(
        self, connection: Connection, job_id: str, generation: int | None, particle: int | None
    ) -> tuple[Any, Any]:
        row = self._find(connection, job_id)
        if generation is None or particle is None:
            generation, particle = row.best_generation, row.best_particle
        if generation is None or particle is None:
            return row, None
        return row, get_evaluation(connection, job_id, generation, particle)

    def _problem(self, job_id: str) -> Problem:
        stored = self._store.read(lambda c: jobs.get_problem(c, job_id))
        if stored is None:
            raise JobNotFoundError(job_id)
        return problem_of(stored.problem, name=stored.name)


def _vectors(
    problem: Problem, model: BodyModel, mesh: Mesh, prefix: str, responses: dict[str, FloatArray]
) -> tuple[Vector, ...]:
    observed = {o.series.removeprefix(prefix): o for o in problem.observations if o.series.startswith(prefix)}

    def reading(series: str, x: float) -> tuple[float, float]:
        """Measured and calculated value of a series at a point, nan where there is none."""
        found = observed.get(series)
        here = np.zeros(0, dtype=np.int64) if found is None else np.flatnonzero(found.x == x)
        if found is None or not here.size:
            return np.nan, np.nan
        calculated = responses.get(found.series)
        return float(found.y[here[-1]]), np.nan if calculated is None else float(calculated[here[-1]])

    def vector(name: str, point: str, series: str, x: float, start: float, end: float) -> Vector:
        (mx, cx), (my, cy) = (reading(f"{series}.{component}", x) for component in ("ux", "uy"))
        place = mesh.nodes[mesh.points[point]].tolist()
        return Vector(name, point, (place[0], place[1]), start, end, (mx, my), (cx, cy))

    made = [
        vector(name, point, name, float(number), period.start, period.end)
        for name, period in model.body.vectors.items()
        for number, point in enumerate(period.points, start=1)
    ]
    for point in mesh.points:
        ends = [observed[s].x.max() for s in (f"{point}.ux", f"{point}.uy") if s in observed]
        if ends:
            last = float(min(ends))
            made.append(vector("last readings", point, point, last, 0.0, last))
    known = [v for v in made if np.isfinite(v.measured).any()]
    return tuple(known)
