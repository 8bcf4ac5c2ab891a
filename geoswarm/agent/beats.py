"""Beats of a lease: they keep it, and tell when nobody wants it any more."""

from __future__ import annotations

import logging
import threading

from geoswarm.agent.errors import AgentError, KeyRefusedError, LeaseEndedError
from geoswarm.agent.server import Server

__all__ = ["Beats"]

log = logging.getLogger(__name__)


class Beats:
    """Beats in a thread of its own while the body of a ``with`` runs.

    A service that does not answer changes nothing: what runs goes on, and what came of it is handed in later.
    """

    def __init__(self, server: Server, lease_id: str, every: float) -> None:
        self.over: str | None = None
        """Why what runs is to be killed."""
        self.refused: str | None = None
        """Why the key of this agent is of no use any more."""
        self._server, self._lease, self._every = server, lease_id, every
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._beat, name=f"beats of {lease_id[:8]}", daemon=True)

    def __enter__(self) -> Beats:
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._ended.set()

    def _beat(self) -> None:
        while not self._ended.wait(self._every):
            try:
                self._server.beat(self._lease)
            except LeaseEndedError as error:
                self.over = str(error)
                return
            except KeyRefusedError as error:
                self.over = self.refused = str(error)
                return
            except AgentError as error:
                log.info("lease %s: no answer to a beat: %s", self._lease[:8], error)
