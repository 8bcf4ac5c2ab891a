"""The doorbell: tells workers that a job may have work. A ring may be lost or doubled, nothing depends on it."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from geoswarm.workers.settings import Settings

__all__ = ["Doorbell", "MuteDoorbell", "remote_doorbell"]


class Doorbell(Protocol):
    """How workers are woken."""

    def ring(self, job_id: str, times: int = 1, kind: str = "") -> None:
        """Wake up to ``times`` workers that run this kind of forward model (empty: any) for a job; never raises."""

    def health(self) -> str:
        """Return ``ok``, ``embedded``, or why the doorbell does not work."""

    def close(self) -> None:
        """Let go of what it holds."""


class MuteDoorbell:
    """Rings nobody: workers find the work when they look, or through a sweep."""

    def ring(self, job_id: str, times: int = 1, kind: str = "") -> None:
        """Do nothing."""

    def health(self) -> str:
        """Return ``embedded``."""
        return "embedded"

    def close(self) -> None:
        """Do nothing."""


def remote_doorbell(settings: Settings) -> Doorbell:
    """Return the doorbell of a process that runs no workers: that of the broker, or a mute one without a broker."""
    if settings.broker_url is None:
        return MuteDoorbell()
    from geoswarm.workers.hosts.celery_app import CeleryDoorbell

    return CeleryDoorbell(settings)
