"""The thread that sends notifications of ended jobs; any number may run, one in each service and ``geoswarm sweep``.

Notifications to send are rows of the database (:mod:`geoswarm.workers.store.outbox`), so no process loses any. A
message can come twice, when a process is lost between the answer and its note of it; its id is the same then.
"""

from __future__ import annotations

import json
import logging
import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Any

from geoswarm.workers.access.principal import LOCAL
from geoswarm.workers.errors import JobNotFoundError, StoreUnavailableError
from geoswarm.workers.notices.mail import send_mail
from geoswarm.workers.notices.message import body_of, mail_of, trial_body
from geoswarm.workers.notices.queue import any_due, forget_old, hold_due, keep_body, note_delivered, note_failure
from geoswarm.workers.notices.settings import NoticeSettings
from geoswarm.workers.notices.verdicts import SECONDS, Found, find_verdicts
from geoswarm.workers.notices.web import NotDeliveredError, post
from geoswarm.workers.operations.counters import process_counters
from geoswarm.workers.service.job_service import JobService
from geoswarm.workers.settings import Settings
from geoswarm.workers.store import Store
from geoswarm.workers.store.codec import to_datetime
from geoswarm.workers.store.database import Record
from geoswarm.workers.waker import NoWaker

__all__ = ["AGAIN_SECONDS", "Notifier"]

log = logging.getLogger(__name__)

AGAIN_SECONDS = (10.0, 60.0, 300.0, 900.0, 3600.0, 7200.0, 14_400.0, 28_800.0)
"""Pauses before the second try and those after it [s]: fifteen hours in all; then a message is given up."""

LOOK_SECONDS = 1.0
LONGEST_LOOK_SECONDS = 30.0
AT_ONCE = 4
FORGET_EVERY = 3600.0


class Notifier:
    """Delivers what is due, by :meth:`deliver` once or by a thread of its own.

    Parameters
    ----------
    again
        Pauses before the second try and those after it [s].
    find
        Finds what the data say about a job's parameters.
    """

    def __init__(
        self,
        store: Store,
        settings: Settings,
        notices: NoticeSettings | None = None,
        again: tuple[float, ...] = AGAIN_SECONDS,
        find: Callable[[Settings, str], Found] = find_verdicts,
    ) -> None:
        self.store = store
        self.settings = settings
        self.notices = NoticeSettings.from_environment() if notices is None else notices
        self.again = again
        self._find = find
        self._jobs = JobService(store, NoWaker(), settings).on_behalf_of(LOCAL)
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    def deliver(self) -> int:
        """Try everything that is due now; return how many tries were made.

        Raises
        ------
        StoreUnavailableError
        """
        if not self.store.read(any_due):
            return 0
        held_for = SECONDS + 2 * self.notices.hook_seconds + 30.0
        rows = self.store.write(lambda connection: hold_due(connection, AT_ONCE, held_for))
        if not rows:
            return 0
        with ThreadPoolExecutor(AT_ONCE, "geoswarm-notice") as threads:
            tried = [threads.submit(self._try, row) for row in rows]
        for one in tried:
            one.result()
        return len(rows)

    def start(self) -> None:
        """Deliver in a thread."""
        self._thread = threading.Thread(target=self.run, name="geoswarm-notices", daemon=True)
        self._thread.start()

    def run(self) -> None:
        """Deliver until :meth:`stop`; while the database does not answer, look ever more rarely."""
        wait, forgotten = LOOK_SECONDS, FORGET_EVERY
        while not self._stop.wait(wait):
            try:
                while self.deliver() and not self._stop.is_set():
                    pass
                forgotten += wait
                if forgotten >= FORGET_EVERY:
                    self.store.write(forget_old)
                    forgotten = 0.0
            except StoreUnavailableError as error:
                wait = min(2 * wait, LONGEST_LOOK_SECONDS)
                log.warning("notices: %s", error)
            else:
                wait = LOOK_SECONDS

    def end(self) -> None:
        """Let :meth:`run` end soon."""
        self._stop.set()

    def stop(self) -> None:
        """End the thread; a try under way is waited for a moment, and made again by others if that is not enough."""
        self.end()
        if self._thread is not None:
            self._thread.join(1.0)
            self._thread = None

    def _try(self, row: Record) -> None:
        try:
            body = self._body(row)
            if body is None:
                return  # the job, and with it the delivery, was deleted
            self._send(row, body)
        except NotDeliveredError as error:
            again = None if error.final or row.tries > len(self.again) else self.again[row.tries - 1]
            message = str(error)[:500]
            log.warning("hook %s, try %d: %s", row.hook_id, row.tries, message)
            self.store.write(lambda connection: note_failure(connection, row.id, message, again))
            process_counters.add("notices", "retried" if again is not None else "given_up")
        else:
            self.store.write(lambda connection: note_delivered(connection, row.id))
            process_counters.add("notices", "delivered")

    def _send(self, row: Record, body: str) -> None:
        message_id = f"geoswarm-{row.hook_id}-{row.id}"
        if row.kind == "mail":
            subject, text = mail_of(json.loads(body))
            send_mail(self.notices, row.target, message_id, subject, text)
            return
        networks, seconds = self.notices.networks, self.notices.hook_seconds
        post(row.target, row.secret, message_id, body.encode(), networks=networks, seconds=seconds)

    def _body(self, row: Record) -> str | None:
        if row.body is not None:
            return str(row.body)
        at = to_datetime(row.created_at)
        if row.job_id is None:
            made: dict[str, Any] = trial_body(at)
        else:
            try:
                job = self._jobs.get(row.job_id)
            except JobNotFoundError:
                return None
            found = self._find(self.settings, job.id) if job.objective is not None else None
            make = partial(body_of, job, row.job_state, at, public_url=self.notices.public_url)
            made = make() if found is None else make(found)
        body = json.dumps(made, allow_nan=False)
        self.store.write(lambda connection: keep_body(connection, row.id, body))
        return body
