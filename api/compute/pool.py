"""The processes for requests that calculate."""

from __future__ import annotations

import asyncio
import logging
from typing import Any

from geoswarm.api.compute.process import ComputeProcess, EndedError
from geoswarm.api.settings import ApiSettings
from geoswarm.workers.hosts.embedded import PipeWaker
from geoswarm.workers.service.job_service import JobService

__all__ = ["ComputePool"]


class ComputePool:
    """Starts processes when they are needed and keeps them; a process serves one caller at a time.

    Parameters
    ----------
    service
        Its settings and waker are what the processes work with, too.
    """

    def __init__(self, service: JobService, settings: ApiSettings) -> None:
        ends: tuple[int, ...] = ()
        if isinstance(service.waker, PipeWaker):
            ends = (service.waker.read_end, service.waker.write_end)
        self._descriptors = ends
        self._given: dict[str, Any] = {
            "settings": service.settings.model_dump(),
            "waker": ends,
            "log_level": logging.getLogger().getEffectiveLevel(),
        }
        self.settings = settings
        self._idle: list[ComputeProcess] = []
        self._all: set[ComputeProcess] = set()
        self._preparing: asyncio.Task[None] | None = None

    @property
    def busy(self) -> int:
        """Processes that work on a request now, or are being started for one."""
        return len(self._all) - len(self._idle)

    def prepare(self) -> None:
        """Begin to start the first process: someone looks at a page, whose next one will ask for it."""
        if not self._all and self._preparing is None:
            self._preparing = asyncio.create_task(self._prepare())

    async def _prepare(self) -> None:
        try:
            self.put_back(await self._started())
        except EndedError:
            pass  # the request that needs one reports it
        finally:
            self._preparing = None

    async def take(self, job: str | None) -> ComputeProcess:
        """Return a process that is ready, if possible one that knows the job.

        Raises
        ------
        EndedError
            When none could be started.
        """
        if not self._idle and self._preparing is not None:
            preparing, self._preparing = self._preparing, None  # the next caller starts another one
            await asyncio.wait({preparing})
        while self._idle:
            known = [process for process in self._idle if job is not None and process.job == job]
            process = known[0] if known else self._idle[-1]
            self._idle.remove(process)
            if process.alive:
                process.job = job
                return process
            await self.discard(process)
        process = await self._started()
        process.job = job
        return process

    async def _started(self) -> ComputeProcess:
        process = ComputeProcess(self._given, self._descriptors)
        self._all.add(process)
        try:
            await process.ready()
        except BaseException:
            await self.discard(process)
            raise
        return process

    def put_back(self, process: ComputeProcess) -> None:
        """Make it available to the next caller."""
        self._idle.append(process)

    async def discard(self, process: ComputeProcess) -> None:
        """End a process that will not be asked again."""
        self._all.discard(process)
        await process.close()

    async def close(self) -> None:
        """End all of them."""
        if self._preparing is not None:
            self._preparing.cancel()
            await asyncio.wait({self._preparing})
        self._idle.clear()
        for process in list(self._all):
            await self.discard(process)
