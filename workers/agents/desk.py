"""Where agents are served: they announce themselves, get leases, keep them, and bring results.

Behind it is the exchange of all workers, so a history does not depend on what made its runs. What an agent holds is in
the database, so any process of the service may answer it, and a result counts only for a lease that its key was given.
"""

from __future__ import annotations

import logging
import math
import time
from collections.abc import Callable, Collection, Sequence
from typing import Any

from sqlalchemy import Connection

from geoswarm.solver.errors import ProblemError, SolverError
from geoswarm.solver.runner.evaluator import BuildError
from geoswarm.solver.system.versions import versions
from geoswarm.workers.agents.method_process import MethodProcess, begin
from geoswarm.workers.agents.prepared import Prepared, PreparedJobs, is_need, needs_of, registered_need
from geoswarm.workers.agents.side import SECONDS_TO_SPARE, Side, slot_name
from geoswarm.workers.agents.work import Announcement, BroughtRun, Grant, Terms, Wanted, evaluation_of
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Claim, Exchange, Result, Submission
from geoswarm.workers.errors import LeaseOverError, QuotaExceededError, UnknownAgentError
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.queries import agents as rows
from geoswarm.workers.queries.evaluations import renew_leases, still_wanted
from geoswarm.workers.queries.jobs import lock_job
from geoswarm.workers.queries.queue import most_urgent_job, note_served, open_needs
from geoswarm.workers.queries.workers import busy_workers, count_live
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import clean_text, pack_json, unpack_json
from geoswarm.workers.store.database import Record
from geoswarm.workers.store.problems import problem_of
from geoswarm.workers.waker import Waker

__all__ = ["AgentDesk", "OpenWork", "accepts"]

log = logging.getLogger(__name__)

OpenWork = Sequence[tuple[frozenset[str], float]]
"""What jobs with something to do need, and what an evaluation of the quickest of each takes [s]."""

TRIES = 3  # of jobs that others have emptied meanwhile
SEE_SECONDS = 1.0
UNREAD = "unreadable"
WORDS = {"paused": "its job is paused", "done": "its results came from elsewhere", "gone": "its job was deleted"}


def accepts(offers: Collection[str], work: OpenWork, seconds: float | None) -> list[str]:
    """Return those needs of open work that are offered, by an agent that runs for this time yet [s]."""
    longest = math.inf if seconds is None else seconds / SECONDS_TO_SPARE
    return [" ".join(sorted(needs)) for needs, typical in work if typical <= longest and needs.issubset(offers)]


