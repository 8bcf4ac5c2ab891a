"""Runs follow-ups: here, kept in the folder of the run, or as a job of a service that is waited for."""

from __future__ import annotations

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
    from geoswarm.solver.report.folder import tables
    from geoswarm.solver.runs.local import calibrate

    ready(problem)
    with progress_bar(problem.name, problem.planned_evaluations) as update:
        result = calibrate(
            problem,
            workers=workers,
            on_generation=lambda record: update(record.evaluations, record.number, record.objective, None, None),
        )
    if folder is not None:
        place = folder / within
        place.mkdir(exist_ok=True, parents=True)
        tables.write_result(place / "result.json", problem, result)
        tables.write_problem(place / "problem.json", problem, result.seed)
        tables.write_evaluations(place / "evaluations.csv", problem, result)
        tables.write_generations(place / "generations.csv", problem, result)
        tables.write_responses(place / "responses.npz", problem, result)
        note(f"Evaluations kept in {place}; 'geoswarm report {folder}' has what they tell.")
    return findings_of(problem, result.seed, [record.evaluation for record in result.history], noise=noise)


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
