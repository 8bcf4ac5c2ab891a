"""What goes over the sockets between a worker and its evaluation process: frames of one JSON object and some bytes."""

from __future__ import annotations

import json
import select
import socket
import struct
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray, pack_array, unpack_array
from geoswarm.solver.calibration import Evaluation

__all__ = [
    "ONCE",
    "ConnectionEnded",
    "Frame",
    "FrameReader",
    "GarbledError",
    "Outcome",
    "pack_outcomes",
    "readable",
    "receive",
    "send",
    "unpack_outcomes",
]

HEADER = struct.Struct("!8sQqqII")
"""Mark, nonce, index, process, and the lengths [byte] of the JSON text and of the body."""
MARK = b"geoswarm"
LONGEST_HEAD = 2**26
LONGEST_BODY = 2**30
ONCE = 1 << 16


class ConnectionEnded(Exception):  # noqa: N818  says what it is
    """The other side has closed the connection or died."""


class GarbledError(Exception):
    """What came over the connection is not a valid frame."""


@dataclass(frozen=True, slots=True)
class Frame:
    """One message.

    Parameters
    ----------
    nonce
        Number of the request, drawn anew for each; an answer carries that of its request.
    index
        Place of the first position that it is about, within its request.
    pid
        The evaluation process that is asked, or that answers.
    """

    nonce: int
    index: int
    pid: int
    head: Mapping[str, Any]
    body: bytes = b""

    def packed(self) -> bytes:
        """Return its bytes."""
        text = json.dumps(self.head, separators=(",", ":")).encode()
        header = HEADER.pack(MARK, self.nonce, self.index, self.pid, len(text), len(self.body))
        return header + text + self.body


class FrameReader:
    """Puts frames together from the bytes that have come, however they are cut; holds as much as one may be long."""

    def __init__(self) -> None:
        self._bytes = bytearray()

    def __bool__(self) -> bool:
        """Whether a frame has begun and not ended."""
        return bool(self._bytes)

    def feed(self, data: bytes) -> None:
        """Take in bytes in their order."""
        self._bytes += data

    def frame(self) -> Frame | None:
        """Return the next frame, None while it is not complete.

        Raises
        ------
        GarbledError
            For what is not a frame, or one that is longer than any of ours.
        """
        found = self._bytes
        if not MARK.startswith(found[: len(MARK)]):
            raise GarbledError
        if len(found) < HEADER.size:
            return None
        _, nonce, index, pid, head, body = HEADER.unpack_from(found)
        if head > LONGEST_HEAD or body > LONGEST_BODY:
            raise GarbledError
        start, end = HEADER.size + head, HEADER.size + head + body
        if len(found) < end:
            return None
        try:
            values = json.loads(found[HEADER.size : start])
        except ValueError:
            raise GarbledError from None
        if not isinstance(values, dict):
            raise GarbledError
        frame = Frame(nonce, index, pid, values, bytes(found[start:end]))
        del found[:end]
        return frame


def readable(source: socket.socket | int, seconds: float) -> bool:
    """Whether something is to be read, or has ended, within a time [s]; for descriptors of any number."""
    poll = select.poll()
    poll.register(source, select.POLLIN)
    return bool(poll.poll(1000.0 * seconds))


def send(connection: socket.socket, frame: Frame) -> None:
    """Send a frame over a connection that waits.

    Raises
    ------
    ConnectionEnded
    """
    try:
        connection.sendall(frame.packed())
    except (BrokenPipeError, ConnectionResetError):
        raise ConnectionEnded from None


def receive(connection: socket.socket, reader: FrameReader) -> Frame:
    """Wait for the next frame.

    Raises
    ------
    ConnectionEnded, GarbledError
    """
    while (frame := reader.frame()) is None:
        try:
            data = connection.recv(ONCE)
        except ConnectionResetError:
            data = b""
        if not data:
            raise ConnectionEnded
        reader.feed(data)
    return frame


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
