"""A TCP proxy whose line can be cut: what is open breaks off, and nobody comes through until it is mended.

It can also be held: what is sent arrives once it is mended.
"""

from __future__ import annotations

import asyncio
import contextlib
import threading
from types import TracebackType
from typing import Self

__all__ = ["CuttableLine"]

ONCE = 1 << 16


class CuttableLine:
    """Listens on a port of 127.0.0.1 of its own, in a thread of its own.

    Parameters
    ----------
    target
        Port of the service, which may be down now and then.
    """

    def __init__(self, target: int) -> None:
        self.port = 0
        self.connections = 0
        self._target = target
        self._cut = False
        self._writers: set[asyncio.StreamWriter] = set()
        self._flows = asyncio.Event()
        self._flows.set()
        self._loop = asyncio.new_event_loop()
        self._ready = threading.Event()
        self._done = asyncio.Event()
        self._thread = threading.Thread(target=self._loop.run_until_complete, args=(self._serve(),), daemon=True)

    def cut(self) -> None:
        """Break off what is open, and let nobody through."""
        self._loop.call_soon_threadsafe(self._break_off)

    def hold(self) -> None:
        """Keep back what is sent."""
        self._loop.call_soon_threadsafe(self._flows.clear)

    def mend(self) -> None:
        """Let through again."""
        self._cut = False
        self._loop.call_soon_threadsafe(self._flows.set)

    def _break_off(self) -> None:
        self._cut = True
        for writer in self._writers:
            writer.transport.abort()

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
        self.connections += 1
        if self._cut:
            writer.transport.abort()
            return
        try:
            from_server, to_server = await asyncio.open_connection("127.0.0.1", self._target)
        except OSError:
            writer.transport.abort()
            return
        ends = {writer, to_server}
        self._writers |= ends
        there = asyncio.create_task(self._pass_on(reader, to_server))
        back = asyncio.create_task(self._pass_on(from_server, writer))
        try:
            with contextlib.suppress(asyncio.CancelledError):
                await asyncio.wait((there, back), return_when=asyncio.FIRST_COMPLETED)
        finally:
            self._writers -= ends
            there.cancel()
            back.cancel()
            for end in ends:
                end.transport.abort()

    async def _pass_on(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        with contextlib.suppress(ConnectionError):
            while part := await reader.read(ONCE):
                await self._flows.wait()
                writer.write(part)
                await writer.drain()