class AgentDesk:
    """Serves the agents of one store. Safe to use from several threads.

    The caller is given by the id of its key, empty without one. Every method may raise
    :class:`geoswarm.workers.errors.StoreUnavailableError`.
    """

    def __init__(self, store: Store, waker: Waker, settings: Settings) -> None:
        self.store = store
        self.settings = settings
        self.on_work: Callable[[str, int], None] = lambda _job_id, _number: None
        """Called with the number of others that have work, in the thread that made it."""
        self._waker = waker
        self._runtime = Runtime(store, settings, foreign_methods=False)
        self._methods = MethodProcess(store, settings)
        self._jobs = PreparedJobs(store, settings)
        self._seen: dict[str, float] = {}

    def close(self) -> None:
        """Let nobody wait for a method of another package any longer."""
        self._methods.close()

    def announce(self, key_id: str, agent: Announcement) -> Terms:
        """Register an agent, or update what it offers; return its terms.

        Raises
        ------
        QuotaExceededError
            The key has as many agents as are granted.
        UnknownAgentError
            Another key has an agent of this name.
        """
        own = {registered_need(name, version) for name, version in agent.models.items()}
        if agent.versions.get("geoswarm") == versions()["geoswarm"]:  # the same numbers as everywhere
            own.update(kind for kind in agent.kinds if is_need(kind))
        offers = sorted(own)
        values = {
            "id": agent.id,
            "key_id": key_id,
            "host": clean_text(agent.host),
            "system": clean_text(agent.system),
            "pid": agent.pid,
            "slots": agent.slots,
            "versions": pack_json(dict(agent.versions)),
            "offers": pack_json(offers),
            "models": pack_json(dict(agent.models)),
        }

        def work(connection: Connection) -> None:
            known = rows.find_agent(connection, agent.id)
            if known is not None and known.key_id != key_id:
                raise UnknownAgentError(agent.id)
            others = rows.count_agents(connection, key_id, 2.0 * self.settings.lease_seconds, agent.id)
            if others >= self.settings.quota_agents:
                raise QuotaExceededError(
                    f"this key has {others} agents; at most {self.settings.quota_agents} are accepted"
                    " (GEOSWARM_QUOTA_AGENTS)"
                )
            rows.save_agent(connection, values)
            found = rows.find_agent(connection, agent.id)
            if found is not None:
                rows.show_slots(connection, found, {slot_name(agent.id, slot): slot for slot in range(agent.slots)})

        self.store.write(work)
        return Terms(self.settings.heartbeat_seconds, self.settings.lease_seconds, tuple(offers))

    def sign_off(self, key_id: str, agent_id: str) -> bool:
        """Remove an agent that ends; return whether this key has one of that name."""

        def work(connection: Connection) -> bool:
            found = rows.find_agent(connection, agent_id)
            if found is None or found.key_id != key_id:
                return False
            rows.forget_agent(connection, agent_id)
            return True

        return self.store.write(work)

    def offers(self, key_id: str, agent_id: str) -> frozenset[str]:
        """Return what an agent runs.

        Raises
        ------
        UnknownAgentError
        """
        return frozenset(unpack_json(self._agent(key_id, agent_id).offers))

    def open_work(self) -> OpenWork:
        """Return what jobs with something to do need."""
        late = (self.settings.overdue_seconds, self.settings.overdue_factor)

        def look(connection: Connection) -> tuple[Sequence[Record], Sequence[Record]]:
            return open_needs(connection, late), rows.jobs_of_unknown_needs(connection, 20)

        found, unknown = self.store.read(look)
        if unknown:
            learned = {row.id: _needs(row) for row in unknown}
            self.store.write(lambda connection: rows.set_needs(connection, learned))
        return [(frozenset(row.needs.split()), row.typical) for row in found]

    def see(self, agent_ids: Collection[str]) -> None:
        """Note that agents are there, though they hold nothing."""
        if agent_ids:
            self.store.write(lambda connection: rows.see_agents(connection, agent_ids))

    def lease(self, key_id: str, wanted: Wanted) -> Grant | None:
        """Give a slot of an agent something to do, None: there is nothing.

        Raises
        ------
        UnknownAgentError
            It has to announce itself first.
        QuotaExceededError
        """
        agent = self._agent(key_id, wanted.agent)
        self._note_seen(agent)
        offers = frozenset(unpack_json(agent.offers))
        for _ in range(TRIES):
            needs = accepts(offers, self.open_work(), wanted.seconds)
            job_id = self._most_urgent(needs, wanted) if needs else None
            prepared = None if job_id is None else self._prepared(job_id)
            if prepared is None:
                return None
            self._refuse_too_many(key_id)
            side = Side(self.settings, key_id, agent, wanted, prepared)
            answer = self._exchange(prepared, side, Submission(), want=True, taken_up=True)
            grant = side.grant()
            if grant is not None:
                self._tell(prepared, answer, grant)
                return grant
        return None

    def beat(self, key_id: str, lease_id: str) -> None:
        """Let a lease run on.

        Raises
        ------
        LeaseOverError
            Its subject is not wanted any more: what runs is to be killed.
        """

        def work(connection: Connection) -> str:
            lease = rows.find_lease(connection, lease_id, key_id)
            if lease is None or lease.ended_at is not None:
                return "it has ended"
            particles = unpack_json(lease.particles)
            state = still_wanted(connection, lease.job_id, lease.generation, particles)
            seconds = self.settings.lease_seconds
            rows.renew_lease(connection, lease_id, seconds)
            rows.see_agents(connection, [lease.agent])
            if state != "running":
                return WORDS.get(state, f"its job is {state}")
            renew_leases(connection, lease.job_id, lease.generation, particles, lease.worker, seconds)
            return ""

        why = self.store.write(work)
        if why:
            raise LeaseOverError(lease_id, why)

    def submit(
        self, key_id: str, lease_id: str, runs: Sequence[BroughtRun], killed: int | None, wanted: Wanted | None
    ) -> tuple[bool, Grant | None]:
        """Accept the results of a lease, which ends it; return whether it was still valid, and the next lease.

        What it held and is not among the runs goes to others. Results that come twice change nothing.

        Parameters
        ----------
        killed
            The particle whose run was begun, and killed.
        wanted
            What the slot asks for now; None: nothing.

        Raises
        ------
        LeaseOverError
            There is no such lease: its job is gone, or it ended long ago.
        """
        lease = self.store.read(lambda connection: rows.find_lease(connection, lease_id, key_id))
        if lease is None:
            raise LeaseOverError(lease_id, "it has ended, or its job was deleted")
        prepared = self._prepared(lease.job_id)
        if prepared is None:
            raise LeaseOverError(lease_id, "its job was deleted")
        agent = self.store.read(lambda connection: rows.find_agent(connection, lease.agent))
        claim = _claim(lease)
        results = _results(prepared, lease, claim, runs)
        asks = wanted is not None and agent is not None and wanted.agent == agent.id
        side = Side(self.settings, key_id, agent if asks else None, wanted, prepared, lease)
        goes_on = False
        if wanted is not None and agent is not None and asks:
            goes_on = lease.now - lease.taken_up_at < self.settings.slice_seconds
        if goes_on and wanted is not None and agent is not None:
            goes_on = bool(
                accepts(unpack_json(agent.offers), [(_words(prepared), side.typical or 0.0)], wanted.seconds)
            )
        answer = self._exchange(
            prepared, side, Submission(claim, (), claim.generation, results, killed), want=goes_on, taken_up=False
        )
        if side.admitted:
            for result in results:
                process_counters.run(result.evaluation.reason or "finished", result.evaluation.seconds)
                _log(prepared, lease, result)
        grant = side.grant()
        self._tell(prepared, answer, grant)
        if agent is not None:
            self._note_seen(agent)
        if grant is None and asks and wanted is not None:
            grant = self.lease(key_id, wanted)
        return side.admitted, grant

    def _exchange(
        self, prepared: Prepared, side: Side, submission: Submission, *, want: bool, taken_up: bool
    ) -> Exchange:
        """Exchange with the coordinator; a job that was not begun is begun."""

        def exchange(submission: Submission) -> Exchange:
            return self._runtime.exchange(
                prepared.id,
                side.worker,
                prepared.course,
                submission,
                live_workers=self._live_workers(),
                want=want,
                taken_up=taken_up,
                agent=side,
            )

        foreign = prepared.course.foreign_method
        with prepared.turn:
            answer = exchange(submission)
            if answer.queued and not foreign:
                begin(self._runtime, prepared, self._free_slots())
                answer = exchange(submission)
        if foreign and (answer.queued or answer.due):
            try:
                acted = self._methods.go_on(prepared, self._free_slots())
            except BuildError as error:
                acted = True
                self._runtime.give_up(prepared.id, f"BuildError: {error}")
            if not acted:
                self.store.write(lambda connection: _pass_over(connection, prepared.id))
                return answer
            with prepared.turn:
                answer = exchange(Submission())
        return answer

    def _tell(self, prepared: Prepared, answer: Exchange, grant: Grant | None) -> None:
        """Wake others where there is work for them."""
        number = answer.wakes or int(answer.left and grant is None)
        if number:
            self._waker.wake(prepared.id, number, kind=prepared.course.problem.forward_model.kind)
        if answer.left or answer.wakes:
            self.on_work(prepared.id, max(answer.wakes, 2))

    def _most_urgent(self, needs: Sequence[str], wanted: Wanted) -> str | None:
        if self._runtime.shortage() is not None:
            return None
        seconds = None if wanted.seconds is None else wanted.seconds / SECONDS_TO_SPARE
        late = (self.settings.overdue_seconds, self.settings.overdue_factor)
        row = self.store.read(lambda c: most_urgent_job(c, overdue=late, needs=needs, seconds=seconds))
        return None if row is None else str(row.id)

    def _prepared(self, job_id: str) -> Prepared | None:
        try:
            return self._jobs.get(job_id)
        except (ProblemError, SolverError) as error:
            log.warning("job %s cannot be worked on: %s", job_id, error, extra={"job": job_id})
            self._runtime.give_up(job_id, f"{type(error).__name__}: {error}")
            return None

    def _agent(self, key_id: str, agent_id: str) -> Record:
        found = self.store.read(lambda connection: rows.find_agent(connection, agent_id))
        if found is None or found.key_id != key_id:
            raise UnknownAgentError(agent_id)
        return found

    def _note_seen(self, agent: Record) -> None:
        now = time.monotonic()
        if now - self._seen.get(agent.id, -math.inf) > SEE_SECONDS:
            if len(self._seen) > 10_000:
                self._seen.clear()
            self._seen[agent.id] = now
            self.see([agent.id])

    def _refuse_too_many(self, key_id: str) -> None:
        held = self.store.read(lambda connection: rows.count_leases(connection, key_id))
        if held >= self.settings.quota_leases:
            raise QuotaExceededError(
                f"this key holds {held} leases; at most {self.settings.quota_leases} are accepted"
                " (GEOSWARM_QUOTA_LEASES)"
            )

    def _live_workers(self) -> int:
        return max(1, self.store.read(lambda connection: count_live(connection, self.settings.lease_seconds)))

    def _free_slots(self) -> int:
        busy = self.store.read(lambda connection: len(busy_workers(connection)))
        return max(1, self._live_workers() - busy)


