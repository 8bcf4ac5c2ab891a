"""Reports and statistics of jobs from their stored evaluations: no forward run, made once for each state of a job."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from sqlalchemy import Connection

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.identifiability import Linearisation, Samples, StatisticsError, reweight
from geoswarm.solver.identifiability.noise import known_noise, problem_noise
from geoswarm.solver.identifiability.optimum.basins import equivalent_objective
from geoswarm.solver.identifiability.stored.findings import Findings, answer_of, findings_of, join_findings
from geoswarm.solver.identifiability.stored.follow_ups import follow_up_of, same_question
from geoswarm.solver.identifiability.stored.posterior import Posterior, sample_posterior
from geoswarm.solver.identifiability.stored.slices import SurfaceView, view_surface
from geoswarm.solver.identifiability.stored.surface import ResponseSurface, fit_surface
from geoswarm.solver.identifiability.weighting import Weighting
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.answer import Answer
from geoswarm.solver.report.compared import Compared
from geoswarm.solver.report.document.build import Report, linearise_stored
from geoswarm.solver.report.jsonable import reweighted_document
from geoswarm.solver.report.record import BestFit, RunRecord
from geoswarm.solver.report.uncertainty import Uncertainty
from geoswarm.workers.cache import Cache
from geoswarm.workers.errors import JobNotFoundError
from geoswarm.workers.queries import jobs
from geoswarm.workers.queries.evaluations import get_evaluation
from geoswarm.workers.queries.follow_ups import Sees, StoredFollowUp, evaluations_in_order, follow_ups_of
from geoswarm.workers.queries.selection import (
    MOST_READ,
    MOST_VALUES,
    chosen_generations,
    counted_failures,
    read_evaluations,
    read_records,
)
from geoswarm.workers.queries.versions import recorded_versions, version_warnings
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import to_optional_datetime, unpack_array, unpack_json, unpack_responses
from geoswarm.workers.store.problems import problem_of

__all__ = ["StatisticsService", "StoredJob"]

_ABOUT = 1.5  # whole generations are read up to this multiple of what is wanted

FindRow = Callable[[Connection, str], Any]

KnownNoise: TypeAlias = Mapping[str, float] | float | None


@dataclass(frozen=True, slots=True)
class StoredJob:
    """A job read for its statistics.

    ``failed``: places of the failed runs of its search, natural values, shape (k, d); ``answer``: state and evaluations
    of the runs after it.
    """

    problem: Problem
    record: RunRecord
    samples: Samples
    failed: FloatArray
    answer: tuple[Answer, list[Evaluation]] | None = None


class StatisticsService:
    """Makes reports of jobs, keeps the latest in a cache, and shares them among threads.

    What is kept belongs to one state of a job (its state and the number of its finished evaluations), so a running job
    is always shown as it is.

    Parameters
    ----------
    store
        Where the evaluations are.
    find
        Returns the row of a job, or raises :class:`geoswarm.workers.errors.JobNotFoundError`, also for a job that the
        caller may not see. It is called before anything is taken from the cache.
    cache
        What was made already, for everybody.
    sees
        Which follow-ups the caller may see.
    """

    def __init__(self, store: Store, find: FindRow, cache: Cache, sees: Sees) -> None:
        self._store = store
        self._find = find
        self._cache = cache
        self._sees = sees

    def stored(self, job_id: str) -> StoredJob:
        """Read a job with its evaluations.

        Raises
        ------
        JobNotFoundError
        """
        return self._cache.once(
            (*self._key(job_id), "stored"), lambda: self._store.read(lambda c: _read(c, self._find(c, job_id)))
        )

    def report(
        self,
        job_id: str,
        *,
        threshold: float | None = None,
        noise: KnownNoise = None,
        posterior: bool = False,
        compared: Compared | None = None,
    ) -> Report:
        """Make the report of a job, with what its follow-ups have found.

        Parameters
        ----------
        threshold
            Objective up to which a fit is good; proposed when None.
        noise
            Known standard deviation of a reading, base units, one for all series or one each.
        posterior
            Sample the posterior, too; takes seconds.
        compared
            Another set of parameters beside the result.
        """
        job = self.stored(job_id)

        def make() -> Report:
            findings = self.findings(job_id, noise=noise)
            sample = self.posterior(job_id, noise=noise) if posterior else None
            return Report(
                job.problem,
                job.record,
                job.samples,
                threshold=threshold,
                linearisation=findings.linearisation or self._linearise_stored(job_id, job, noise),
                noise=noise,
                uncertainty=Uncertainty(findings, sample),
                compared=compared,
            )

        view = threshold, _hashable(noise), posterior, _named(compared)
        return self._cache.once((*self._key(job_id), "report", *view), make)

    def follow_ups(self, job_id: str) -> list[StoredFollowUp]:
        """Return the follow-ups of a job that ask the same question and that the caller may see, the newest first."""
        return [follow_up for follow_up in self._follow_ups(job_id) if self._sees(follow_up.owner, follow_up.id)]

    def _follow_ups(self, job_id: str) -> list[StoredFollowUp]:
        """Also those of an administrator, which an owner of the job does not see: what they found is told to both."""
        problem = self.stored(job_id).problem
        found = self._store.read(lambda connection: follow_ups_of(connection, self._find(connection, job_id)))
        return [follow_up for follow_up in found if same_question(problem, follow_up.problem)]

    def findings(self, job_id: str, *, noise: KnownNoise = None) -> Findings:
        """Return what a job has found after its search, and its follow-ups; of a follow-up, what it has found itself.

        Raises
        ------
        StatisticsError
            When the noise is wrong.
        """
        job = self.stored(job_id)

        def read(follow_up_id: str, problem: Problem, seed: int) -> Findings:
            evaluations = self._store.read(lambda connection: evaluations_in_order(connection, follow_up_id))
            return findings_of(problem, seed, evaluations, noise=noise)

        def make() -> Findings:
            if follow_up_of(job.problem) is not None:
                return read(job_id, job.problem, job.record.seed)
            further = [read(f.id, f.problem, f.seed) for f in self._follow_ups(job_id)]
            if job.answer is not None:
                further.append(answer_of(Calibration(job.problem, job.record.seed), *job.answer, noise=noise))
            return join_findings(further)

        return self._cache.once((*self._key(job_id), "findings", _hashable(noise)), make)

    def linearisation(self, job_id: str, *, noise: KnownNoise = None) -> Linearisation | None:
        """Return the sensitivities at the optimum, by a follow-up or from dense stored evaluations; else None."""
        found = self.findings(job_id, noise=noise).linearisation
        return found or self._linearise_stored(job_id, self.stored(job_id), noise)

    def posterior(self, job_id: str, *, noise: KnownNoise = None) -> Posterior:
        """Sample the posterior through a response surface of the stored evaluations; takes seconds.

        Raises
        ------
        StatisticsError
            When emcee is not installed, or there are too few evaluations for a surface.
        """
        job = self.stored(job_id)
        calibration = Calibration(job.problem, job.record.seed)
        return self._cache.once(
            (*self._key(job_id), "posterior", _hashable(noise)),
            lambda: sample_posterior(calibration, job.samples, noise=noise),
        )

    def surface(
        self, job_id: str, *, x: str | None = None, y: str | None = None, noise: KnownNoise = None
    ) -> SurfaceView:
        """Cut the response surface of the stored evaluations through the best run; no forward run.

        Parameters
        ----------
        x, y
            Parameters of the contours; the first ones when None.

        Raises
        ------
        StatisticsError
            When there are too few evaluations for a surface, or a name is not that of a free parameter.
        """
        job = self.stored(job_id)
        follow_up = follow_up_of(job.problem)
        if follow_up is not None and not follow_up.compares:
            raise StatisticsError("nothing is fitted here, so there is no objective to draw")
        calibration = Calibration(job.problem, job.record.seed)

        def make() -> tuple[ResponseSurface, Samples, FloatArray]:
            found, failed = job.samples, job.failed
            if job.answer is not None:
                after = job.answer[1]
                found = Samples.merge([found, Samples.from_evaluations(job.problem, after)])
                failed = np.concatenate([failed, *(one.parameters[None] for one in after if one.objective is None)])
            return fit_surface(calibration, found), found, failed

        surface, samples, failed = self._cache.once((*self._key(job_id), "surface"), make)
        known = problem_noise(job.problem) if noise is None else known_noise(job.problem, noise)
        lowest = float(samples.objectives[samples.best])
        limit = equivalent_objective(calibration, lowest, known, self.linearisation(job_id, noise=noise))
        return self._cache.once(
            (*self._key(job_id), "cuts", x, y, _hashable(noise)),
            lambda: view_surface(calibration, surface, samples, failed, limit, x=x, y=y),
        )

    def _linearise_stored(self, job_id: str, job: StoredJob, noise: KnownNoise) -> Linearisation | None:
        return self._cache.once(
            (*self._key(job_id), "linearisation", _hashable(noise)),
            lambda: linearise_stored(job.problem, job.samples, job.record.seed, noise=noise),
        )

    def rendered(
        self,
        job_id: str,
        form: str,
        make: Callable[[Report], bytes],
        *,
        threshold: float | None = None,
        noise: KnownNoise = None,
        posterior: bool = False,
        compared: Compared | None = None,
    ) -> bytes:
        """Render a report in a form (``html``, ``fit.svg``, ...), once for each state of the job."""
        report = self.report(job_id, threshold=threshold, noise=noise, posterior=posterior, compared=compared)
        view = threshold, _hashable(noise), posterior, _named(compared)
        return self._cache.once((*self._key(job_id), form, *view), lambda: make(report))

    def reweighted(
        self,
        job_id: str,
        *,
        weights: Mapping[str, float] | None = None,
        point_weights: Mapping[str, list[float]] | None = None,
        weighting: Weighting | Literal["by_spread"] | None = None,
        noise: Mapping[str, float] | float | None = None,
    ) -> dict[str, Any]:
        """Calculate the objectives that the stored responses have under other weights.

        Returns
        -------
        dict
            ``weights`` (weight, misfit and share of each series), ``best`` and ``best_before`` (generation, particle,
            objective under the new weights, all parameters), ``moved``, ``warnings`` and ``problem`` with the new
            weights.

        Raises
        ------
        StatisticsError, ProblemError
            When a weight or a name is wrong.
        """
        job = self.stored(job_id)
        after = reweight(
            job.problem, job.samples, weights=weights, point_weights=point_weights, weighting=weighting, noise=noise
        )
        return reweighted_document(job.problem, after)

    def _key(self, job_id: str) -> tuple[Hashable, ...]:
        """What the present state of a job and of its follow-ups is kept under."""

        def read(connection: Connection) -> tuple[Any, list[StoredFollowUp]]:
            row = self._find(connection, job_id)
            return row, follow_ups_of(connection, row)

        row, follow_ups = self._store.read(read)
        # The last two change when failures are run again.
        own = (job_id, row.name, row.state, row.evaluations, row.failed_evaluations, row.finished_at)
        return *own, *((f.id, f.name, f.state, f.evaluations) for f in follow_ups)


def _hashable(noise: KnownNoise) -> Hashable:
    return tuple(sorted(noise.items())) if isinstance(noise, Mapping) else noise


def _named(compared: Compared | None) -> Hashable:
    return None if compared is None else (compared.name, *compared.fit.parameters.items())


def _read(connection: Connection, row: Any) -> StoredJob:
    job_id: str = row.id
    stored = jobs.get_problem(connection, job_id)
    if stored is None:
        raise JobNotFoundError(job_id)
    problem = problem_of(stored.problem, stored.stopping, stored.name)
    progress = jobs.get_progress(connection, job_id)
    answer = None if progress is None else progress.answer
    samples, failures, failed = _samples(connection, row, problem, None if answer is None else answer.generation)
    after = None if answer is None else (answer, evaluations_in_order(connection, job_id, answer.generation))
    recorded = recorded_versions(row)
    record = RunRecord(
        id=job_id,
        state=row.state,
        stop_reasons=tuple(unpack_json(row.stop_reasons)),
        error=row.error,
        evaluations=row.evaluations,
        failed=row.failed_evaluations,
        generations=row.generations,
        failures=failures,
        seconds=row.run_seconds if row.started_at is not None else None,
        seed=row.seed,
        best=_best(connection, job_id, row, problem),
        records=read_records(connection, row),
        finished_at=to_optional_datetime(row.finished_at),
        versions=recorded[0],
        warnings=version_warnings(recorded),
    )
    return StoredJob(problem, record, samples, failed, after)


def _samples(
    connection: Connection, row: Any, problem: Problem, end: int | None
) -> tuple[Samples, dict[str, int], FloatArray]:
    """Successful evaluations of a search, which ends before generation ``end``; its failures and their places."""
    series = [observation.series for observation in problem.observations]
    points = sum(observation.x.size for observation in problem.observations)
    most = max(min(MOST_READ, MOST_VALUES // points), 1)
    numbers = chosen_generations(connection, row, most, sampled=problem.method.role == "sampling")
    every = _every(row, numbers, most)
    best = (row.best_generation, row.best_particle)
    failures: Counter[str] = Counter()
    failed: list[FloatArray] = []
    places: list[tuple[int, int]] = []
    parameters: list[FloatArray] = []
    objectives: list[float] = []
    misfits: list[dict[str, float]] = []
    responses: dict[str, list[FloatArray]] = {name: [] for name in series}
    for place, found in enumerate(read_evaluations(connection, row.id, numbers)):
        key = (found.generation, found.particle)
        searched = end is None or found.generation < end
        if found.state == "failed":
            failures[found.reason] += 1
            if searched:
                failed.append(unpack_array(found.parameters))
        if found.state != "finished" or not searched or (place % every and key != best):
            continue
        places.append(key)
        parameters.append(unpack_array(found.parameters))
        objectives.append(found.objective)
        misfits.append(unpack_json(found.misfits))
        calculated = unpack_responses(found.responses)
        for name in series:
            responses[name].append(calculated[name])
    left_out = 0
    if numbers is not None or every > 1:
        failures = Counter(counted_failures(connection, row.id))
        left_out = max(row.evaluations - row.failed_evaluations - len(places), 0)
    samples = Samples.from_arrays(
        problem,
        np.array(parameters),
        np.array(objectives, dtype=np.float64),
        misfits={name: np.array([m[name] for m in misfits], dtype=np.float64) for name in series},
        responses={
            o.series: np.array(responses.pop(o.series), dtype=np.float64).reshape(-1, o.x.size)
            for o in problem.observations
        },
        generations=np.array([generation for generation, _ in places], dtype=np.int64),
        particles=np.array([particle for _, particle in places], dtype=np.int64),
        failed=failures.total(),
        left_out=left_out,
    )
    return samples, dict(failures), np.array(failed).reshape(-1, samples.dimension)


def _every(row: Any, numbers: Sequence[int] | None, most: int) -> int:
    """Which part of the evaluations in chosen generations is taken: one in this number, where generations are large."""
    evaluations: int = row.evaluations
    share = 1.0 if numbers is None else len(numbers) / max(row.generations, 1)
    return max(math.ceil(share * evaluations / (_ABOUT * most)), 1)


def _best(connection: Connection, job_id: str, job: Any, problem: Problem) -> BestFit | None:
    if job.best_generation is None:
        return None
    row = get_evaluation(connection, job_id, job.best_generation, job.best_particle)
    if row is None or row.responses is None:
        return None
    return BestFit(
        row.generation,
        row.particle,
        row.objective,
        problem.values(unpack_array(row.parameters).tolist()),
        unpack_json(row.misfits),
        unpack_responses(row.responses),
    )
