"""What a job has found, read from the store: evaluations, generations, events."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import Any

import numpy as np
from sqlalchemy import Connection, select

from geoswarm.records.evaluation import Attempt, Evaluation, EvaluationSort
from geoswarm.records.job import Event, Generation
from geoswarm.records.progress import Progress
from geoswarm.records.record import Page
from geoswarm.records.states import ENDED_STATES, EVALUATION_STATES
from geoswarm.solver.calibration import search_space
from geoswarm.solver.problem import Problem
from geoswarm.solver.search.space import diversity
from geoswarm.workers.access.principal import Principal
from geoswarm.workers.errors import EvaluationNotFoundError
from geoswarm.workers.queries import jobs
from geoswarm.workers.queries.evaluations import get_evaluation, list_attempts
from geoswarm.workers.queries.job_list import count_by_parent
from geoswarm.workers.queries.jobs import get_problem
from geoswarm.workers.queries.listing import Filters, list_evaluations
from geoswarm.workers.queries.progress import free_workers, mean_seconds, state_counts
from geoswarm.workers.queries.selection import spaced
from geoswarm.workers.queries.views import attempt_views, evaluation_view, event_view, generation_view
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import unpack_array
from geoswarm.workers.store.problems import problem_of, unpack_problem
from geoswarm.workers.store.tables import evaluations

__all__ = ["JobRecords", "clip", "diversities"]

STREAM_ROWS = 1000
LARGEST_PAGE = 10_000
PAGE_VALUES = 400_000
"""The most calculated values with their x, of all evaluations of a page together: some 8 MB of JSON."""


def clip(limit: int) -> int:
    """Return the number of items that a page of ``limit`` has."""
    return max(1, min(limit, LARGEST_PAGE))


def rows_with_responses(limit: int, grids: Mapping[str, Sequence[float]]) -> int:
    """Return how many evaluations with responses over these grids are read at once: at most ``limit``, at least one."""
    values = 2 * sum(map(len, grids.values()))
    return max(1, min(limit, PAGE_VALUES // max(values, 1)))


class JobRecords(ABC):
    """Reads the results of jobs; access to a job is checked where its row and its frame are read."""

    store: Store
    settings: Settings
    principal: Principal

    @abstractmethod
    def _row(self, connection: Connection, job_id: str) -> Any:
        """Return the row of a job that may be seen."""

    @abstractmethod
    def _frame(self, connection: Connection, job_id: str) -> tuple[list[str], dict[str, list[float]]]:
        """Return what every evaluation of a job shares: names of the free parameters, and x of its responses."""

    def count_follow_ups(self, job_ids: Sequence[str]) -> dict[str, int]:
        """Return the number of listed follow-ups by job, for those that have any."""
        owner = self.principal.listed
        return self.store.read(lambda connection: count_by_parent(connection, job_ids, owner=owner))

    def problem(self, job_id: str) -> dict[str, Any]:
        """Return the canonical problem document of a job, under the name that the job has now."""
        return unpack_problem(*self._stored_problem(job_id))

    def parsed_problem(self, job_id: str) -> Problem:
        """Return the problem of a job.

        Raises
        ------
        JobNotFoundError
        ProblemError
            When this version cannot read it any more.
        """
        return problem_of(*self._stored_problem(job_id))

    def _stored_problem(self, job_id: str) -> tuple[str, str | None, str]:
        """Its document, its stop criteria where they were changed, and the name of the job, as they are stored."""

        def work(connection: Connection) -> Any:
            self._row(connection, job_id)
            return get_problem(connection, job_id)

        row = self.store.read(work)
        return row.problem, row.stopping, row.name

    def attempts(self, job_id: str, generation: int, particle: int) -> list[Attempt]:
        """Return the attempts at one evaluation, the current or counted one last; empty if there is no such
        evaluation."""

        def work(connection: Connection) -> list[Attempt]:
            self._row(connection, job_id)
            return attempt_views(
                get_evaluation(connection, job_id, generation, particle),
                list_attempts(connection, job_id, generation, particle),
            )

        return self.store.read(work)

    def best(self, job_id: str) -> Evaluation | None:
        """Return the best evaluation so far with its responses; None while none has succeeded."""

        def work(connection: Connection) -> Evaluation | None:
            job = self._row(connection, job_id)
            if job.best_generation is None:
                return None
            row = get_evaluation(connection, job_id, job.best_generation, job.best_particle)
            names, grids = self._frame(connection, job_id)
            return evaluation_view(row, names, grids)

        return self.store.read(work)

    def progress(self, job_id: str) -> Progress:
        """Return how far the generation is that runs now, every finished run counted."""

        def work(connection: Connection) -> Progress:
            job = self._row(connection, job_id)
            here = state_counts(connection, job_id, job.generations)
            number = {state: here[state].number if state in here else 0 for state in EVALUATION_STATES}
            best = [found.objective for found in here.values() if found.objective is not None]
            ended = job.evaluations + number["finished"] + number["failed"]
            each = mean_seconds(connection, job_id, job.generations)
            workers = free_workers(connection, self.settings.lease_seconds, job_id=job_id)
            most = job.max_evaluations
            if job.search_evaluations is not None:
                most = min(job.search_evaluations + job.answer_evaluations, most or math.inf)
            known = each is not None and most is not None and job.state not in ENDED_STATES
            left = max(most - ended, 0) * each / max(workers, 1) if known else None
            return Progress(
                generation=job.generations,
                **number,
                objective=min([*best, *([] if job.objective is None else [job.objective])], default=None),
                evaluations=ended,
                search_evaluations=job.search_evaluations,
                answer_evaluations=job.answer_evaluations,
                seconds=each,
                workers=workers,
                seconds_left=left,
            )

        return self.store.read(work)

    def evaluation(self, job_id: str, generation: int, particle: int) -> Evaluation:
        """Return one evaluation with its responses.

        Raises
        ------
        EvaluationNotFoundError
        """

        def work(connection: Connection) -> Evaluation:
            names, grids = self._frame(connection, job_id)
            row = get_evaluation(connection, job_id, generation, particle)
            if row is None:
                raise EvaluationNotFoundError(job_id, generation, particle)
            return evaluation_view(row, names, grids)

        return self.store.read(work)

    def evaluations(
        self,
        job_id: str,
        *,
        generation: int | None = None,
        state: str | None = None,
        max_objective: float | None = None,
        limit: int = 100,
        cursor: str | None = None,
        responses: bool = False,
        sort: EvaluationSort = "generation",
    ) -> Page[Evaluation]:
        """Return evaluations in the order of ``sort``; with long responses fewer than ``limit`` a page.

        Raises
        ------
        InvalidCursorError
        """
        filters = Filters(generation, state, max_objective, sort)
        after = None if cursor is None else filters.after(cursor)

        def work(connection: Connection) -> Page[Evaluation]:
            names, grids = self._frame(connection, job_id)
            most = rows_with_responses(clip(limit), grids) if responses else clip(limit)
            rows = list_evaluations(connection, job_id, filters, after=after, limit=most + 1, responses=responses)
            views = [evaluation_view(row, names, grids if responses else None) for row in rows[:most]]
            last = views[-1] if len(rows) > most else None
            following = None if last is None else filters.cursor(last)
            return Page(items=views, next_cursor=following)

        return self.store.read(work)

    def iterate_evaluations(
        self,
        job_id: str,
        *,
        generation: int | None = None,
        state: str | None = None,
        max_objective: float | None = None,
        responses: bool = False,
    ) -> Iterator[Evaluation]:
        """Stream evaluations ordered by (generation, particle), in short transactions and flat memory."""
        names, grids = self.store.read(lambda connection: self._frame(connection, job_id))
        filters = Filters(generation, state, max_objective)
        most = rows_with_responses(STREAM_ROWS, grids) if responses else STREAM_ROWS

        def stream() -> Iterator[Evaluation]:
            after: tuple[int, int] | None = None
            while True:
                rows = self.store.read(
                    partial(
                        list_evaluations,
                        job_id=job_id,
                        filters=filters,
                        after=after,
                        limit=most,
                        responses=responses,
                    )
                )
                for row in rows:
                    yield evaluation_view(row, names, grids if responses else None)
                if len(rows) < most:
                    return
                after = (rows[-1].generation, rows[-1].particle)

        return stream()

    def generations(
        self,
        job_id: str,
        *,
        after: int = -1,
        limit: int = 1000,
        points: int | None = None,
        diversity: bool = False,
    ) -> list[Generation]:
        """Return finished generations with a number above ``after``, in order.

        With ``points`` at most this number of all, evenly spaced, with the first and the last one; ``diversity`` reads
        all their runs.
        """

        def work(connection: Connection) -> list[Generation]:
            total = self._row(connection, job_id).generations
            numbers = None if points is None or total <= points else spaced(total, points)
            rows = jobs.list_generations(connection, job_id, after=after, limit=clip(limit), numbers=numbers)
            scattered = diversities(connection, job_id, rows[0].number, rows[-1].number) if diversity and rows else {}
            return [generation_view(row, scattered.get(row.number)) for row in rows]

        return self.store.read(work)

    def events(self, job_id: str, *, after: int = 0, limit: int = 500) -> list[Event]:
        """Return events with an id above ``after``, in order."""

        def work(connection: Connection) -> list[Event]:
            self._row(connection, job_id)
            rows = jobs.list_events(connection, job_id, after=after, limit=clip(limit))
            return [event_view(row) for row in rows]

        return self.store.read(work)


def diversities(connection: Connection, job_id: str, first: int, last: int) -> dict[int, float]:
    """Return the diversity of generations ``first`` to ``last`` by number.

    See :mod:`geoswarm.solver.search.space`.
    """
    row = get_problem(connection, job_id)
    if row is None:
        return {}
    space = search_space(problem_of(row.problem))
    statement = (
        select(evaluations.c.generation, evaluations.c.parameters)
        .where(evaluations.c.job_id == job_id, evaluations.c.generation.between(first, last))
        .order_by(evaluations.c.generation, evaluations.c.particle)
    )
    positions: dict[int, list[bytes]] = {}
    for evaluation in connection.execute(statement):
        positions.setdefault(evaluation.generation, []).append(evaluation.parameters)
    return {
        number: diversity(space.to_unit(np.array([unpack_array(values) for values in generation])))
        for number, generation in positions.items()
    }
