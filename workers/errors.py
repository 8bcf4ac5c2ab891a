"""Everything that can go wrong in the engine.

::

    WorkersError
    ├── SettingsError               the engine cannot be configured like this
    ├── JobNotFoundError            no job has this id
    ├── EvaluationNotFoundError     the job has no such evaluation
    ├── InvalidTransitionError      the job's state does not admit the request
    ├── IdempotencyConflictError    the key was used before, with another problem
    ├── NothingToRetryError         no failed evaluation of the job can be run again
    ├── NothingLeftError            the job has ended and cannot go on
    ├── KeyNotFoundError            no API key has this id
    ├── UnknownAgentError           no agent of this key has this id
    ├── LeaseOverError              a lease has ended: what runs for it is to be killed
    ├── NotHandedOutError           agents are not given this model, or none at all
    ├── ModelsUnavailableError      a model that agents are to be given cannot be read now
    ├── HookNotFoundError           no hook has this id
    ├── HookRefusedError            a hook cannot be made like this
    ├── AttachmentNotFoundError     the job has no such file
    ├── AttachmentRefusedError      a file cannot be attached
    ├── QuotaExceededError          the owner of the API key has as much as is granted
    ├── InvalidCursorError          the cursor does not come from the listing that it was given to
    ├── NoBodyError                 the job, or its evaluation, has no mesh or no fields
    ├── NoOptimumError              the job has not found yet what a follow-up begins at
    ├── StoreUnavailableError       the database does not answer, or cannot be used
    └── BrokerUnavailableError      the broker does not answer

Messages are single lines and never hold a password.
"""

from __future__ import annotations

from collections.abc import Sequence

__all__ = [
    "AttachmentNotFoundError",
    "AttachmentRefusedError",
    "BrokerUnavailableError",
    "EvaluationNotFoundError",
    "HookNotFoundError",
    "HookRefusedError",
    "IdempotencyConflictError",
    "InvalidCursorError",
    "InvalidTransitionError",
    "JobNotFoundError",
    "NoBodyError",
    "NoOptimumError",
    "KeyNotFoundError",
    "LeaseOverError",
    "ModelsUnavailableError",
    "NotHandedOutError",
    "NothingLeftError",
    "NothingToRetryError",
    "QuotaExceededError",
    "SettingsError",
    "StoreUnavailableError",
    "UnknownAgentError",
    "WorkersError",
]


class WorkersError(Exception):
    """Base of all errors that the engine raises on purpose."""


class SettingsError(WorkersError):
    """The engine cannot be configured like this."""


class JobNotFoundError(WorkersError):
    """No job has this id."""

    def __init__(self, job_id: str) -> None:
        self.job_id = job_id
        super().__init__(f"there is no job {job_id!r}")


class EvaluationNotFoundError(WorkersError):
    """The job has no such evaluation."""

    def __init__(self, job_id: str, generation: int, particle: int) -> None:
        super().__init__(f"job {job_id} has no evaluation of particle {particle} in generation {generation}")


class KeyNotFoundError(WorkersError):
    """No API key has this id."""

    def __init__(self, key_id: str) -> None:
        self.key_id = key_id
        super().__init__(f"there is no API key {key_id!r}; 'geoswarm keys list' shows the ids")


class UnknownAgentError(WorkersError):
    """No agent of this key has this id: it has to announce itself first."""

    def __init__(self, agent_id: str) -> None:
        super().__init__(f"no agent {agent_id!r} of this key has announced itself: PUT /api/v1/agents/models")


class LeaseOverError(WorkersError):
    """A lease has ended: what runs for it is to be killed."""

    def __init__(self, lease_id: str, why: str) -> None:
        super().__init__(f"lease {lease_id!r} is not wanted: {why}")


class NotHandedOutError(WorkersError):
    """Agents are not given this model, or none at all."""


class ModelsUnavailableError(WorkersError):
    """A model that agents are to be given, or the list of them, cannot be read now."""


class HookNotFoundError(WorkersError):
    """No hook has this id."""

    def __init__(self, hook_id: str) -> None:
        self.hook_id = hook_id
        super().__init__(f"there is no hook {hook_id!r}; 'geoswarm hooks list' shows the ids")


class HookRefusedError(WorkersError):
    """A hook cannot be made like this; ``field`` is what is wrong with it."""

    def __init__(self, field: str, message: str) -> None:
        self.field = field
        super().__init__(f"{field}: {message}")


class AttachmentNotFoundError(WorkersError):
    """The job has no file with this hash."""

    def __init__(self, job_id: str, sha256: str) -> None:
        super().__init__(f"job {job_id} has no file with the SHA-256 {sha256!r}")


class AttachmentRefusedError(WorkersError):
    """A file cannot be attached; ``field`` is what is wrong with it: ``name`` or ``content``."""

    def __init__(self, field: str, message: str) -> None:
        self.field = field
        self.message = message
        super().__init__(f"{field}: {message}")


class QuotaExceededError(WorkersError):
    """The owner of the API key has as much as is granted; the message says of what."""


class InvalidTransitionError(WorkersError):
    """The job's state does not admit the request."""

    def __init__(self, action: str, state: str, accepted: Sequence[str]) -> None:
        self.action = action
        self.state = state
        self.accepted = tuple(accepted)
        super().__init__(f"cannot {action} a job that is {state}; accepted states: {', '.join(accepted)}")


class NothingLeftError(WorkersError):
    """The job has ended and cannot go on: its search is complete, or would stop at once."""


class NothingToRetryError(WorkersError):
    """No failed evaluation of the job can be run again."""

    def __init__(self, job_id: str) -> None:
        self.job_id = job_id
        super().__init__(f"job {job_id} has no failed evaluation to rerun")


class IdempotencyConflictError(WorkersError):
    """The idempotency key was used before, with another problem."""

    def __init__(self, key: str, job_id: str) -> None:
        self.key = key
        self.job_id = job_id
        super().__init__(f"idempotency key {key!r} was used for job {job_id} with another problem; use a new key")


class InvalidCursorError(WorkersError):
    """The cursor does not come from the listing that it was given to."""

    def __init__(self, cursor: str) -> None:
        self.cursor = cursor
        super().__init__(f"cursor {cursor[:80]!r} is not one that this listing returned in next_cursor")


class NoBodyError(WorkersError):
    """There is no mesh, no such evaluation, or its forward run for the fields has failed; the message says which."""


class NoOptimumError(WorkersError):
    """The job has not found yet what a follow-up begins at: a best evaluation, or the sensitivities there."""


class StoreUnavailableError(WorkersError):
    """The database does not answer, or cannot be used."""


class BrokerUnavailableError(WorkersError):
    """The broker does not answer."""
