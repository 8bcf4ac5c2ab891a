"""Reads wake-ups from Redis; what is not a message of Celery is dropped instead of ending the worker."""

from __future__ import annotations

import logging
from typing import Any

from kombu.transport import redis

__all__ = ["ForgivingChannel", "forgive"]

log = logging.getLogger(__name__)

NO_MESSAGE = (ValueError, TypeError, KeyError, AttributeError, IndexError, RecursionError)
"""What decoding raises for text that is no JSON, or JSON that is not a message."""


class ForgivingChannel(redis.Channel):
    """A channel on which a message that cannot be read is lost, as any wake-up may be: the sweep wakes again."""

    def _brpop_read(self, **options: Any) -> bool:
        try:
            return bool(super()._brpop_read(**options))  # type: ignore[no-untyped-call]  # kombu has no types
        except NO_MESSAGE as error:
            log.warning("a message in the queue cannot be read and was dropped: %s: %s", type(error).__name__, error)
            return True


def forgive() -> None:
    """Let the connections of this process to Redis use such channels, whatever their address looks like."""
    redis.Transport.Channel = ForgivingChannel
