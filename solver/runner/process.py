"""A worker's side of one evaluation process: asks it, and takes in answers without ever waiting for it alone."""

from __future__ import annotations

import os
import secrets
import select
import signal
import socket
import time
from collections.abc import Mapping
from typing import Any

from geoswarm.solver.runner.shared_state import SharedState
from geoswarm.solver.runner.wire import ONCE, ConnectionEnded, Frame, FrameReader, GarbledError

__all__ = ["EvaluationProcess"]

WAKE_SECONDS = 1.0


class EvaluationProcess:
    """An evaluation process that belongs to one job.

    Parameters
    ----------
    connection
        Its answers come here.
    shared
        Memory shared with it.
    pid
        Its number.
    pidfd
        A descriptor that is ready when it has ended, even if others hold its connection; None: the system has none.
    """

    def __init__(self, connection: socket.socket, shared: SharedState, pid: int, pidfd: int | None) -> None:
        connection.setblocking(False)
        self._connection = connection
        self.shared = shared
        self.pid = pid
        self._pidfd = pidfd
        self._reader = FrameReader()
        self._poll = select.poll()
        for descriptor in (connection.fileno(), *(() if pidfd is None else (pidfd,))):
            self._poll.register(descriptor, select.POLLIN)
        self._unsent = b""
        self._nonce = 0
        self._index = 0
        self._woken = time.monotonic()
        self.job: str | None = None
        """Whose problem it has loaded."""
        self.runs = 0
        """Evaluations that it has answered."""
        self.heard = time.monotonic()
        """When it last said something [s]."""

    @property
    def spoke_unasked(self) -> bool:
        """Whether something unrequested came from it, or it has ended."""
        return bool(self._reader) or bool(self._poll.poll(0))

    @property
    def answering(self) -> bool:
        """Whether an answer has begun and not ended."""
        return bool(self._reader)

    def ask(self, head: Mapping[str, Any], body: bytes = b"", *, first: bool = True) -> None:
        """Ask something; what does not go through at once is sent by :meth:`answer`.

        Parameters
        ----------
        first
            False: it follows another request that brings no answer of its own.

        Raises
        ------
        ConnectionEnded
        """
        if first:
            self._nonce, self._index = secrets.randbits(64), 0
        self._unsent += Frame(self._nonce, 0, self.pid, head, body).packed()
        self._send()

    def answer(self, seconds: float) -> Frame | None:
        """Return the next frame that answers, None when there is none within this time.

        Raises
        ------
        GarbledError
            When what came is no answer to what was asked.
        ConnectionEnded
            When the process has ended, or closed its connection.
        """
        frame = self._reader.frame()
        if frame is None:
            if self._unsent:
                self._poll.modify(self._connection, select.POLLIN | select.POLLOUT)
            ready = self._poll.poll(1000.0 * seconds)
            if self._unsent:
                self._send()
                self._poll.modify(self._connection, select.POLLIN)
            if not ready:
                self._wake()
                return None
            came = self._receive()
            frame = self._reader.frame()
            if frame is None and not came and any(descriptor == self._pidfd for descriptor, _ in ready):
                raise ConnectionEnded
        if frame is None:
            return None
        if (frame.nonce, frame.index, frame.pid) != (self._nonce, self._index, self.pid):
            raise GarbledError
        return frame

    def took(self, outcomes: int) -> None:
        """Note how many evaluations an answer brought: the next one begins behind them."""
        self._index += outcomes
        self.runs += outcomes

    def close(self) -> None:
        """Close everything that leads to it."""
        self._connection.close()
        self.shared.close()
        if self._pidfd is not None:
            os.close(self._pidfd)
            self._pidfd = None

    def _send(self) -> None:
        try:
            while self._unsent:
                self._unsent = self._unsent[self._connection.send(self._unsent) :]
        except BlockingIOError:
            pass
        except (BrokenPipeError, ConnectionResetError):
            raise ConnectionEnded from None

    def _receive(self) -> bool:
        """Take in what has come; False when that is nothing yet."""
        try:
            data = self._connection.recv(ONCE)
        except BlockingIOError:
            return False
        except ConnectionResetError:
            data = b""
        if not data:
            raise ConnectionEnded
        self.heard = time.monotonic()
        self._reader.feed(data)
        return True

    def _wake(self) -> None:
        """Have it go on when it was stopped, by itself or by others; what runs takes no notice."""
        now = time.monotonic()
        if self._pidfd is not None and now - self._woken > WAKE_SECONDS:
            self._woken = now
            try:
                signal.pidfd_send_signal(self._pidfd, signal.SIGCONT)
            except OSError:
                return
