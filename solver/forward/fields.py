"""Fields that sections of several forward models have in the same words, and what is checked of them alike."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Literal, TypeAlias

from pydantic import Field

from geoswarm.solver.sentences import SentenceError, setting

__all__ = ["Geometry", "LawSettings", "StepError", "require_stage"]

Geometry: TypeAlias = Annotated[
    Literal["updated", "fixed"],
    Field(description="updated: logarithmic strain, large deformations; fixed: small strain."),
]
LawSettings: TypeAlias = Annotated[
    dict[str, str | float | None],
    Field(max_length=50, description="Settings of the law by name, where they are not its defaults."),
]
StepError: TypeAlias = Annotated[
    float,
    Field(
        ge=1.0e-9,
        le=1.0e-2,
        description="Error of the integration aimed at, as strain, of stress over the bulk modulus; kept step by step.",
    ),
]


def require_stage(zero_at_stage: int, stages: Sequence[object]) -> None:
    """Refuse a zero of time at a stage that there is not.

    Raises
    ------
    ValueError
        It is later than the last one.
    """
    if zero_at_stage > len(stages):
        raise SentenceError(setting("zero_at_stage"), f" must be from 1 to {len(stages)}, got {zero_at_stage}")
