"""An agent: announces what this machine runs, has its slots work, and ends when it is asked to, or its time is up."""

from __future__ import annotations

import json
import logging
import os
import secrets
import socket
import sys
import threading
import time
from collections import OrderedDict
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from geoswarm.agent.errors import (
    AgentError,
    KeyRefusedError,
    LeaseEndedError,
    RejectedError,
    UnknownError,
    UnreachableError,
)
from geoswarm.agent.fetched import FetchedModels
from geoswarm.agent.inventory import announcement
from geoswarm.agent.outbox import Outbox
from geoswarm.agent.run_main import BOOTSTRAP
from geoswarm.agent.runs import RunProcess
from geoswarm.agent.server import Backoff, Lease, Patience, Server, Terms
from geoswarm.agent.slot import Slot
from geoswarm.solver.kernels.cache import settle
from geoswarm.solver.registered.folders import VARIABLE
from geoswarm.solver.system.environment import clean_environment, numerics
from geoswarm.solver.system.processes import adopt_orphans

__all__ = ["Agent", "AgentOptions"]

log = logging.getLogger(__name__)

RUNS_AT_ONCE = 1000
KEPT_FRAMES = 16
LOOK_SECONDS = 0.2
INVENTORY_SECONDS = 60.0
END_SECONDS = 5.0  # beyond the grace: to kill, hand in and sign off
ANSWERED_SECONDS = 2.0  # after which the service has answered what an agent asked before it signed off


@dataclass(frozen=True, slots=True)
class AgentOptions:
    """How an agent works.

    Parameters
    ----------
    url, key
        Address of the service, and the API key; None: it asks for none.
    slots
        Runs at once.
    idle_exit
        Time without work after which it ends [s]; None: never.
    seconds
        How long it runs [s]; None: until it is asked to end.
    grace
        How long runs may go on when it ends [s].
    kinds
        Kinds of forward model that it offers; None: all.
    folder
        Where results wait that could not be handed in.
    passed
        Names of environment variables that forward models get beside the usual ones.
    models_secret
        With which the list of models is signed that are fetched from the service; None: none are.
    """

    url: str
    key: str | None
    slots: int
    folder: Path
    idle_exit: float | None = None
    seconds: float | None = None
    grace: float = 10.0
    kinds: Collection[str] | None = None
    passed: tuple[str, ...] = ()
    models_secret: bytes | None = None


class Frames:
    """What runs of the last jobs share, by the name of it; safe to use from several threads."""

    def __init__(self) -> None:
        self._known: OrderedDict[str, Mapping[str, Any]] = OrderedDict()
        self._lock = threading.Lock()

    def names(self) -> list[str]:
        """Return those that are known."""
        with self._lock:
            return list(self._known)

    def learn(self, name: str, shared: Mapping[str, Any] | None) -> Mapping[str, Any] | None:
        """Return what a name stands for, and remember what came with it; None: it is not known."""
        with self._lock:
            if shared is not None:
                self._known[name] = shared
                while len(self._known) > KEPT_FRAMES:
                    self._known.popitem(last=False)
            found = self._known.get(name)
            if found is not None:
                self._known.move_to_end(name)
            return found


