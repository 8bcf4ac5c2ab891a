"""One exchange between a worker and the coordinator, inside its transaction."""

from __future__ import annotations

import itertools
import statistics
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from sqlalchemy import Connection

from geoswarm.solver.calibration import Calibration
from geoswarm.solver.runs.runlog import RunLog
from geoswarm.workers.coordinator.ending import changed_criteria
from geoswarm.workers.coordinator.retry import finish_retry, open_retries
from geoswarm.workers.coordinator.tries import give_back, record_result
from geoswarm.workers.coordinator.work import Claim, Exchange, HandIn, Result, Sizing
from geoswarm.workers.queries.evaluations import Cell, GenerationRows, load_generation, reuse, write_new
from geoswarm.workers.queries.jobs import LockedJob, save_job
from geoswarm.workers.queries.queue import note_served
from geoswarm.workers.queries.versions import note_versions
from geoswarm.workers.settings import Settings
from geoswarm.workers.states.evaluation import Claimed, Duplicated, settle
from geoswarm.workers.states.job import (
    DispatchGeneration,
    GenerationJoined,
    Job,
    JobBroken,
    Joined,
    Transition,
    apply,
)
from geoswarm.workers.store.codec import unpack_array

__all__ = ["Closed", "Due", "JobExchange"]


@dataclass(frozen=True, slots=True)
class Due:
    """A complete generation of a search that learns from all runs: to be closed with no transaction open."""

    job: Job
    joined: GenerationJoined
    stopping: str | None = None


@dataclass(frozen=True, slots=True)
class Closed:
    """What the state machine made of it; holds if the job still stands there, with these stop criteria."""

    generation: int
    transition: Transition
    stopping: str | None = None


