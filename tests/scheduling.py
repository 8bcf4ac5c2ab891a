"""Which test process gets which file: those of a folder stay together, as they share a browser or servers."""

from __future__ import annotations

from collections import Counter

from xdist.scheduler import LoadFileScheduling
from xdist.workermanage import WorkerController

__all__ = ["FolderScheduling"]


class FolderScheduling(LoadFileScheduling):
    """Whole files, and of the folder that a process is in as long as it has any.

    A process that begins another folder takes the first one in which the fewest processes are. So the browser and the
    servers of a folder are started few times, and tests that wait run beside tests that calculate.
    """

    def _assign_work_unit(self, node: WorkerController) -> None:
        files = {}
        for file in self.workqueue:
            files.setdefault(folder_of(file), file)
        folders = {other: folder_of(list(assigned)[-1]) for other, assigned in self.assigned_work.items() if assigned}
        busy = Counter(folders.values())
        folder = folders.get(node)
        if folder not in files:
            folder = min(files, key=lambda name: busy[name])
        self.workqueue.move_to_end(files[folder], last=False)
        super()._assign_work_unit(node)


def folder_of(file: str) -> str:
    """Return the folder below tests/ that a file is in."""
    return file.split("/")[1]
