"""The waker: notifies workers that a job may have work. A wake-up may be lost or doubled, nothing depends on it."""

from __future__ import annotations

from typing import Protocol

__all__ = ["Waker", "NoWaker"]


class Waker(Protocol):
    """How workers are woken."""

    def wake(self, job_id: str, times: int = 1, kind: str = "") -> None:
        """Wake up to ``times`` workers that run this kind of forward model (empty: any) for a job; never raises."""

    def health(self) -> str:
        """Return ``ok``, ``embedded``, or why the waker does not work."""

    def close(self) -> None:
        """Let go of what it holds."""


class NoWaker:
    """Notifies no worker: workers find the work when they look, or through a sweep."""

    def wake(self, job_id: str, times: int = 1, kind: str = "") -> None:
        """Do nothing."""

    def health(self) -> str:
        """Return ``embedded``."""
        return "embedded"

    def close(self) -> None:
        """Do nothing."""
