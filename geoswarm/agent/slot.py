"""One slot of an agent: takes a lease, makes its runs, brings what came of it, and goes on with the next one."""

from __future__ import annotations

import logging
import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from geoswarm.agent.errors import AgentError, KeyRefusedError, LeaseEndedError, RejectedError, UnreachableError
from geoswarm.agent.runs import RunOutcome, RunProcess, Unwanted
from geoswarm.agent.server import Backoff, Lease, Server
from geoswarm.solver.forward.registry import parse_spec

if TYPE_CHECKING:
    from geoswarm.agent.agent import Agent

__all__ = ["Beats", "Slot", "brought"]

log = logging.getLogger(__name__)

LOST = "worker_lost"
LAST_TRY_SECONDS = 3.0  # to hand in while the agent ends


class Slot(threading.Thread):
    """A slot, in a thread of its own.

    Parameters
    ----------
    number
        Of it, from 0.
    process
        In which it makes its runs; it closes it.
    """

    def __init__(self, agent: Agent, number: int, process: RunProcess) -> None:
        super().__init__(name=f"slot {number}", daemon=True)
        self.number = number
        self.busy = False
        self._agent, self._process = agent, process

    def run(self) -> None:
        """Serve until the agent ends."""
        try:
            while (lease := self._agent.next_lease(self)) is not None:
                self.busy = True
                following: Lease | None = lease
                while following is not None:
                    following = self._serve(following)
                self.busy = False
        except Exception as error:  # the last handler of its thread: the agent ends, and says why
            log.exception("slot %d cannot continue", self.number)
            self._agent.fail(f"slot {self.number}: {type(error).__name__}: {error}")
        finally:
            self.busy = False
            self._process.close()

    def stop(self) -> None:
        """End what it runs, whatever it is at."""
        self._process.close()

    def _serve(self, lease: Lease) -> Lease | None:
        """Make the runs of a lease, and bring them; return the next one."""
        agent = self._agent
        shared = agent.frames.learn(lease.frame, lease.shared)
        began = time.monotonic()
        outcomes: dict[int, RunOutcome] = {}
        killed: int | None = None
        if shared is not None and not agent.ending():  # a lease that comes at the end is handed back
            with Beats(agent.server, lease.id, agent.terms.heartbeat_seconds) as beats:

                def unwanted() -> bool:
                    return beats.over is not None or agent.killing()

                wanted = [index for index, run in enumerate(lease.runs) if not run.refused]
                try:
                    made = self._process.run(lease.frame, shared, [lease.runs[i].values for i in wanted], unwanted)
                    for outcome in made:
                        outcomes[wanted[outcome.index]] = outcome
                        if agent.ending() and len(outcomes) < len(wanted):
                            break  # the rest goes to others
                except Unwanted as end:
                    killed = None if end.index is None else lease.runs[wanted[end.index]].particle
                except OSError as error:
                    log.warning("slot %d takes no run for a while: %s", self.number, error)
                    agent.pause(5.0)
            if beats.over is not None:
                log.info("lease %s: %s", lease.id[:8], beats.over)
            if beats.refused is not None:
                agent.refuse(beats.refused)
        body = brought(lease, outcomes, killed, began, shown_by(shared))
        lost = any(outcome.reason == LOST for outcome in outcomes.values())
        if lost:  # a registered model may have changed: then it is not for this machine any more
            agent.look_again()
        return self._bring(lease.id, body, more=not lost)

    def _bring(self, lease_id: str, body: dict[str, Any], *, more: bool) -> Lease | None:
        """Hand results in, however long the service does not answer; return the next lease, if ``more`` is wanted."""
        agent = self._agent
        self._keep(lease_id, body)
        backoff = Backoff()
        last: float | None = None
        while not agent.refused:
            try:
                asks = agent.wants(self) if more and not agent.ending() else None
                following = agent.server.submit(lease_id, {**body, "next": asks})
            except UnreachableError as error:
                if agent.ending():
                    last = last or time.monotonic() + LAST_TRY_SECONDS
                    if time.monotonic() > last:
                        log.warning("results of lease %s stay on disk: %s", lease_id[:8], error)
                        return None
                agent.pause(min(backoff.next(error.seconds), LAST_TRY_SECONDS if agent.ending() else 60.0))
            except (LeaseEndedError, RejectedError) as error:
                log.warning("results of lease %s are not wanted: %s", lease_id[:8], error)
                agent.outbox.drop(lease_id)
                return None
            except KeyRefusedError as error:
                agent.refuse(str(error))
            else:
                agent.outbox.drop(lease_id)
                return following
        return None

    def _keep(self, lease_id: str, body: Mapping[str, Any]) -> None:
        try:
            self._agent.outbox.save(lease_id, body)
        except OSError as error:
            log.warning("results of lease %s are kept in memory only: %s", lease_id[:8], error)


def shown_by(shared: Mapping[str, Any] | None) -> Callable[[str], str]:
    """Return what hides the folders of this machine in a message, as the section of the forward model says."""
    if shared is None:
        return lambda text: text
    try:
        return parse_spec(shared["forward_model"]).shown
    except ValidationError:
        return lambda text: text


def brought(
    lease: Lease,
    outcomes: Mapping[int, RunOutcome],
    killed: int | None,
    began: float,
    shown: Callable[[str], str],
) -> dict[str, Any]:
    """Return what is brought of a lease.

    Parameters
    ----------
    outcomes
        By the place of the run in the lease.
    killed
        Particle of the run that was killed.
    began
        When the lease was given, by this machine's monotonic clock [s].
    """
    runs: list[dict[str, Any]] = []
    for index, run in enumerate(lease.runs):
        of = {"particle": run.particle, "attempt": run.attempt}
        if run.refused:
            nothing: Sequence[float] = (0.0, 0.0, 0.0)
            runs.append(of | dict(zip(("seconds", "began", "ended"), nothing, strict=True)))
        elif index in outcomes:
            outcome = outcomes[index]
            runs.append(
                of
                | {
                    "responses": outcome.responses,
                    "reason": outcome.reason,
                    "message": None if outcome.message is None else shown(outcome.message),
                    "log": None if outcome.log is None else shown(outcome.log),
                    "seconds": outcome.seconds,
                    "began": max(outcome.began - began, 0.0),
                    "ended": max(outcome.ended - began, 0.0),
                }
            )
    return {"runs": runs, "killed": killed}


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
