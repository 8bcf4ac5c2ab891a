"""A proxy in front of Redis that loses some messages to workers and delivers others twice.

It understands enough of RESP to tell one command from the next and one reply from the next. Only ``LPUSH`` to a queue
of tasks is touched: a dropped one is answered as if it had been stored, a doubled one is sent twice and answered once.
Everything else passes as it came.
"""

from __future__ import annotations

import asyncio
import contextlib
import random
import threading
from collections import Counter, deque
from types import TracebackType
from typing import Self

from geoswarm.workers.hosts.celery_app import QUEUE

__all__ = ["LossyProxy", "split_frames"]

STORED = b":1\r\n"
ONE_LINE = b"+-:_,#("
SIZED = b"$!="
LISTS = b"*~>"
MAPS = b"%|"
ONCE = 1 << 16


def split_frames(buffer: bytearray) -> list[bytes]:
    """Take the complete RESP values (commands or replies) from the beginning of a buffer."""
    frames: list[bytes] = []
    while (end := _end_of_value(buffer, 0)) is not None:
        frames.append(bytes(buffer[:end]))
        del buffer[:end]
    return frames


def _end_of_value(buffer: bytearray, start: int) -> int | None:
    """Return where the value that begins at ``start`` ends, None: it is not complete."""
    line_end = buffer.find(b"\r\n", start)
    if line_end < 0:
        return None
    kind, after = buffer[start], line_end + 2
    if kind in ONE_LINE:
        return after
    count = int(buffer[start + 1 : line_end])
    if count < 0:
        return after
    if kind in SIZED:
        end = after + count + 2
        return end if end <= len(buffer) else None
    if kind not in LISTS + MAPS:
        raise ValueError(f"no RESP value begins with {chr(kind)!r}")
    position: int | None = after
    for _ in range(count * (2 if kind in MAPS else 1)):
        if position is None:
            return None
        position = _end_of_value(buffer, position)
    return position


class _Conversation:
    """One client's connection: what becomes of each command, and of the replies in their order."""

    def __init__(self, proxy: LossyProxy) -> None:
        self.proxy = proxy
        self.replies: deque[bytes | bool] = deque()  # True: pass the next reply on, False: swallow it, else: say this
        self.in_transaction = False

    def command(self, frame: bytes) -> bytes:
        """Return what is sent to the server for a command."""
        name, key = _name_and_key(frame)
        if name == b"MULTI":
            self.in_transaction = True
        elif name in (b"EXEC", b"DISCARD"):
            self.in_transaction = False
        if name == b"LPUSH" and key.startswith(QUEUE.encode()) and not self.in_transaction:
            match self.proxy.fate():
                case "dropped":
                    self.replies.append(STORED)
                    return b""
                case "doubled":
                    self.replies += (True, False)
                    return frame + frame
        self.replies.append(True)
        return frame

    def reply(self, frame: bytes) -> bytes:
        """Return what the client is told for a reply, one that nothing asked for (a push) included."""
        return frame if not self.replies or self.replies.popleft() else b""

    def invented(self) -> bytes:
        """Return the replies that the server will not give and whose turn it is."""
        said = b""
        while self.replies and isinstance(self.replies[0], bytes):
            said += self.replies.popleft()  # type: ignore[operator]
        return said


def _name_and_key(frame: bytes) -> tuple[bytes, bytes]:
    parts = frame.split(b"\r\n", 5)
    return parts[2].upper(), parts[4] if len(parts) > 4 else b""


class LossyProxy:
    """Listens on a port of 127.0.0.1 of its own, in a thread of its own; ``counts`` tells what it has done.

    Parameters
    ----------
    target
        Port of the Redis server, which may be down now and then: clients then see closed connections.
    dropped, doubled
        Shares of the messages.
    """

    def __init__(self, target: int, chance: random.Random, *, dropped: float = 0.05, doubled: float = 0.05) -> None:
        self.counts: Counter[str] = Counter()
        self.port = 0
        self._target = target
        self._chance = chance
        self._dropped, self._doubled = dropped, doubled
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._done = asyncio.Event()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=(self._serve(),), daemon=True)

    def fate(self) -> str:
        """Decide about one message."""
        number = self._chance.random()
        fate = (
            "dropped" if number < self._dropped else "doubled" if number < self._dropped + self._doubled else "passed"
        )
        self.counts[fate] += 1
        return fate

    def __enter__(self) -> Self:
        self._thread.start()
        assert self._ready.wait(60.0)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._loop.call_soon_threadsafe(self._done.set)
        self._thread.join(60.0)
        self._loop.close()

    async def _serve(self) -> None:
        server = await asyncio.start_server(self._talk, "127.0.0.1", 0)
        self.port = server.sockets[0].getsockname()[1]
        self._ready.set()
        await self._done.wait()
        server.close()
        others = asyncio.all_tasks() - {asyncio.current_task()}
        for task in others:
            task.cancel()
        await asyncio.gather(*others, return_exceptions=True)

    async def _talk(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        try:
            from_server, to_server = await asyncio.open_connection("127.0.0.1", self._target)
        except OSError:
            writer.close()
            return
        conversation = _Conversation(self)
        there = asyncio.create_task(self._commands(conversation, reader, to_server, writer))
        back = asyncio.create_task(self._replies(conversation, from_server, writer))
        with contextlib.suppress(asyncio.CancelledError):
            await asyncio.wait((there, back), return_when=asyncio.FIRST_COMPLETED)
        there.cancel()
        back.cancel()
        for end in (to_server, writer):
            end.close()

    async def _commands(
        self,
        conversation: _Conversation,
        reader: asyncio.StreamReader,
        to_server: asyncio.StreamWriter,
        writer: asyncio.StreamWriter,
    ) -> None:
        buffer = bytearray()
        with contextlib.suppress(ConnectionError):
            while part := await reader.read(ONCE):
                buffer += part
                to_server.write(b"".join(conversation.command(frame) for frame in split_frames(buffer)))
                writer.write(conversation.invented())
                await to_server.drain()

    async def _replies(
        self, conversation: _Conversation, from_server: asyncio.StreamReader, writer: asyncio.StreamWriter
    ) -> None:
        buffer = bytearray()
        with contextlib.suppress(ConnectionError):
            while part := await from_server.read(ONCE):
                buffer += part
                for frame in split_frames(buffer):
                    writer.write(conversation.reply(frame) + conversation.invented())
                await writer.drain()
