"""Lets threads of one process that make exchanges for the same job at the same time share a transaction.

While one of them is at the database, those that come wait for its lock anyway. So the next one takes along what all of
them bring: one lock, one look at the generation, one commit, however many there are. A single one does not wait.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from concurrent.futures import Future

from geoswarm.solver.course import Course
from geoswarm.workers.coordinator.work import Asked, Exchange
from geoswarm.workers.errors import StoreUnavailableError

__all__ = ["Together"]

MOST = 500
"""Exchanges in one transaction."""

Serve = Callable[[str, Course, Sequence[Asked]], Sequence[Exchange]]


class _Ticket:
    """What a thread asks, and what it waits for."""

    def __init__(self, course: Course, asked: Asked) -> None:
        self.course = course
        self.asked = asked
        self.answer: Future[Exchange] = Future()
        self.turn = threading.Event()
        """There is an answer, or it is this thread's turn to ask for all that wait."""


class Together:
    """Joins the exchanges of threads; safe to use from any number of them.

    Parameters
    ----------
    serve
        Exchanges for workers of one job, in their order, in one transaction.
    """

    def __init__(self, serve: Serve) -> None:
        self._serve = serve
        self._lock = threading.Lock()
        self._waiting: dict[str, list[_Ticket]] = {}  # of each job that somebody is at

    def ask(self, job_id: str, course: Course, asked: Asked) -> Exchange:
        """Exchange, with others or alone.

        Raises
        ------
        StoreUnavailableError
        """
        ticket = _Ticket(course, asked)
        with self._lock:
            waiting = self._waiting.get(job_id)
            if waiting is None:
                self._waiting[job_id] = []
            else:
                waiting.append(ticket)
        try:
            if waiting is not None:
                ticket.turn.wait()
        except BaseException:
            self._leave(job_id, ticket)
            raise
        if not ticket.answer.done():
            self._ask_for_all(job_id, ticket)
        return ticket.answer.result()

    def _leave(self, job_id: str, ticket: _Ticket) -> None:
        """Let the others go on without a thread that is interrupted while it waits."""
        with self._lock:
            waiting = self._waiting.get(job_id, [])
            if ticket in waiting:
                waiting.remove(ticket)
                return
        if ticket.turn.is_set() and not ticket.answer.done():
            self._pass_on(job_id)

    def _pass_on(self, job_id: str) -> None:
        with self._lock:
            waiting = self._waiting[job_id]
            if waiting:
                waiting.pop(0).turn.set()
            else:
                del self._waiting[job_id]

    def _ask_for_all(self, job_id: str, first: _Ticket) -> None:
        with self._lock:
            waiting = self._waiting[job_id]
            # Another course is one that was read anew, by a process that had forgotten it.
            same = [ticket for ticket in waiting if ticket.course is first.course][: MOST - 1]
            taken = {id(ticket) for ticket in same}
            self._waiting[job_id] = [ticket for ticket in waiting if id(ticket) not in taken]
        try:
            self._answer(job_id, [first, *same])
        finally:
            self._pass_on(job_id)
            for ticket in same:
                if not ticket.answer.done():  # this thread is interrupted
                    ticket.answer.set_exception(StoreUnavailableError("the process that asked for several is ending"))
                ticket.turn.set()

    def _answer(self, job_id: str, tickets: Sequence[_Ticket]) -> None:
        try:
            answers = self._serve(job_id, tickets[0].course, [ticket.asked for ticket in tickets])
        except StoreUnavailableError as error:
            for ticket in tickets:
                ticket.answer.set_exception(error)
        except Exception as error:  # noqa: BLE001  it is raised in the thread that asked
            if len(tickets) == 1:
                tickets[0].answer.set_exception(error)
            else:  # what one of them brought is wrong: the others shall not suffer
                for ticket in tickets:
                    self._answer(job_id, [ticket])
        else:
            for ticket, answer in zip(tickets, answers, strict=True):
                ticket.answer.set_result(answer)
