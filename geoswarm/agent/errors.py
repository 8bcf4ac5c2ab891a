"""What can go wrong between an agent and its service.

::

    AgentError
    ├── UnreachableError    it does not answer, or cannot now: try again later
    ├── KeyRefusedError     the key is not valid, or not one of an agent
    ├── UnknownError        the service does not know this agent: announce it
    ├── LeaseEndedError     a lease is over
    └── RejectedError       what was sent is wrong for it, now and later
"""

from __future__ import annotations

__all__ = ["AgentError", "KeyRefusedError", "LeaseEndedError", "RejectedError", "UnknownError", "UnreachableError"]


class AgentError(Exception):
    """Base of what goes wrong between an agent and its service."""


class UnreachableError(AgentError):
    """It does not answer, or cannot now; ``seconds``: when to come again [s]."""

    def __init__(self, message: str, seconds: float = 0.0) -> None:
        self.seconds = seconds
        super().__init__(message)


class KeyRefusedError(AgentError):
    """The key is not valid, or not one of an agent."""


class UnknownError(AgentError):
    """The service does not know this agent."""


class LeaseEndedError(AgentError):
    """A lease is over: what runs for it is to be killed."""


class RejectedError(AgentError):
    """What was sent is wrong for it, now and later."""