def _pass_over(connection: Connection, job_id: str) -> None:
    """Let the jobs of others come first while the method of one acts."""
    locked = lock_job(connection, job_id, briefly=True)
    if locked is not None:
        note_served(connection, locked.row)


def _claim(lease: Record) -> Claim:
    particles, attempts = tuple(unpack_json(lease.particles)), tuple(unpack_json(lease.attempts))
    empty: Any = ()
    return Claim(lease.job_id, lease.generation, particles, attempts, empty, lease.created_at, 0.0, None)


def _results(prepared: Prepared, lease: Record, claim: Claim, runs: Sequence[BroughtRun]) -> list[Result]:
    """Results of runs that belong to a lease, the first of each."""
    held = dict(zip(claim.particles, claim.attempts, strict=True))
    refused = frozenset(unpack_json(lease.refused))
    found: dict[int, Result] = {}
    for run in runs:
        if held.get(run.particle) != run.attempt or run.particle in found:
            continue
        evaluation = evaluation_of(prepared.course.calibration, run, refused=run.particle in refused)
        began, ended = (min(lease.created_at + seconds, lease.now) for seconds in (run.began, run.ended))
        found[run.particle] = Result(run.particle, run.attempt, evaluation, began, ended, run.log)
    return list(found.values())


def _words(prepared: Prepared) -> frozenset[str]:
    return frozenset(needs_of(prepared.course.problem.forward_model).split())


def _needs(row: Record) -> str:
    """What a job needs that was submitted to an earlier version."""
    try:
        return needs_of(problem_of(row.problem).forward_model)
    except SolverError:
        return UNREAD


def _log(prepared: Prepared, lease: Record, result: Result) -> None:
    if result.evaluation.reason is not None:
        context = {
            "job": prepared.id,
            "generation": lease.generation,
            "evaluation": result.particle,
            "worker": lease.worker,
            "reason": result.evaluation.reason,
        }
        log.info("run failed: %s", result.evaluation.message, extra=context)
