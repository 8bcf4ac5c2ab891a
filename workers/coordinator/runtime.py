"""Applies events to the store: locks the job's row, asks the pure machines, writes, commits; ringing comes after.

Every change of a job and of its evaluations happens while the transaction holds the lock of the job's row, taken before
anything else is read. So counting what is left of a generation and advancing it cannot race, whatever the isolation
level, and there is one order of locks.
"""

from __future__ import annotations

import itertools
import statistics
from collections.abc import MutableMapping, Sequence
from weakref import WeakKeyDictionary

import numpy as np
from sqlalchemy import Connection

from solver.calibration import Calibration, Progress, RunLog
from solver.errors import InfeasibleSpaceError
from solver.search import Runs
from workers.coordinator.evaluation import Claimed, LeaseExpired, LeaseReleased, ResultArrived, settle
from workers.coordinator.machine import (
    CancelRequested,
    DispatchGeneration,
    GenerationJoined,
    JobBroken,
    JobEvent,
    JobStarted,
    Joined,
    PauseRequested,
    ResumeRequested,
    Transition,
    apply,
)
from workers.coordinator.work import Claim, Exchange, HandIn, Leap, Result, Sizing
from workers.errors import JobNotFoundError
from workers.settings import Settings
from workers.store import Store
from workers.store.codec import clean_text, pack_json, pack_responses, unpack_array
from workers.store.evaluations import Board, Cell, list_runs, load_board, renew_leases, write_new
from workers.store.jobs import LockedJob, lock_job, note_served, save_job

__all__ = ["Runtime"]

MESSAGE_LENGTH = 2000


class Runtime:
    """The coordinator of all jobs in one store; holds no state of its own, but remembers finished runs."""

    def __init__(self, store: Store, settings: Settings) -> None:
        self.store = store
        self.settings = settings
        self._sizing = Sizing(settings.cheap_seconds, settings.burst_seconds)
        self.logs: MutableMapping[Calibration, RunLog] = WeakKeyDictionary()

    def request(self, job_id: str, event: CancelRequested | PauseRequested | ResumeRequested) -> bool:
        """Apply a user's request; return whether workers should be woken.

        Raises
        ------
        JobNotFoundError, InvalidTransitionError
        """

        def work(connection: Connection) -> bool:
            locked = lock_job(connection, job_id)
            if locked is None:
                raise JobNotFoundError(job_id)
            transition = apply(locked.job(), event)
            self._save(connection, locked, [transition])
            return bool(transition.instructions) and transition.job.state in ("queued", "running")

        return self.store.write(work)

    def start(self, job_id: str, progress: Progress | InfeasibleSpaceError) -> None:
        """Start a queued job with its generation 0, which the caller has calculated."""
        self._apply(job_id, JobStarted(progress))

    def give_up(self, job_id: str, message: str) -> None:
        """End a job that cannot be worked on."""
        self._apply(job_id, JobBroken(message))

    def exchange(
        self,
        job_id: str,
        worker: str,
        calibration: Calibration,
        hand_in: HandIn,
        *,
        live_workers: int,
        want: bool,
        taken_up: bool = False,
    ) -> Exchange:
        """Take in what a worker has, advance the job when its generation is complete, and hand out the next claim.

        Parameters
        ----------
        live_workers
            Number of workers that share the job's evaluations.
        want
            Whether the worker takes a new claim.
        taken_up
            The worker turns to this job now: the others move up in the line.
        """

        def work(connection: Connection) -> Exchange:
            locked = lock_job(connection, job_id)
            if locked is None:
                return Exchange()
            return _Session(self, connection, locked, worker, calibration, live_workers).run(hand_in, want, taken_up)

        return self.store.write(work)

    def renew(self, claim: Claim, worker: str) -> None:
        """Renew the leases of a claim."""

        def work(connection: Connection) -> None:
            if lock_job(connection, claim.job_id) is not None:
                renew_leases(
                    connection, claim.job_id, claim.generation, claim.particles, worker, self.settings.lease_seconds
                )

        self.store.write(work)

    def expire(self, job_id: str, generation: int, lost_workers: Sequence[str]) -> int:
        """End the leases of a generation that are overdue or whose worker is lost; return how many."""

        def work(connection: Connection) -> int:
            locked = lock_job(connection, job_id)
            if locked is None:
                return 0
            board = load_board(connection, job_id, generation)
            expired = 0
            for cell in board.cells:
                lease = cell.values["lease_expires_at"]
                overdue = lease is not None and lease < locked.now
                if cell.status.state == "running" and (overdue or cell.status.worker in lost_workers):
                    self._expire(board, cell, locked.now)
                    expired += 1
            board.write(connection)
            return expired

        return self.store.write(work)

    def _expire(self, board: Board, cell: Cell, now: float) -> None:
        before = cell.status
        after, verdict = settle(before, LeaseExpired(self.settings.max_attempts))
        if verdict == "given_up":
            message = f"the worker was lost {before.attempts} times, last {before.worker}"
            cell.set(after, reason="worker_lost", message=message, finished_at=now, lease_expires_at=None)
        elif verdict == "redispatched":
            board.note_try(cell, before.attempts, before.worker, "worker_lost", now)
            cell.set(after, lease_expires_at=None, started_at=None)

    def _apply(self, job_id: str, event: JobEvent) -> None:
        def work(connection: Connection) -> None:
            locked = lock_job(connection, job_id)
            if locked is not None:
                self._save(connection, locked, [apply(locked.job(), event)])

        self.store.write(work)

    def _save(self, connection: Connection, locked: LockedJob, transitions: Sequence[Transition]) -> None:
        save_job(connection, locked, transitions, gap=self.settings.lease_seconds)
        for transition in transitions:
            for instruction in transition.instructions:
                if isinstance(instruction, DispatchGeneration):
                    Board.dispatch(locked.id, instruction.generation, instruction.positions).write(connection)


