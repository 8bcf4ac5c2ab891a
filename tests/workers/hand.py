"""A worker whose every step is told."""

from __future__ import annotations

from dataclasses import replace

from sqlalchemy import update

from geoswarm.solver.course import Course
from geoswarm.workers.coordinator.runtime import Runtime
from geoswarm.workers.coordinator.work import Claim, Exchange, Result, Submission
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.tables import evaluations, jobs, workers
from tests.workers.problems import course, line

LEARNING = {"kind": "particle_swarm", "particles": 6, "acceleration": "response_surface"}
"""What is stored must come back to the last bit, else such a search goes another way."""
PROBLEM = line(method=LEARNING, stopping={"max_evaluations": 60})
COURSE = course(PROBLEM)


class Hand:
    """A worker that does only what it is told."""

    def __init__(self, runtime: Runtime, job_id: str, name: str, course: Course = COURSE) -> None:
        self.runtime = runtime
        self.job_id = job_id
        self.name = name
        self.course = course
        self.claim: Claim | None = None

    def exchange(self, submission: Submission, *, want: bool = True) -> Exchange:
        answer = self.runtime.exchange(
            self.job_id, self.name, self.course, submission, live_workers=2, want=want, taken_up=True
        )
        if answer.queued:
            self.runtime.start(self.job_id, self.course.start())
            return self.exchange(submission, want=want)
        self.claim = answer.claim
        return answer

    def take(self) -> Exchange:
        return self.exchange(Submission())

    def results(self, count: int | None = None) -> Submission:
        claim = self.claim
        assert claim is not None
        triples = list(zip(claim.particles, claim.attempts, claim.positions, strict=True))[:count]
        results = [Result(p, a, self.course.calibration.evaluate(x), claim.now, claim.now + 1.0) for p, a, x in triples]
        return Submission(claim, (), claim.generation, results)

    def submit(self, count: int | None = None, *, want: bool = True) -> Exchange:
        return self.exchange(self.results(count), want=want)

    def reach_ahead(self, count: int) -> Claim | None:
        """Hand in the first results, keep the others under way, and ask for what follows them."""
        held, ready = self.claim, self.results(count)
        assert held is not None
        ahead = self.exchange(replace(ready, partial=True)).claim
        self.claim = held if ahead is None else held.followed_by(ahead, without=ready.results)
        return ahead


def runtime_for(store: Store, settings: Settings, **changes: float) -> Runtime:
    return Runtime(store, settings.model_copy(update={"local_batch_seconds": 0.0} | changes))


def pass_time(store: Store, seconds: float) -> None:
    """Let time pass for leases, workers and jobs; no sleep: a busy machine would sleep through the next lease, too."""
    for column in (evaluations.c.lease_expires_at, workers.c.seen_at, jobs.c.clock_at, jobs.c.rung_at):
        earlier = update(column.table).values({column: column - seconds})
        store.write(lambda connection, earlier=earlier: connection.execute(earlier))  # type: ignore[misc]


def finish(hand: Hand) -> None:
    hand.take()
    while hand.claim is not None:
        hand.submit()
