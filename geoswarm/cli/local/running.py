"""Runs follow-ups: here, kept in the folder of the run, or as a job of a service that is waited for."""

from __future__ import annotations

from contextlib import closing, nullcontext
from pathlib import Path
from typing import TYPE_CHECKING

from geoswarm.cli.service.progress import progress_bar
from geoswarm.cli.words.error_messages import FailedRunError
from geoswarm.cli.words.kernels import ready
from geoswarm.cli.words.output import note

if TYPE_CHECKING:
    from geoswarm.client import Client, Job
    from geoswarm.solver.identifiability.stored.findings import Findings
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.report.folder.run_folder import RunFolder

__all__ = ["run_here", "wait_for"]


def run_here(
    problem: Problem, workers: int, noise: dict[str, float] | float | None, folder: Path | None, within: str
) -> Findings:
    """Run a follow-up in this process; return what it has found.

    Parameters
    ----------
    folder, within
        Folder of the run that is followed, and the folder in it that keeps the evaluations; None: nothing is kept.
    """
    from geoswarm.solver.identifiability.stored.findings import findings_of
    from geoswarm.solver.runs.local import calibrate

    ready(problem)
    opened = None if folder is None else _opened(folder / within, problem)
    kept = nullcontext() if opened is None else closing(opened)
    with progress_bar(problem.name, problem.planned_evaluations) as update, kept:
        result = calibrate(
            problem,
            workers=workers,
            on_generation=lambda record: update(record.evaluations, record.number, record.objective, None, None),
            keeper=opened,
        )
    if opened is not None:
        opened.finish(result)
        opened.complete()
        note(f"Evaluations kept in {opened.folder}; 'geoswarm report {folder}' evaluates them.")
    return findings_of(problem, result.seed, [record.evaluation for record in result.history], noise=noise)


def _opened(place: Path, problem: Problem) -> RunFolder:
    """The folder of a follow-up: with its runs where the same one was cut off, else empty."""
    from geoswarm.solver.report.folder.run_folder import JOURNAL, OtherRunError, open_run_folder

    cut_off = (place / JOURNAL).is_file()
    try:
        opened = open_run_folder(place, problem, seed=None, offer=None, resume=cut_off)
    except OtherRunError:  # it cannot be asked for any more
        (place / JOURNAL).unlink()
        opened = open_run_folder(place, problem, seed=None, offer=None, resume=False)
    assert opened is not None  # only a finished one is none
    if opened.kept:
        note(f"Continuing after {opened.kept} runs.")
    return opened


def wait_for(client: Client, job: Job) -> Job:
    """Watch a follow-up to its end.

    Raises
    ------
    FailedRunError
        When it does not finish.
    """
    from geoswarm.cli.service.submit import follow

    note(f"Follow-up {job.id}; Ctrl-C stops watching; the job continues.")
    ended = follow(client, job)
    if ended.state != "finished":
        why = f": {ended.error}" if ended.error else ""
        raise FailedRunError(f"follow-up {ended.id} {ended.state}{why}")
    return ended
