"""Turns rows into records."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from typing import Any

import numpy as np

from geoswarm.records.evaluation import COLUMNS, Attempt, Evaluation, Response
from geoswarm.records.job import Event, Generation, Job, SearchBest
from geoswarm.records.record import Number
from geoswarm.records.service import AgentSlot, Worker
from geoswarm.records.statistics import SeriesShare
from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.progress.result import alike_warning
from geoswarm.workers.queries.versions import recorded_versions, version_warnings
from geoswarm.workers.store.codec import to_datetime, to_optional_datetime, unpack_array, unpack_json, unpack_responses
from geoswarm.workers.store.database import Record

__all__ = ["attempt_views", "evaluation_view", "event_view", "generation_view", "job_view", "worker_view"]


def job_view(row: Record, gap: float) -> Job:
    """Show a job; silence of more than ``gap`` [s] is not running time."""
    seconds = None if row.started_at is None else row.run_seconds
    if row.state == "running":
        seconds = row.run_seconds + min(max(row.now - row.clock_at, 0.0), gap)
    recorded = recorded_versions(row)
    conclusion = {} if row.conclusion is None else unpack_json(row.conclusion)
    intervals = conclusion.get("intervals")
    alike = alike_warning(unpack_json(row.failures).get("alike", -1))
    return Job(
        id=row.id,
        name=row.name,
        state=row.state,
        forward_model=row.forward_model,
        method=row.method,
        stop_reasons=unpack_json(row.stop_reasons),
        objective=row.objective,
        parameters=None if row.parameters is None else unpack_json(row.parameters),
        at_bounds=None if row.at_bounds is None else unpack_json(row.at_bounds),
        intervals=intervals and {name: ends and (ends[0], ends[1]) for name, ends in intervals.items()},
        verdicts=conclusion.get("verdicts"),
        verdict_words=conclusion.get("verdict_words"),
        fit=conclusion.get("fit"),
        shares=conclusion.get("shares") and [SeriesShare(**share) for share in conclusion["shares"]],
        search_best=conclusion.get("search_best") and SearchBest(**conclusion["search_best"]),
        evaluations=row.evaluations,
        search_evaluations=row.search_evaluations,
        answer_evaluations=row.answer_evaluations,
        generations=row.generations,
        failed_evaluations=row.failed_evaluations,
        created_at=to_datetime(row.created_at),
        started_at=to_optional_datetime(row.started_at),
        finished_at=to_optional_datetime(row.finished_at),
        seconds=seconds,
        error=row.error,
        seed=row.seed,
        free_parameters=unpack_json(row.free_parameters),
        max_evaluations=row.max_evaluations,
        priority=row.priority,
        retrying=row.retry_to is not None,
        owner=row.owner,
        parent=row.parent,
        tags=row.tags.split("\n")[1:-1],
        note=row._mapping.get("note") or None,  # lists leave it out
        last_event=row.last_event or 0,
        versions=recorded[0],
        warnings=[*([] if alike is None else [alike]), *version_warnings(recorded)],
    )


_AS_STORED = tuple(column.name for column in COLUMNS if column.kind is not datetime)
"""Columns of an evaluation that are shown as they are in its row."""
_TIMES = tuple(column.name for column in COLUMNS if column.kind is datetime)


def evaluation_view(row: Record, names: Sequence[str], grids: Mapping[str, list[Any]] | None = None) -> Evaluation:
    """Show an evaluation, with responses over ``grids`` when these are given and it has any."""
    responses = None
    if grids is not None and row.responses is not None:
        calculated = unpack_responses(row.responses)
        responses = {series: Response(x=grids[series], y=_numbers(y)) for series, y in calculated.items()}
    own: dict[str, Any] = {name: getattr(row, name) for name in _AS_STORED}
    own |= {name: to_optional_datetime(getattr(row, name)) for name in _TIMES}
    return Evaluation(
        parameters=dict(zip(names, unpack_array(row.parameters).tolist(), strict=True)),
        misfits={} if row.misfits is None else unpack_json(row.misfits),
        responses=responses,
        **own,
    )


def _numbers(values: FloatArray) -> list[Number]:
    listed: list[Any] = values.tolist()
    if np.isfinite(values).all():
        return listed
    return [value if math.isfinite(value) else None for value in listed]


def attempt_views(evaluation: Record | None, tries: Sequence[Record]) -> list[Attempt]:
    """Show the tries at an evaluation in order, the one under way or counted last."""
    views = [
        Attempt(
            number=row.number,
            worker=row.worker,
            outcome=row.outcome,
            counted=False,
            message=row.message,
            log=row.log,
            started_at=to_optional_datetime(row.started_at),
            finished_at=to_optional_datetime(row.finished_at),
        )
        for row in tries
    ]
    if evaluation is not None and evaluation.state != "pending":
        failed = evaluation.state == "failed"
        others = {row.number for row in tries}  # one given to two workers may be counted by its first number
        numbers = (number for number in range(evaluation.attempts, 0, -1) if number not in others)
        last = Attempt(
            number=next(numbers, evaluation.attempts),
            worker=evaluation.worker,
            outcome=evaluation.reason if failed else evaluation.state,
            counted=evaluation.state != "running",
            message=evaluation.message if failed else None,
            log=evaluation.log if failed else None,
            started_at=to_optional_datetime(evaluation.started_at),
            finished_at=to_optional_datetime(evaluation.finished_at),
        )
        views.append(last)
    return views


def generation_view(row: Record, diversity: float | None = None) -> Generation:
    """Show a finished generation."""
    return Generation(
        number=row.number,
        evaluations=row.evaluations,
        failed=row.failed,
        best_objective=row.best_objective,
        objective=row.objective,
        parameters=None if row.parameters is None else unpack_json(row.parameters),
        created_at=to_datetime(row.created_at),
        finished_at=to_datetime(row.finished_at),
        diversity=diversity,
    )


def event_view(row: Record) -> Event:
    """Show an event."""
    return Event(id=row.id, kind=row.kind, data=unpack_json(row.data))


def worker_view(row: Record, work: Record | None, *, visible: bool = True) -> Worker:
    """Show a worker and what it has claimed, None: nothing; ``visible``: the viewer may see that job."""
    return Worker(
        id=row.id,
        host=row.host,
        pid=row.pid,
        engine=row.engine,
        state="lost" if row.lost else "idle" if work is None else "busy",
        job=work.job_id if work is not None and visible else None,
        started_at=to_datetime(row.started_at),
        seen_at=to_datetime(row.seen_at),
        generation=work.generation if work is not None and visible else None,
        evaluations=None if work is None else work.claimed,
        busy_since=None if work is None else to_optional_datetime(work.since),
        agent=_agent_slot(row),
    )


def _agent_slot(row: Record) -> AgentSlot | None:
    if row.agent is None or row.slots is None:
        return None
    return AgentSlot(
        id=row.agent,
        slots=row.slots,
        system=row.system,
        version=unpack_json(row.versions).get("geoswarm", ""),
        models=unpack_json(row.models),
    )