class JobExchange:
    """Takes in what a worker has, advances the job when its generation is complete, and hands out the next claim."""

    def __init__(
        self,
        settings: Settings,
        log: RunLog | None,
        connection: Connection,
        locked: LockedJob,
        worker: str,
        calibration: Calibration,
        live_workers: int,
    ) -> None:
        self.settings = settings
        self.sizing = Sizing(
            settings.cheap_seconds, settings.burst_seconds, settings.single_seconds, settings.chunk_seconds
        )
        self.log = log
        self.connection = connection
        self.locked = locked
        self.worker = worker
        self.calibration = calibration
        self.failures = calibration.problem.failures
        self.live_workers = live_workers
        self.state: str = locked.row.state
        self.typical: float | None = locked.row.typical_seconds
        self.job = None if locked.row.progress is None else locked.job()
        self.fatal: str | None = None
        self.due: Due | None = None

    def run(self, hand_in: HandIn, want: bool, taken_up: bool, closed: Closed | None = None) -> Exchange:
        """Do it; see :meth:`geoswarm.workers.coordinator.runtime.Runtime.exchange`.

        When :attr:`due` is set afterwards, a generation has to be closed: do that and come again with ``closed``.
        """
        if self.state == "queued":
            return Exchange(queued=True)
        if self.locked.row.retry_to is not None:
            return self._retry(hand_in, want, taken_up)
        generation = self.locked.row.generation
        rows: GenerationRows | None = None
        if generation >= 0 and (
            self.state == "running" or hand_in.generation == generation or hand_in.whole_generations
        ):
            rows = load_generation(self.connection, self.locked.id, generation)
        dispatched = False
        if hand_in.whole_generations:
            rows, dispatched = self._take_whole(rows, hand_in)
        elif hand_in.claim is not None:
            self._take_in(rows, hand_in, hand_in.generation, hand_in.results)
        if self.fatal is not None and self.state == "running" and self.job is not None:
            self._save([apply(self.job, JobBroken(self.fatal))], [])
        while self.state == "running" and rows is not None and rows.complete:
            rows = self._advance(rows, closed)
            dispatched = rows is not None
            if self.due is not None:
                return Exchange()
        if self.state != "running" or rows is None:
            if rows is not None:
                rows.write(self.connection)
            return Exchange()
        if hand_in.partial and rows.generation != hand_in.generation:
            want = False  # another worker ended the generation: what this one is at no longer matters
        return self._hand_out(rows, want, dispatched, taken_up, hand_in.under_way())

    def _retry(self, hand_in: HandIn, want: bool, taken_up: bool) -> Exchange:
        """Do the same for a job whose failures are run again: whatever generation they are of, none is advanced."""
        if hand_in.claim is not None:
            number, results = (
                (hand_in.whole_generations[0].generation, hand_in.whole_generations[0].results)
                if hand_in.whole_generations
                else (hand_in.generation, hand_in.results)
            )
            self._take_in(None, hand_in, number, results)
        if self.state != "running":
            return Exchange()
        generation, under_way = open_retries(self.connection, self.locked)
        if generation is None:
            if not under_way:
                finish_retry(self.connection, self.locked, self.calibration.problem, gap=self.settings.lease_seconds)
                return Exchange(left=self.locked.row.retry_to == "running")
            return Exchange()
        rows = load_generation(self.connection, self.locked.id, generation)
        return self._hand_out(rows, want and not hand_in.partial, False, taken_up)

    def _take_whole(self, rows: GenerationRows | None, hand_in: HandIn) -> tuple[GenerationRows | None, bool]:
        """Apply generations that the worker ran alone, if the job still stands where it did when they began."""
        whole_generations = hand_in.whole_generations
        valid = (
            rows is not None
            and self.state == "running"
            and rows.generation == whole_generations[0].generation
            and hand_in.claim is not None
            and hand_in.claim.stopping == self.locked.row.stopping
            and all(c.status.state == "running" and c.status.worker == self.worker for c in rows.cells)
        )
        if not valid or rows is None:
            # Paused, cancelled, taken over by others, or to be ended otherwise: the first generation is as good as any
            # worker's result of it, the following ones will come out the same again.
            self._take_in(rows, hand_in, whole_generations[0].generation, whole_generations[0].results)
            return rows, False
        self._record(rows, whole_generations[0].results)
        rows.write(self.connection)
        following = []
        for before, whole_generation in itertools.pairwise(whole_generations):
            following.append(_dispatched(self.locked.id, before.transition))
            self._record(following[-1], whole_generation.results)
        write_new(self.connection, following)
        transitions = [whole_generation.transition for whole_generation in whole_generations]
        final = transitions[-1]
        next_rows = None
        if final.job.state == "running":
            next_rows = _dispatched(self.locked.id, final)
            self._record(next_rows, hand_in.results)
            if self.fatal is not None:
                transitions.append(apply(final.job, JobBroken(self.fatal)))
        last = [r.evaluation for r in whole_generations[-1].results]
        self.typical = _typical([{"seconds": e.seconds, "reason": e.reason} for e in last], self.typical)
        self._save(transitions, [whole_generation.finished_at for whole_generation in whole_generations])
        return next_rows, next_rows is not None

    def _take_in(
        self, rows: GenerationRows | None, hand_in: HandIn, generation: int, results: Sequence[Result]
    ) -> None:
        """Record results, and give back what was claimed with them but not finished."""
        claim = hand_in.claim
        if claim is None:
            return
        late = rows is None or rows.generation != generation
        own = load_generation(self.connection, self.locked.id, generation) if late or rows is None else rows
        if not own.cells:
            return  # of a generation that was begun in a burst which does not count
        self._record(own, results)
        handed_in = {result.particle for result in results}
        for particle, attempt in zip(claim.particles, claim.attempts, strict=True):
            if not hand_in.partial and particle not in handed_in and generation == claim.generation:
                killed = particle == hand_in.killed
                give_back(own, own.cells[particle], self.worker, attempt, self.locked.now, killed=killed)
        if late:
            own.write(self.connection)

    def _record(self, rows: GenerationRows, results: Sequence[Result]) -> None:
        for result in results:
            fatal = record_result(self.connection, rows, result, self.worker, self.failures)
            self.fatal = self.fatal or fatal

    def _advance(self, rows: GenerationRows, closed: Closed | None) -> GenerationRows | None:
        """Close a complete generation; return the next one's rows, None when the job has ended or this is due."""
        rows.write(self.connection)
        values = [cell.values for cell in rows.cells]
        if self.job is None:
            raise RuntimeError(f"job {self.locked.id} has evaluations but no progress")
        stopping = self.locked.row.stopping
        if closed is not None and closed.generation == rows.generation and closed.stopping == stopping:
            transition = closed.transition
        else:
            results = [Joined(v["objective"], v["reason"], v["message"]) for v in values]
            seconds = self.locked.run_seconds(self.settings.lease_seconds)
            event = GenerationJoined(rows.generation, results, seconds, criteria=changed_criteria(stopping))
            if self.calibration.accelerated:  # takes its time: the database must not wait
                self.due = Due(self.job, event, stopping)
                return None
            transition = apply(self.job, event, self.calibration)
        self.typical = _typical(values, self.typical)
        self._save([transition], [])
        if transition.job.state != "running":
            return None
        following = _dispatched(self.locked.id, transition)
        if self._worth_reuse(following):
            reuse(self.connection, following)
        return following

    def _worth_reuse(self, rows: GenerationRows) -> bool:
        """Whether to look for earlier runs of the same parameters: where there are some, or a run costs more."""
        if self.log is not None:
            return self.log.repeats(np.array([unpack_array(cell.parameters) for cell in rows.cells]))
        return self.typical is not None and self.typical > self.settings.cheap_seconds

    def _save(self, transitions: Sequence[Transition], finished_at: Sequence[float]) -> None:
        save_job(
            self.connection,
            self.locked,
            transitions,
            gap=self.settings.lease_seconds,
            typical_seconds=self.typical,
            finished_at=finished_at,
        )
        self.job = transitions[-1].job
        self.state = self.job.state

    def _hand_out(
        self,
        rows: GenerationRows,
        want: bool,
        dispatched: bool,
        taken_up: bool,
        under_way: Collection[int] = frozenset(),
    ) -> Exchange:
        """Answer with a claim, if there is one to be had; ``under_way`` is what this worker is at."""
        particles = len(rows.cells)
        if self.typical is None:  # generation 0 teaches what a run costs while it goes on
            self.typical = _typical([cell.values for cell in rows.cells if cell.status.done], None)
        left = sum(cell.status.state == "pending" for cell in rows.cells)
        chunk = self.sizing.chunk(self.typical, particles, left, self.live_workers)
        claimed = self._choose(rows, chunk, under_way) if want else []
        left = sum(cell.status.state == "pending" for cell in rows.cells)
        if want and not claimed and not left and not under_way:
            claimed = self._duplicate(rows)
        claim = self._claim(rows, claimed, last=not left) if claimed else None
        rows.write(self.connection)
        if claim is not None:
            note_versions(self.connection, self.locked, self.worker)
        if taken_up:
            note_served(self.connection, self.locked.row)
        # Who dispatches wakes as many as there are chunks; who only comes to help wakes one more.
        rings = min(-(-left // chunk), self.live_workers - 1) if dispatched else int(taken_up and left > 0)
        short = self.typical is not None and self.typical <= self.settings.single_seconds
        waiting = self.typical if want and claim is None and short else None
        return Exchange(claim, rings=max(rings, 0), left=left > 0, waiting=waiting)

    def _choose(self, rows: GenerationRows, chunk: int, under_way: Collection[int]) -> list[Cell]:
        chosen: list[Cell] = []
        for cell in rows.cells:
            if len(chosen) == chunk:
                break
            if cell.particle in under_way:
                continue
            before = cell.status
            suspect = before.state == "pending" and before.attempts > 0
            if suspect and chosen:
                break  # it has failed or lost its worker before: alone, so that it takes no other with it
            after, verdict = settle(before, Claimed(self.worker))
            if verdict != "claimed":
                continue
            now = self.locked.now
            cell.set(after, lease_expires_at=now + self.settings.lease_seconds, started_at=now)
            chosen.append(cell)
            if suspect:
                break
        return chosen

    def _duplicate(self, rows: GenerationRows) -> list[Cell]:
        """Take up an evaluation that has been running for far too long elsewhere, once; the first result counts."""
        now = self.locked.now
        longest = max(self.settings.overdue_seconds, self.settings.overdue_factor * (self.typical or 0.0))
        for cell in rows.cells:
            before, started_at = cell.status, cell.values["started_at"]
            if cell.values["duplicates"] or started_at is None or now - started_at < longest:
                continue
            after, verdict = settle(before, Duplicated(self.worker))
            if verdict == "duplicated":
                rows.note_try(cell, before.attempts, before.worker, "overdue", now)
                cell.set(after, duplicates=1, lease_expires_at=now + self.settings.lease_seconds, started_at=now)
                return [cell]
        return []

    def _claim(self, rows: GenerationRows, cells: Sequence[Cell], *, last: bool) -> Claim:
        # A search that learns from stored runs advances here, where they are stored.
        whole = (
            self.locked.row.retry_to is None
            and not self.calibration.accelerated
            and len(cells) == len(rows.cells)
            and self.sizing.burst(self.typical, len(cells))
        )
        return Claim(
            job_id=self.locked.id,
            generation=rows.generation,
            particles=tuple(cell.particle for cell in cells),
            attempts=tuple(cell.status.attempts for cell in cells),
            positions=np.array([unpack_array(cell.parameters) for cell in cells]),
            now=self.locked.now,
            run_seconds=self.locked.run_seconds(self.settings.lease_seconds),
            job=self.job if whole else None,
            typical=self.typical,
            stopping=self.locked.row.stopping,
            last=last,
        )


def _typical(results: Sequence[Mapping[str, Any]], before: float | None) -> float | None:
    """Return what an evaluation costs [s]: the median of those that succeeded, or the mean where failures cost more.

    Parameters
    ----------
    results
        ``seconds`` and ``reason`` of each.
    before
        What was known before, for a generation without one success.
    """
    succeeded: list[float] = [result["seconds"] for result in results if result["reason"] is None]
    if not succeeded:
        return before
    every: list[float] = [result["seconds"] for result in results if result["seconds"] is not None]
    return max(statistics.median(succeeded), statistics.fmean(every) if len(every) > len(succeeded) else 0.0)


def _dispatched(job_id: str, transition: Transition) -> GenerationRows:
    dispatch = next(i for i in transition.instructions if isinstance(i, DispatchGeneration))
    return GenerationRows.dispatch(job_id, dispatch.generation, dispatch.positions)
