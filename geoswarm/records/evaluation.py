"""One forward calculation of a job, its attempts, its columns in tables, and the best of all."""

from __future__ import annotations

from datetime import datetime
from types import NoneType, UnionType
from typing import Any, Literal, TypeAlias, get_args, get_origin, get_type_hints

from geoswarm.records.record import Number, described, record
from geoswarm.records.states import EvaluationState

__all__ = ["COLUMNS", "Attempt", "Best", "Column", "Evaluation", "EvaluationSort", "Response"]

EvaluationSort: TypeAlias = Literal["generation", "objective"]
"""What evaluations are ordered by."""


@record
class Attempt:
    """One attempt at an evaluation."""

    number: int
    worker: str | None
    outcome: str = described("running, finished, the kind of failure, or why it does not count: late, overdue, stopped")
    counted: bool = described("it gave the evaluation's result")
    message: str | None
    log: str | None = described("end of what the forward model wrote")
    started_at: datetime | None
    finished_at: datetime | None


@record
class Response:
    """Calculated values of a series at its observed points, in base units."""

    x: list[Number]
    y: list[Number]


@record
class Evaluation:
    """One particle's forward calculation in one generation; ``parameters`` are the free ones."""

    generation: int
    particle: int
    state: EvaluationState
    parameters: dict[str, float]
    objective: Number
    misfits: dict[str, Number]
    responses: dict[str, Response] | None = described("only with responses=true")
    reason: str | None = described("kind of failure")
    message: str | None = described("what happened")
    attempts: int
    worker: str | None
    started_at: datetime | None
    finished_at: datetime | None
    seconds: float | None
    log: str | None = described("end of what a failed forward model wrote")


@record
class Column:
    """A column of a table of evaluations (CSV, Parquet): one field that is not a mapping."""

    name: str
    kind: type[int] | type[float] | type[str] | type[datetime]
    leading: bool = described("before the columns of parameters and misfits")


def _columns() -> tuple[Column, ...]:
    hints = get_type_hints(Evaluation)
    ahead = list(hints)[: list(hints).index("misfits")]
    kinds = [(name, _kind(hint)) for name, hint in hints.items()]
    return tuple(Column(name=name, kind=kind, leading=name in ahead) for name, kind in kinds if kind is not dict)


def _kind(hint: Any) -> Any:
    """Return the type that is in a cell: of ``float | None`` float, of a literal str, of a mapping dict."""
    (one,) = (part for part in (get_args(hint) if isinstance(hint, UnionType) else (hint,)) if part is not NoneType)
    return str if get_origin(one) is Literal else get_origin(one) or one


COLUMNS = _columns()
"""In the order of the record: a field that is added is a column of CSV and Parquet at once."""


@record
class Best:
    """The evaluation of the lowest objective; ``parameters`` are all of them, by name."""

    generation: int
    particle: int
    objective: float
    parameters: dict[str, float]
    misfits: dict[str, Number]
    responses: dict[str, Response]
