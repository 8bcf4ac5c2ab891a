"""Chooses which evaluations of a generation workers get, in turn, in a transaction that holds the lock of its job."""

from __future__ import annotations

import heapq
from collections import defaultdict, deque
from collections.abc import Collection

from geoswarm.workers.coordinator.generation_rows import Cell, GenerationRows
from geoswarm.workers.states.evaluation import Claimed, Duplicated, settle

__all__ = ["HandOut"]


class HandOut:
    """Evaluations of a generation that can be claimed; read once for any number of workers.

    Parameters
    ----------
    rows
        The generation; claims are changed there, and written at the end of the transaction.
    now, lease
        The database's time, and how long a claim is held [s].
    """

    def __init__(self, rows: GenerationRows, now: float, lease: float) -> None:
        self.rows = rows
        self._now = now
        self._until = now + lease
        self._pending = deque(rows.unclaimed())
        self._held: defaultdict[str | None, list[Cell]] = defaultdict(list)
        for cell in rows.cells.values():
            if cell.status.state == "running":
                self._held[cell.status.worker].append(cell)
        for held in self._held.values():
            held.sort(key=lambda c: c.particle)
        self._late: tuple[float, list[Cell]] | None = None

    @property
    def left(self) -> int:
        """Number of unclaimed evaluations."""
        return self.rows.pending

    def choose(self, worker: str, most: int, under_way: Collection[int]) -> list[Cell]:
        """Claim up to a number of evaluations, in their order; ``under_way`` is what the worker is running."""
        chosen: list[Cell] = []
        if len(self._pending) < min(most, self.left):
            self._pending.extend(self.rows.read_unclaimed(most - len(self._pending)))
        # Those that it holds already: the answer to an earlier claim was lost.
        held = tuple(self._held[worker])
        for cell in heapq.merge(held, self._pending, key=lambda c: c.particle) if held else self._pending:
            if len(chosen) == most:
                break
            before = cell.status
            pending = before.state == "pending"
            if cell.particle in under_way:
                continue
            suspect = pending and before.attempts > 0
            if suspect and chosen:
                break  # it has failed or lost its worker before: alone, so that it takes no other with it
            after, verdict = settle(before, Claimed(worker))
            if verdict != "claimed":
                continue
            cell.set(after, lease_expires_at=self._until, started_at=self._now)
            chosen.append(cell)
            if pending:
                self._held[worker].append(cell)
            if suspect:
                break
        if chosen:
            self._take_off(chosen)
            self._held[worker].sort(key=lambda c: c.particle)
        return chosen

    def _take_off(self, chosen: Collection[Cell]) -> None:
        """Keep what is still pending; what was claimed stood mostly at the front."""
        while self._pending and self._pending[0].status.state != "pending":
            self._pending.popleft()
        first = self._pending[0].particle if self._pending else None
        if first is not None and any(cell.particle > first for cell in chosen):
            self._pending = deque(cell for cell in self._pending if cell.status.state == "pending")

    def duplicate(self, worker: str, longest: float) -> list[Cell]:
        """Claim an evaluation that has run elsewhere for longer than this [s], once; the first result counts."""
        if self._late is None or self._late[0] != longest:
            self._late = (longest, [cell for cell in self.rows.read_running() if self._is_late(cell, longest)])
        for cell in self._late[1]:
            before = cell.status
            if cell.duplicates:
                continue
            after, verdict = settle(before, Duplicated(worker))
            if verdict == "duplicated":
                self.rows.note_try(cell, before.attempts, before.worker, "overdue", self._now)
                cell.set(after, duplicates=1, lease_expires_at=self._until, started_at=self._now)
                return [cell]
        return []

    def _is_late(self, cell: Cell, longest: float) -> bool:
        late = cell.started_at is not None and self._now - cell.started_at >= longest
        return late and not cell.duplicates
