"""The states of jobs, evaluations and keys: everything that names a set of them takes it from here."""

from __future__ import annotations

from typing import Literal, TypeAlias, get_args

__all__ = [
    "DONE_STATES",
    "ENDED_STATES",
    "EVALUATION_STATES",
    "JOB_STATES",
    "OPEN_STATES",
    "SERVED_STATES",
    "UNDONE_STATES",
    "DeliveryState",
    "EndedState",
    "EvaluationState",
    "JobState",
    "KeyState",
]

JobState: TypeAlias = Literal["queued", "running", "paused", "finished", "failed", "cancelled"]
JOB_STATES: tuple[JobState, ...] = get_args(JobState)

EndedState: TypeAlias = Literal["finished", "failed", "cancelled"]
ENDED_STATES: tuple[EndedState, ...] = get_args(EndedState)
"""Nothing more happens by itself."""

OPEN_STATES: tuple[JobState, ...] = tuple(state for state in JOB_STATES if state not in ENDED_STATES)
"""Not ended."""

SERVED_STATES: tuple[JobState, ...] = ("queued", "running")
"""Workers take it up, or have it."""

EvaluationState: TypeAlias = Literal["pending", "running", "finished", "failed"]
EVALUATION_STATES: tuple[EvaluationState, ...] = get_args(EvaluationState)

DONE_STATES: tuple[EvaluationState, ...] = ("finished", "failed")
"""A result has been counted."""

UNDONE_STATES: tuple[EvaluationState, ...] = ("pending", "running")
"""No result has been counted yet."""

KeyState: TypeAlias = Literal["active", "expired", "revoked"]

DeliveryState: TypeAlias = Literal["waiting", "delivered", "given_up"]
"""Of what a hook is to be told."""
