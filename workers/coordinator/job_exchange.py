"""One exchange between workers and the coordinator, inside its transaction."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from sqlalchemy import Connection

from geoswarm.solver.course import Course
from geoswarm.solver.methods.widths import Situation
from geoswarm.solver.runs.runlog import RunLog
from geoswarm.workers.coordinator.ending import changed_criteria
from geoswarm.workers.coordinator.generation_rows import Cell, GenerationRows, load_generation, reuse, write_new
from geoswarm.workers.coordinator.hand_out import HandOut
from geoswarm.workers.coordinator.retry import finish_retry, open_retries
from geoswarm.workers.coordinator.tries import give_back, record_result
from geoswarm.workers.coordinator.work import Asked, Claim, Exchange, Result, Sizing, Submission, free_slots
from geoswarm.workers.queries.evaluations import list_results
from geoswarm.workers.queries.jobs import LockedJob, lock_job, save_job
from geoswarm.workers.queries.queue import note_served, note_typical
from geoswarm.workers.queries.versions import note_versions
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.job import (
    DispatchGeneration,
    GenerationJoined,
    JobBroken,
    JobStatus,
    Joined,
    Transition,
    apply,
)
from geoswarm.workers.store.codec import unpack_array

__all__ = ["Closed", "Due", "JobExchange"]

CHUNK = 64  # unclaimed evaluations that are read at first for a worker that takes several
ENOUGH = 32  # results of generation 0 that tell what a run costs


@dataclass(frozen=True, slots=True)
class Due:
    """A complete generation to be closed with no transaction open, as of a search that learns from all runs."""

    job: JobStatus
    joined: GenerationJoined
    stopping: str | None = None


@dataclass(frozen=True, slots=True)
class Closed:
    """Outcome of the state machine; valid if the job is still in that state, with these stop criteria.

    ``conclusion``: what the job says of its parameters, where it ends.
    """

    generation: int
    transition: Transition
    stopping: str | None = None
    conclusion: Mapping[str, Any] | None = None


class JobExchange:
    """Accepts the results of workers, advances the job when its generation is complete, and hands out the next claims.

    Parameters
    ----------
    log
        What the search learns from, where it does.
    """

    def __init__(
        self, settings: Settings, log: RunLog | None, connection: Connection, locked: LockedJob, course: Course
    ) -> None:
        self.settings = settings
        self.sizing = Sizing(
            settings.cheap_seconds, settings.local_batch_seconds, settings.single_seconds, settings.chunk_seconds
        )
        self.log = log
        self.connection = connection
        self.locked = locked
        self.course = course
        self.failures = course.problem.failures
        self.state: str = locked.row.state
        self.typical: float | None = locked.row.typical_seconds
        self._job: JobStatus | None = None
        self.fatal: str | None = None
        self.due: Due | None = None
        self._saved = False

    @property
    def job(self) -> JobStatus | None:
        """State of the job in the state machine, None before its start; read on first use."""
        if self._job is None and self.locked.row.progress is not None:
            self._job = self.locked.job()
        return self._job

    def alone(self, asked: Sequence[Asked]) -> bool:
        """Whether exchanges must come one by one: failures are being rerun, or whole generations are handed in."""
        again = self.locked.row.retry_to is not None
        return len(asked) > 1 and (again or any(one.submission.local_batches for one in asked))

    def run(self, asked: Sequence[Asked], closed: Closed | None = None) -> list[Exchange]:
        """Run the exchange for workers in this order; see
        :meth:`geoswarm.workers.coordinator.runtime.Runtime.exchange`.

        It is as if each came by itself: all results first, then all claims. When :attr:`due` is set afterwards, a
        generation has to be closed: do that and come again with ``closed``.
        """
        if self.state == "queued":
            return [Exchange(queued=True) for _ in asked]
        if self.locked.row.retry_to is not None:
            return [self._retry(asked[0])]
        generation = self.locked.row.generation
        rows: GenerationRows | None = None
        if generation >= 0 and (
            self.state == "running"
            or any(one.submission.generation == generation or one.submission.local_batches for one in asked)
        ):
            rows = self._load(generation, asked)
        dispatched = False
        if asked[0].submission.local_batches:
            rows, dispatched = self._take_whole(rows, asked[0])
        else:
            for one in asked:
                if one.submission.claim is not None:
                    self._take_in(rows, one, one.submission.generation, one.submission.results)
        if self.fatal is not None and self.state == "running" and self.job is not None:
            self._save([apply(self.job, JobBroken(self.fatal))], [])
        while self.state == "running" and rows is not None and rows.complete:
            rows = self._advance(rows, asked, closed)
            dispatched = rows is not None
            if self.due is not None:
                return [Exchange() for _ in asked]
        if self.state != "running" or rows is None:
            if rows is not None:
                rows.write(self.connection)
            return [Exchange() for _ in asked]
        return self._hand_out(rows, asked, dispatched)

    def _retry(self, asked: Asked) -> Exchange:
        """Do the same for a job whose failures are run again: whatever generation they are of, none is advanced."""
        submission = asked.submission
        if submission.claim is not None:
            number, results = (
                (submission.local_batches[0].generation, submission.local_batches[0].results)
                if submission.local_batches
                else (submission.generation, submission.results)
            )
            self._take_in(None, asked, number, results)
        if self.state != "running":
            return Exchange()
        generation, under_way = open_retries(self.connection, self.locked)
        if generation is None:
            if not under_way:
                finish_retry(self.connection, self.locked, self.course.problem, gap=self.settings.lease_seconds)
                return Exchange(left=self.locked.row.retry_to == "running")
            return Exchange()
        rows = self._load(generation, [replace(asked, submission=Submission())])
        want = asked.want and not submission.partial
        return self._hand_out(rows, [replace(asked, submission=Submission(), want=want)], False)[0]

    def _take_whole(self, rows: GenerationRows | None, asked: Asked) -> tuple[GenerationRows | None, bool]:
        """Apply generations that the worker ran alone, if the job still stands where it did when they began."""
        submission, worker = asked.submission, asked.worker
        local_batches = submission.local_batches
        valid = (
            rows is not None
            and self.state == "running"
            and rows.generation == local_batches[0].generation
            and submission.claim is not None
            and submission.claim.stopping == self.locked.row.stopping
            and rows.undone == rows.size == len(rows.held_by(worker))
        )
        if not valid or rows is None:
            # Paused, cancelled, taken over by others, or to be ended otherwise: the first generation is as good as any
            # worker's result of it, the following ones will come out the same again.
            self._take_in(rows, asked, local_batches[0].generation, local_batches[0].results)
            return rows, False
        self._record(rows, worker, local_batches[0].results)
        rows.write(self.connection)
        following = []
        for before, whole_generation in itertools.pairwise(local_batches):
            following.append(_dispatched(self.locked.id, before.transition))
            self._record(following[-1], worker, whole_generation.results)
        write_new(self.connection, following)
        transitions = [whole_generation.transition for whole_generation in local_batches]
        final = transitions[-1]
        next_rows = None
        if final.job.state == "running":
            next_rows = _dispatched(self.locked.id, final)
            self._record(next_rows, worker, submission.results)
            if self.fatal is not None:
                transitions.append(apply(final.job, JobBroken(self.fatal)))
        last = [r.evaluation for r in local_batches[-1].results]
        self.typical = _typical([(e.seconds, e.reason) for e in last], self.typical)
        self._save(transitions, [whole_generation.finished_at for whole_generation in local_batches])
        return next_rows, next_rows is not None

    def _take_in(self, rows: GenerationRows | None, asked: Asked, generation: int, results: Sequence[Result]) -> None:
        """Record results, and give back what was claimed with them but not finished."""
        submission, claim = asked.submission, asked.submission.claim
        if claim is None:
            return
        late = rows is None or rows.generation != generation
        own = self._load(generation, [asked]) if late or rows is None else rows
        if own.size == 0:
            return  # of a generation that was begun in a local batch which does not count
        self._record(own, asked.worker, results)
        handed_in = {result.particle for result in results}
        for particle, attempt in zip(claim.particles, claim.attempts, strict=True):
            if not submission.partial and particle not in handed_in and generation == claim.generation:
                killed = particle == submission.killed
                give_back(own, own.cell(particle), asked.worker, attempt, self.locked.now, killed=killed)
        if late:
            own.write(self.connection)

    def _record(self, rows: GenerationRows, worker: str, results: Sequence[Result]) -> None:
        for result in results:
            fatal = record_result(self.connection, rows, result, worker, self.failures)
            self.fatal = self.fatal or fatal

    def _advance(self, rows: GenerationRows, asked: Sequence[Asked], closed: Closed | None) -> GenerationRows | None:
        """Close a complete generation; return the next one's rows, None when the job has ended or this is due."""
        rows.write(self.connection)
        counted = list_results(self.connection, self.locked.id, rows.generation)
        stopping, conclusion = self.locked.row.stopping, None
        if closed is not None and closed.generation == rows.generation and closed.stopping == stopping:
            transition, conclusion = closed.transition, closed.conclusion
        elif self.job is None:
            raise RuntimeError(f"job {self.locked.id} has evaluations but no progress")
        else:
            results = [Joined(row.objective, row.reason, row.message, bool(row.kept)) for row in counted]
            seconds = self.locked.run_seconds(self.settings.lease_seconds)
            event = GenerationJoined(
                rows.generation,
                results,
                seconds,
                criteria=changed_criteria(stopping),
                situation=self._situation([row.seconds or 0.0 for row in counted]),
            )
            if self._learns() or self.course.foreign_method:  # may take its time: the database must not wait
                self.due = Due(self.job, event, stopping)
                return None
            transition = apply(self.job, event, self.course)
        self.typical = _typical([(row.seconds, row.reason) for row in counted], self.typical)
        self._save([transition], [], conclusion)
        if transition.job.state != "running":
            return None
        return self._following(transition, asked)

    def _following(self, transition: Transition, asked: Sequence[Asked]) -> GenerationRows:
        """Return the rows of the generation under evaluation; write those of one that is begun ahead of it."""
        dispatched = {rows.generation: rows for rows in _all_dispatched(self.locked.id, transition)}
        for rows in dispatched.values():
            if self._worth_reuse(rows):
                reuse(self.connection, rows)
        generation = transition.job.generation
        following = dispatched.pop(generation, None)
        for rows in dispatched.values():
            rows.write(self.connection)
        return following or self._load(generation, asked)

    def _load(self, generation: int, asked: Sequence[Asked]) -> GenerationRows:
        """Read of a generation what these workers bring and hold, and what they may get."""
        brought = [particle for one in asked for particle in one.submission.particles()]
        singly = self.typical is None or self.typical > self.sizing.single_seconds
        return load_generation(
            self.connection,
            self.locked.id,
            generation,
            particles=brought,
            workers={one.worker for one in asked},
            most=len(asked) * (1 if singly else CHUNK),
        )

    def _situation(self, lengths: Sequence[float]) -> Situation | None:
        """What decides on the size of the next generation, where that is left to the engine."""
        if not self.course.problem.method.follows_slots:
            return None
        model = self.course.problem.forward_model
        return Situation(free_slots(self.connection, self.settings, model, self.locked.id), lengths)

    def _worth_reuse(self, rows: GenerationRows) -> bool:
        """Whether to look for earlier runs of the same parameters: where there are some, or a run costs more."""
        if self.log is not None:
            return self.log.repeats(np.array([unpack_array(cell.parameters) for cell in rows.cells.values()]))
        return self.typical is not None and self.typical > self.settings.cheap_seconds

    def _save(
        self,
        transitions: Sequence[Transition],
        finished_at: Sequence[float],
        conclusion: Mapping[str, Any] | None = None,
    ) -> None:
        if self._saved and (again := lock_job(self.connection, self.locked.id, briefly=True)) is not None:
            self.locked = again  # a generation of known runs only is closed at once: what was locked is the row before
        self._saved = True
        save_job(
            self.connection,
            self.locked,
            transitions,
            gap=self.settings.lease_seconds,
            typical_seconds=self.typical,
            finished_at=finished_at,
            problem=self.course.problem,
            conclusion=conclusion,
        )
        self._job = transitions[-1].job
        self.state = self._job.state

    def _hand_out(self, rows: GenerationRows, asked: Sequence[Asked], dispatched: bool) -> list[Exchange]:
        """Answer each with a claim, if there is one to be had, and write the generation."""
        if self.typical is None:  # generation 0 teaches what a run costs while it goes on
            rows.write(self.connection)
            counted = list_results(self.connection, self.locked.id, rows.generation, ENOUGH)
            self.typical = _typical([(row.seconds, row.reason) for row in counted], None)
            if len(counted) == ENOUGH and self.typical is not None:  # further exchanges need not ask again
                note_typical(self.connection, self.locked.id, self.typical)
        out = [rows, *self._ahead(rows, asked)]
        hand_outs = [HandOut(one, self.locked.now, self.settings.lease_seconds) for one in out]
        # A worker that dispatches wakes as many as there are chunks: the last one sees what is left.
        answers = [self._answer(hand_outs, one, dispatched and one is asked[-1]) for one in asked]
        for one in out:
            one.write(self.connection)
        given = [one for one, answer in zip(asked, answers, strict=True) if answer.claim is not None]
        if given:
            calculating = {one.worker: None if one.agent is None else one.agent.versions for one in given}
            note_versions(self.connection, self.locked, calculating)
        if any(one.taken_up and not one.noted for one in asked):
            note_served(self.connection, self.locked.row)
        return answers

    def _answer(self, hand_outs: Sequence[HandOut], asked: Asked, dispatched: bool) -> Exchange:
        """Claim for one worker; of the generation that was begun ahead where nothing else is left."""
        worker, live_workers = asked.worker, asked.live_workers
        hand_out, under_way = hand_outs[0], asked.submission.under_way()
        # Else another worker ended the generation, or it is one asked ahead: it goes on with that first.
        want = asked.want and not (asked.submission.partial and hand_out.rows.generation != asked.submission.generation)
        if not hand_out.left and not under_way:
            hand_out = next((further for further in hand_outs[1:] if further.left), hand_out)
        chunk = self.sizing.chunk(self.typical, hand_out.rows.size, hand_out.left, live_workers)
        if asked.agent is not None:
            chunk = min(chunk, asked.agent.most(self.typical))
        claimed = hand_out.choose(worker, chunk, under_way) if want else []
        left = sum(one.left for one in hand_outs)
        if want and not claimed and not left and not under_way:
            longest = max(self.settings.overdue_seconds, self.settings.overdue_factor * (self.typical or 0.0))
            claimed = hand_out.duplicate(worker, longest)
        claim = self._claim(hand_out.rows, claimed, last=not left) if claimed else None
        # One that only helps wakes one more.
        wakes = min(-(-left // chunk), live_workers - 1) if dispatched else int(asked.taken_up and left > 0)
        short = self.typical is not None and self.typical <= self.settings.single_seconds
        waiting = self.typical if want and claim is None and short else None
        return Exchange(claim, wakes=max(wakes, 0), left=left > 0, waiting=waiting)

    def _ahead(self, rows: GenerationRows, asked: Sequence[Asked]) -> list[GenerationRows]:
        """Rows of the generation that was begun ahead, if there is one."""
        if not self.course.problem.method.may_overlap or self.locked.row.retry_to is not None:
            return []
        ahead = self._load(rows.generation + 1, asked)
        return [ahead] if ahead.size else []

    def _learns(self) -> bool:
        """Whether the job goes on by its stored runs: it does so here, where they are stored."""
        if self.course.problem.method.learns or self.job is None or self.job.progress is None:
            return True
        return self.course.learns(self.job.progress)

    def _claim(self, rows: GenerationRows, cells: Sequence[Cell], *, last: bool) -> Claim:
        whole = (
            self.locked.row.retry_to is None
            and len(cells) == rows.size
            and self.sizing.local_batch(self.typical, len(cells))
            and not self._learns()
        )
        return Claim(
            job_id=self.locked.id,
            generation=rows.generation,
            particles=tuple(cell.particle for cell in cells),
            attempts=tuple(cell.status.attempts for cell in cells),
            positions=unpack_array(b"".join(cell.parameters for cell in cells)).reshape(len(cells), -1),
            now=self.locked.now,
            run_seconds=self.locked.run_seconds(self.settings.lease_seconds),
            job=self.job if whole else None,
            typical=self.typical,
            stopping=self.locked.row.stopping,
            last=last,
        )


def _typical(results: Sequence[tuple[float | None, str | None]], before: float | None) -> float | None:
    """Return what an evaluation costs [s]: the median of those that succeeded, or the mean where failures cost more.

    Parameters
    ----------
    results
        Seconds and reason of failure of each.
    before
        What was known before, for a generation without one success.
    """
    succeeded = [seconds for seconds, reason in results if reason is None and seconds is not None]
    if not succeeded:
        return before
    every = [seconds for seconds, _ in results if seconds is not None]
    return max(statistics.median(succeeded), statistics.fmean(every) if len(every) > len(succeeded) else 0.0)


def _all_dispatched(job_id: str, transition: Transition) -> list[GenerationRows]:
    dispatched = (i for i in transition.instructions if isinstance(i, DispatchGeneration))
    return [GenerationRows.dispatch(job_id, i.generation, i.positions) for i in dispatched]


def _dispatched(job_id: str, transition: Transition) -> GenerationRows:
    return _all_dispatched(job_id, transition)[0]