class Agent:
    """An agent; :meth:`serve` belongs to the main thread."""

    def __init__(self, options: AgentOptions, tell: Callable[[str], None]) -> None:
        self.options = options
        self.id = f"{_plain(socket.gethostname())[:40]}-{os.getpid()}-{secrets.token_hex(4)}"[:60]
        self.server = Server(options.url, options.key)
        self.outbox = Outbox(options.folder, options.url)
        self.frames = Frames()
        self.terms = Terms(2.5, 10.0, ())
        self.refused = False
        self.reason: str | None = None
        """Why it ended without a request to do so."""
        self._tell = tell
        self._until = None if options.seconds is None else time.monotonic() + options.seconds
        self._ended = threading.Event()
        self._kill_at: float | None = None
        self._asking = threading.Lock()
        self._patience = Patience()
        self._busy_at = time.monotonic()
        self._announced_at = 0.0
        self._inventory: dict[str, Any] | None = None
        self._fetched = (
            None
            if options.models_secret is None
            else FetchedModels(options.folder / "models", self.server, options.models_secret, self.ending)
        )
        self._environment = {**clean_environment(os.environ, options.passed), **numerics()}  # of all runs
        self._slots = [Slot(self, number, self._process()) for number in range(options.slots)]

    def serve(self) -> None:
        """Work until :meth:`end`, the end of its time, or too long without work.

        Raises
        ------
        KeyRefusedError
            The service does not accept the key.
        """
        adopt_orphans()  # what a killed keeper leaves is killed here
        settle()  # where kernels are kept: once for all slots
        self.outbox.take_over()
        try:
            announced = self._announce_at_first()
        except KeyRefusedError:
            self.server.close()
            self.outbox.close()
            raise
        if not announced:
            return self._close()
        for slot in self._slots:
            slot.start()
        swept = time.monotonic()
        while not self._ended.wait(LOOK_SECONDS):
            now = time.monotonic()
            if self._until is not None and now >= self._until:
                self.end("its time is up", grace=0.0)
            if any(slot.busy for slot in self._slots):
                self._busy_at = now
            if now - swept > INVENTORY_SECONDS:
                swept = now
                self._hand_in_old()
        self._finish()
        if self.refused:
            raise KeyRefusedError(self.reason or "the key is not valid")
        return None

    def end(self, why: str, *, grace: float | None = None) -> None:
        """Take no more work; what runs may go on for the grace. Asked twice, it is killed at once."""
        if self._ended.is_set():
            self._kill_at = time.monotonic()
            return
        self._kill_at = time.monotonic() + (self.options.grace if grace is None else grace)
        self._tell(f"Ending: {why}.")
        self._ended.set()

    def fail(self, why: str) -> None:
        """End because of a fault of its own."""
        self.reason = why
        self.end(why, grace=0.0)

    def refuse(self, why: str) -> None:
        """End because the key is not valid, or no longer."""
        if not self.refused:
            self.refused, self.reason = True, why
            self.end("the service does not accept the key", grace=0.0)

    def ending(self) -> bool:
        """Whether it takes no more work."""
        return self._ended.is_set() or self._left() == 0.0

    def killing(self) -> bool:
        """Whether what runs is to be killed now."""
        kill_at = self._kill_at
        return (kill_at is not None and time.monotonic() >= kill_at) or self._left() == 0.0

    def pause(self, seconds: float) -> None:
        """Wait [s], or until the agent ends."""
        if self._ended.is_set():
            time.sleep(min(seconds, 0.5))
        else:
            self._ended.wait(seconds)

    def wants(self, slot: Slot, wait: float = 0.0) -> dict[str, Any]:
        """Return what a slot asks the service for."""
        return {
            "agent": self.id,
            "slot": slot.number,
            "runs": RUNS_AT_ONCE,
            "wait": wait,
            "seconds": self._left(),
            "frames": self.frames.names(),
        }

    def next_lease(self, slot: Slot) -> Lease | None:
        """Wait for work; None: the agent ends. One slot asks at a time."""
        backoff = Backoff()
        while not self.ending():
            with self._asking:
                if self.ending():
                    break
                began = time.monotonic()
                try:
                    if not self._announced_at or began - self._announced_at > INVENTORY_SECONDS:
                        self._announce_changes()
                    began = time.monotonic()
                    lease = self.server.lease(self.wants(slot, self._longest_wait()))
                    backoff = Backoff()
                    if lease is not None:
                        slot.busy = True
                        return lease
                    self._patience.answered(self.terms.wait_seconds, after=time.monotonic() - began)
                    self._end_if_idle()
                    continue
                except UnreachableError as error:
                    if self.ending():
                        break
                    self._patience.broken_off(self.terms.wait_seconds, after=time.monotonic() - began)
                    self._end_if_idle()
                    wait = backoff.next(error.seconds)
                    log.warning("the service does not answer, next try in %.1f s: %s", wait, error)
                except UnknownError:
                    if self.ending():  # it has signed off
                        break
                    self.announce_again()
                    wait = 0.2
                except KeyRefusedError as error:
                    self.refuse(str(error))
                    break
                except RejectedError as error:
                    self.fail(f"the service does not understand this agent: {error}")
                    break
            self.pause(wait)
        return None

    def _end_if_idle(self) -> None:
        """End when there was no work for too long; asked when the service has said that there is none."""
        idle_exit = self.options.idle_exit
        if idle_exit is None or any(slot.busy for slot in self._slots):
            return
        if time.monotonic() - self._busy_at >= idle_exit:
            self.end(f"no work for {idle_exit:g} s", grace=0.0)

    def look_again(self) -> None:
        """Find out before the next lease what runs here: something may have changed."""
        self._announced_at = 0.0

    def announce_again(self) -> None:
        """Announce this agent once more: the service does not know it."""
        self._announced_at = 0.0
        self._inventory = None
        try:
            self._announce_changes()
        except AgentError as error:
            log.warning("could not be announced again: %s", error)

    def _announce_changes(self) -> None:
        """Tell the service what runs here, if that is not what it was told."""
        if self._fetched is not None:
            self._environment[VARIABLE] = os.environ[VARIABLE] = self._fetched.update()
        self._announced_at = time.monotonic()
        found = announcement(self.id, os.getpid(), self.options.slots, self.options.kinds)
        if found != self._inventory:
            self.terms = self.server.announce(found)
            self._inventory = found

    def _announce_at_first(self) -> bool:
        """Announce this agent, and tell what it will be given; False: it ended before the service answered."""
        backoff = Backoff()
        while not self.ending():
            try:
                self._announce_changes()
            except UnreachableError as error:
                self._announced_at = 0.0
                self._end_if_idle()
                wait = backoff.next(error.seconds)
                self._tell(f"The service does not answer; next try in {wait:.0f} s: {error}")
                self.pause(wait)
                continue
            except RejectedError as error:
                self.reason = f"the service does not understand this agent: {error}"
                return False
            offered = [text for text in self.terms.accepted if not text.startswith("registered:")]
            models = [text.split(":")[1] for text in self.terms.accepted if text.startswith("registered:")]
            runs = "; ".join(
                part
                for part in (
                    f"registered models {', '.join(models)}" if models else "",
                    f"{len(offered)} built-in kinds" if offered else "",
                )
                if part
            )
            slots = f"{self.options.slots} slot" + ("" if self.options.slots == 1 else "s")
            self._tell(f"Agent {self.id} at {self.options.url}: {slots}; {runs or 'nothing that it could run here'}.")
            self._hand_in_old()
            return True
        return False

    def _hand_in_old(self) -> None:
        """Hand in what earlier agents of this machine could not."""
        busy = any(slot.busy for slot in self._slots)
        for lease_id, body in [] if busy else list(self.outbox.waiting()):
            try:
                self.server.submit(lease_id, body)
            except (LeaseEndedError, RejectedError) as error:
                log.info("results of lease %s are not wanted any more: %s", lease_id[:8], error)
            except AgentError:
                return
            self.outbox.drop(lease_id)

    def _longest_wait(self) -> float:
        """How long to wait for work [s]."""
        waits = [self._patience.seconds(self.terms.wait_seconds)]
        if self.options.idle_exit is not None:
            waits.append(max(self.options.idle_exit - (time.monotonic() - self._busy_at), 0.5))
        left = self._left()
        return max(min([*waits, *([] if left is None else [left])]), 0.0)

    def _left(self) -> float | None:
        return None if self._until is None else max(self._until - time.monotonic(), 0.0)

    def _finish(self) -> None:
        """Let busy slots finish or hand back what they hold, then sign off."""
        deadline = time.monotonic() + self.options.grace + END_SECONDS
        self._wait_for_slots(deadline)
        self._close(deadline)

    def _wait_for_slots(self, deadline: float) -> None:
        while any(slot.busy for slot in self._slots) and time.monotonic() < deadline:
            time.sleep(0.02)

    def _close(self, deadline: float = 0.0) -> None:
        try:
            if not self.refused:
                self.server.sign_off(self.id)
                # This ends a request for work; one that was granted at this moment is handed back.
                if self._asking.acquire(timeout=min(max(deadline - time.monotonic(), 0.0), ANSWERED_SECONDS)):
                    self._asking.release()
                self._wait_for_slots(deadline)
        except AgentError as error:
            log.info("could not sign off: %s", error)
        self.server.close()
        for slot in self._slots:
            if slot.is_alive():
                slot.join(1.0)
            slot.stop()
        self.outbox.close()

    def _process(self) -> RunProcess:
        def arguments(log_file: Path) -> list[str]:
            given = json.dumps({"path": sys.path, "log": str(log_file)})
            return [sys.executable, "-c", BOOTSTRAP, given]

        return RunProcess(arguments, self._environment)


def _plain(text: str) -> str:
    return "".join(letter if letter.isascii() and (letter.isalnum() or letter in "._-") else "-" for letter in text)
