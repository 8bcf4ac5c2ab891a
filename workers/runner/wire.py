"""What goes over the sockets between a worker and its evaluation process: frames of one JSON object and some bytes."""

from __future__ import annotations

import json
import mmap
import os
import socket
import struct
import sys
import tempfile
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.workers.store.codec import pack_array, unpack_array

__all__ = [
    "Board",
    "ConnectionEnded",
    "Outcome",
    "anonymous_file",
    "pack_outcomes",
    "receive",
    "send",
    "unpack_outcomes",
]

LENGTHS = struct.Struct("!II")
ONCE = 1 << 16


class ConnectionEnded(Exception):  # noqa: N818  says what it is
    """The other side has closed the connection or died."""


def send(connection: socket.socket, head: Mapping[str, Any], body: bytes = b"") -> None:
    """Send one frame.

    Raises
    ------
    ConnectionEnded
    """
    text = json.dumps(head, separators=(",", ":")).encode()
    try:
        connection.sendall(LENGTHS.pack(len(text), len(body)) + text + body)
    except (BrokenPipeError, ConnectionResetError):
        raise ConnectionEnded from None


def receive(connection: socket.socket) -> tuple[dict[str, Any], bytes]:
    """Wait for one frame.

    Raises
    ------
    ConnectionEnded
    """
    head, body = LENGTHS.unpack(_exactly(connection, LENGTHS.size))
    text = _exactly(connection, head)
    return json.loads(text), _exactly(connection, body)


def _exactly(connection: socket.socket, size: int) -> bytes:
    parts: list[bytes] = []
    while size > 0:
        try:
            part = connection.recv(min(size, ONCE))
        except ConnectionResetError:
            part = b""
        if not part:
            raise ConnectionEnded
        parts.append(part)
        size -= len(part)
    return b"".join(parts)


@dataclass(frozen=True, slots=True)
class Outcome:
    """One evaluation as the evaluation process made it.

    Parameters
    ----------
    log
        End of what the forward model wrote to its standard output and error, when it failed.
    began, ended
        Monotonic time [s].
    """

    evaluation: Evaluation
    log: str | None
    began: float
    ended: float


def pack_outcomes(outcomes: Sequence[Outcome]) -> tuple[list[Any], bytes]:
    """Return JSON values and the float64 bytes of all responses, in order."""
    heads: list[Any] = []
    bodies: list[bytes] = []
    for outcome in outcomes:
        evaluation = outcome.evaluation
        heads.append(
            (
                evaluation.objective,
                evaluation.misfits,
                {name: len(values) for name, values in evaluation.responses.items()},
                evaluation.reason,
                evaluation.message,
                evaluation.seconds,
                outcome.log,
                outcome.began,
                outcome.ended,
            )
        )
        bodies += [pack_array(values) for values in evaluation.responses.values()]
    return heads, b"".join(bodies)


def unpack_outcomes(heads: Sequence[Any], body: bytes, positions: FloatArray) -> list[Outcome]:
    """Invert :func:`pack_outcomes`; ``positions`` has shape (k, d), k at least the number of outcomes."""
    outcomes: list[Outcome] = []
    start = 0
    for head, position in zip(heads, positions, strict=False):
        objective, misfits, lengths, reason, message, seconds, log, began, ended = head
        responses: dict[str, FloatArray] = {}
        for name, length in lengths.items():
            responses[name] = unpack_array(body[start : start + 8 * length])
            start += 8 * length
        parameters = np.array(position, dtype=np.float64)
        evaluation = Evaluation(parameters, objective, misfits, responses, reason, message, seconds)
        outcomes.append(Outcome(evaluation, log, began, ended))
    return outcomes


def anonymous_file() -> int:
    """Return the descriptor of a file without a name, in memory where the system can (a full disk does not matter)."""
    if sys.platform == "linux":
        return os.memfd_create("geoswarm")
    with tempfile.TemporaryFile() as file:
        return os.dup(file.fileno())


class Board:
    """Memory that worker and evaluation process share: which position is being evaluated, since when, and a flag."""

    _STATE = struct.Struct("=qd")
    _SIZE = 64
    _FLAG = 32

    def __init__(self, descriptor: int, *, new: bool) -> None:
        if new:
            os.ftruncate(descriptor, self._SIZE)
        self._memory = mmap.mmap(descriptor, self._SIZE)

    def begin(self, index: int) -> float:
        """Note that a position is begun; return the time [s]."""
        now = time.monotonic()
        self._STATE.pack_into(self._memory, 0, index, now)
        return now

    def idle(self) -> None:
        """Note that nothing is being evaluated."""
        self._STATE.pack_into(self._memory, 0, -1, 0.0)

    @property
    def current(self) -> tuple[int, float]:
        """Index of the position under evaluation, -1 for none, and when it began (monotonic time [s])."""
        index, since = self._STATE.unpack_from(self._memory, 0)
        return index, since

    @property
    def stopped(self) -> bool:
        """Whether the worker wants no more after the position under evaluation."""
        return self._memory[self._FLAG] == 1

    @stopped.setter
    def stopped(self, value: bool) -> None:
        self._memory[self._FLAG] = int(value)

    def close(self) -> None:
        """Unmap it."""
        self._memory.close()