class _Session:
    """One exchange, inside its transaction."""

    def __init__(
        self,
        runtime: Runtime,
        connection: Connection,
        locked: LockedJob,
        worker: str,
        calibration: Calibration,
        live_workers: int,
    ) -> None:
        self.settings = runtime.settings
        self.sizing = runtime._sizing
        self.logs = runtime.logs
        self.connection = connection
        self.locked = locked
        self.worker = worker
        self.calibration = calibration
        self.live_workers = live_workers
        self.state: str = locked.row.state
        self.typical: float | None = locked.row.typical_seconds
        self.job = None if locked.row.progress is None else locked.job()

    def run(self, hand_in: HandIn, want: bool, taken_up: bool) -> Exchange:
        if self.state == "queued":
            return Exchange(queued=True)
        generation = self.locked.row.generation
        board: Board | None = None
        if generation >= 0 and (self.state == "running" or hand_in.generation == generation or hand_in.leaps):
            board = load_board(self.connection, self.locked.id, generation)
        dispatched = False
        if hand_in.leaps:
            board, dispatched = self._leap(board, hand_in)
        elif hand_in.claim is not None:
            self._take_in(board, hand_in.claim, hand_in.generation, hand_in.results)
        if self.state == "running" and board is not None and board.complete:
            board = self._advance(board)
            dispatched = board is not None
        if self.state != "running" or board is None:
            if board is not None:
                board.write(self.connection)
            return Exchange()
        return self._hand_out(board, want, dispatched, taken_up)

    def _leap(self, board: Board | None, hand_in: HandIn) -> tuple[Board | None, bool]:
        """Apply generations that the worker ran alone, if the job still stands where it did when they began."""
        leaps = hand_in.leaps
        valid = (
            board is not None
            and self.state == "running"
            and board.generation == leaps[0].generation
            and all(c.status.state == "running" and c.status.worker == self.worker for c in board.cells)
        )
        if not valid or board is None:
            # Paused, cancelled, or taken over by others: the first generation is as good as any worker's result of
            # it, the following ones will come out the same again.
            self._take_in(board, hand_in.claim, leaps[0].generation, leaps[0].results)
            return board, False
        self._record(board, leaps[0].results)
        board.write(self.connection)
        following = []
        for before, leap in itertools.pairwise(leaps):
            following.append(_dispatched(self.locked.id, before.transition))
            self._record(following[-1], leap.results)
        write_new(self.connection, following)
        self._finish(leaps)
        final = leaps[-1].transition
        if final.job.state != "running":
            return None, False
        next_board = _dispatched(self.locked.id, final)
        self._record(next_board, hand_in.results)
        return next_board, True

    def _finish(self, leaps: Sequence[Leap]) -> None:
        seconds = [r.evaluation.seconds for r in leaps[-1].results if r.evaluation.reason is None]
        self.typical = statistics.median(seconds) if seconds else self.typical
        self._save([leap.transition for leap in leaps], [leap.finished_at for leap in leaps])

    def _take_in(self, board: Board | None, claim: Claim | None, generation: int, results: Sequence[Result]) -> None:
        """Record results, and give back what was claimed with them but not begun."""
        if claim is None:
            return
        late = board is None or board.generation != generation
        own = load_board(self.connection, self.locked.id, generation) if late or board is None else board
        self._record(own, results)
        handed_in = {result.particle for result in results}
        for particle, attempt in zip(claim.particles, claim.attempts, strict=True):
            if particle not in handed_in and generation == claim.generation:
                cell = own.cells[particle]
                after, verdict = settle(cell.status, LeaseReleased(self.worker, attempt))
                if verdict == "released":
                    cell.set(after, lease_expires_at=None, started_at=None)
        if late:
            own.write(self.connection)

    def _record(self, board: Board, results: Sequence[Result]) -> None:
        for result in results:
            cell = board.cells[result.particle]
            if cell.status.attempts == 0:
                cell.status, _ = settle(cell.status, Claimed(self.worker))  # begun in the worker that dispatched it
            evaluation = result.evaluation
            failed = evaluation.reason is not None
            after, verdict = settle(cell.status, ResultArrived(self.worker, result.attempt, failed))
            times = {"started_at": result.started_at, "finished_at": result.finished_at}
            if verdict == "late":
                at, began = times["finished_at"], times["started_at"]
                board.note_try(cell, result.attempt, self.worker, "late", at, started_at=began)
            elif verdict == "counted":
                cell.set(
                    after,
                    objective=evaluation.objective,
                    misfits=pack_json(evaluation.misfits) if evaluation.misfits else None,
                    responses=pack_responses(evaluation.responses) if evaluation.responses else None,
                    reason=evaluation.reason,
                    message=None if evaluation.message is None else clean_text(evaluation.message[:MESSAGE_LENGTH]),
                    lease_expires_at=None,
                    seconds=evaluation.seconds,
                    **times,
                )

    def _advance(self, board: Board) -> Board | None:
        """Close a complete generation; return the next one's board, None when the job has ended."""
        board.write(self.connection)
        values = [cell.values for cell in board.cells]
        results = [Joined(v["objective"], v["reason"], v["message"]) for v in values]
        if self.job is None:
            raise RuntimeError(f"job {self.locked.id} has evaluations but no progress")
        seconds = self.locked.run_seconds(self.settings.lease_seconds)
        runs = self._runs(board.generation) if self.calibration.accelerated else None
        transition = apply(self.job, GenerationJoined(board.generation, results, seconds, runs), self.calibration)
        succeeded = [v["seconds"] for v in values if v["reason"] is None]
        self.typical = statistics.median(succeeded) if succeeded else self.typical
        self._save([transition], [])
        return _dispatched(self.locked.id, transition) if transition.job.state == "running" else None

    def _runs(self, generation: int) -> Runs:
        """All runs so far. Only earlier generations go into the log: this one is final when the commit succeeds."""
        log = self.logs.setdefault(self.calibration, RunLog(self.calibration))
        found = list_runs(self.connection, self.locked.id, log.generations, generation)
        for number in range(log.generations, generation):
            log.add(*found[number])
        return log.runs(*found[generation])

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

    def _hand_out(self, board: Board, want: bool, dispatched: bool, taken_up: bool) -> Exchange:
        particles = len(board.cells)
        chunk = self.sizing.chunk(self.typical, particles, self.live_workers)
        claimed = self._choose(board, chunk) if want else []
        left = sum(cell.status.state == "pending" for cell in board.cells)
        claim = self._claim(board, claimed) if claimed else None
        board.write(self.connection)
        if taken_up:
            note_served(self.connection, self.locked.id)
        # Who dispatches wakes as many as there are chunks; who only comes to help wakes one more.
        rings = min(-(-left // chunk), self.live_workers - 1) if dispatched else int(taken_up and left > 0)
        return Exchange(claim, rings=max(rings, 0), left=left > 0)

    def _choose(self, board: Board, chunk: int) -> list[Cell]:
        chosen: list[Cell] = []
        for cell in board.cells:
            if len(chosen) == chunk:
                break
            before = cell.status
            suspect = before.state == "pending" and before.attempts > 0
            if suspect and chosen:
                break  # it may have killed its worker: alone, so that it takes no other with it
            after, verdict = settle(before, Claimed(self.worker))
            if verdict != "claimed":
                continue
            now = self.locked.now
            cell.set(after, lease_expires_at=now + self.settings.lease_seconds, started_at=now)
            chosen.append(cell)
            if suspect:
                break
        return chosen

    def _claim(self, board: Board, cells: Sequence[Cell]) -> Claim:
        # A search that learns from stored runs advances here, where they are stored.
        alone = len(cells) == len(board.cells) and not self.calibration.accelerated
        whole = alone and self.sizing.burst(self.typical, len(cells))
        return Claim(
            job_id=self.locked.id,
            generation=board.generation,
            particles=tuple(cell.particle for cell in cells),
            attempts=tuple(cell.status.attempts for cell in cells),
            positions=np.array([unpack_array(cell.parameters) for cell in cells]),
            now=self.locked.now,
            run_seconds=self.locked.run_seconds(self.settings.lease_seconds),
            job=self.job if whole else None,
        )


def _dispatched(job_id: str, transition: Transition) -> Board:
    dispatch = next(i for i in transition.instructions if isinstance(i, DispatchGeneration))
    return Board.dispatch(job_id, dispatch.generation, dispatch.positions)
