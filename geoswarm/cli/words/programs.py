"""A run of a program of the user's, as commands tell it."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from geoswarm.solver.external.trial import TrialRun

__all__ = ["facts_of_run"]

_FILES = 10


def facts_of_run(run: TrialRun) -> dict[str, str]:
    """What happened, in a few lines."""
    return {
        "call": " ".join(run.call),
        "run folder": str(run.folder),
        "written": _listed(run.written),
        "made by it": _listed(run.made),
        "ended": run.ended or "was not started",
    }


def _listed(names: tuple[str, ...]) -> str:
    """Names of files, the first ones of many."""
    more = f" and {len(names) - _FILES} more" if len(names) > _FILES else ""
    return (", ".join(names[:_FILES]) or "nothing") + more
