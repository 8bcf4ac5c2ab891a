"""An agent's side of one exchange: how much it takes, that results count once, and the lease that it is given."""

from __future__ import annotations

import math
import secrets
from collections.abc import Mapping
from typing import Any

from sqlalchemy import Connection

from geoswarm.solver.system.versions import versions
from geoswarm.workers.agents.prepared import Prepared
from geoswarm.workers.agents.work import Grant, Run, Wanted
from geoswarm.workers.coordinator.work import Claim, Exchange, Submission
from geoswarm.workers.queries import agents as rows
from geoswarm.workers.settings import Settings
from geoswarm.workers.store.codec import pack_json, unpack_json
from geoswarm.workers.store.database import Record

__all__ = ["SECONDS_TO_SPARE", "Side", "slot_name"]

LONGEST_ANSWER = 8_000_000  # bytes of results at once, about
BYTES_A_NUMBER = 25
SECONDS_TO_SPARE = 1.25
"""Times what a run usually takes, before the agent ends."""


def slot_name(agent_id: str, slot: int) -> str:
    """Return what a slot of an agent is called among the workers."""
    return f"{agent_id}/{slot}"


class Side:
    """What one exchange does for an agent; see :class:`geoswarm.workers.coordinator.work.AgentSide`.

    Parameters
    ----------
    agent, wanted
        Whose slot asks for what; None: for nothing.
    lease
        The one that this exchange ends; None: the slot had none.
    """

    def __init__(
        self,
        settings: Settings,
        key_id: str,
        agent: Record | None,
        wanted: Wanted | None,
        prepared: Prepared,
        lease: Record | None = None,
    ) -> None:
        self._settings, self._key_id, self._agent, self._wanted = settings, key_id, agent, wanted
        self._prepared, self._lease = prepared, lease
        self.worker = lease.worker if lease is not None else slot_name(agent.id, wanted.slot)  # type: ignore[union-attr]
        self.versions: Mapping[str, str] = versions() if agent is None else unpack_json(agent.versions)
        self.admitted = False
        self.typical: float | None = None
        self._given: tuple[str, Claim] | None = None

    def most(self, typical: float | None) -> int:
        """As many as fill half a second where runs are short, and as fit into one answer."""
        wanted = self._wanted
        if wanted is None:
            return 1
        most = min(wanted.runs, LONGEST_ANSWER // (BYTES_A_NUMBER * max(self._prepared.values, 1)))
        if typical:
            longest = self._settings.chunk_seconds
            left = longest if wanted.seconds is None else min(longest, wanted.seconds / SECONDS_TO_SPARE)
            most = min(most, math.ceil(left / typical))
        return max(most, 1)

    def admits(self, connection: Connection, submission: Submission) -> bool:
        """Whether the lease was still valid; it ends now."""
        if submission.claim is None or self._lease is None:
            return True
        self.admitted = rows.end_lease(connection, self._lease.id)
        return self.admitted

    def settles(self, connection: Connection, answer: Exchange) -> None:
        """Enter the lease of what was claimed."""
        self._given = None  # a transaction may be tried again
        claim = answer.claim
        if claim is None or self._agent is None:
            return
        lease_id = secrets.token_hex(16)
        calibration = self._prepared.course.calibration
        refused = [
            particle
            for particle, position in zip(claim.particles, claim.positions, strict=True)
            if calibration.refused(position) is not None
        ]
        values: dict[str, Any] = {
            "id": lease_id,
            "job_id": claim.job_id,
            "key_id": self._key_id,
            "agent": self._agent.id,
            "worker": self.worker,
            "generation": claim.generation,
            "particles": pack_json(list(claim.particles)),
            "attempts": pack_json(list(claim.attempts)),
            "refused": pack_json(refused),
            "created_at": claim.now,
            "taken_up_at": claim.now if self._lease is None else self._lease.taken_up_at,
            "expires_at": claim.now + self._settings.lease_seconds,
        }
        rows.insert_lease(connection, values)
        self._given = lease_id, claim
        self._refused = frozenset(refused)

    def grant(self) -> Grant | None:
        """What the answer to the agent says about its lease; None if it has none."""
        if self._given is None or self._wanted is None:
            return None
        lease_id, claim = self._given
        problem, frame = self._prepared.course.problem, self._prepared.frame
        runs = tuple(
            Run(particle, attempt, {} if refused else problem.values(position.tolist()), refused)
            for particle, attempt, position, refused in (
                (p, a, x, p in self._refused)
                for p, a, x in zip(claim.particles, claim.attempts, claim.positions, strict=True)
            )
        )
        shared = None if frame in self._wanted.frames else self._prepared.shared
        return Grant(lease_id, claim.job_id, frame, shared, runs, claim.typical)
