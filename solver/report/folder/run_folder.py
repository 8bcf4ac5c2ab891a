"""The folder of ``geoswarm run --output``: written during the run, so that an interrupted run can continue."""

from __future__ import annotations

import csv
import hashlib
import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation, WarmStartRuns, choose_seed
from geoswarm.solver.course import Course
from geoswarm.solver.errors import SolverError
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult, generation_record
from geoswarm.solver.progress.state import Progress, Step
from geoswarm.solver.report.folder.tables import (
    evaluation_header,
    evaluation_row,
    generation_header,
    generation_row,
    write_evaluations,
    write_generations,
    write_problem,
    write_responses,
    write_result,
)
from geoswarm.solver.runs.journal import Journal, RunIdentity, Stored, read_journal

if TYPE_CHECKING:
    from geoswarm.solver.report.document.build import Report

__all__ = ["JOURNAL", "OtherRunError", "OutputError", "RunFolder", "open_run_folder"]

JOURNAL = "run.journal"
"""In the folder until the run is finished: everything that has been run."""

_SHORT_ANSWER = 60.0
"""Runs after a search that take less than this [s] are waited for: a report takes seconds, too."""

_LEFT_BY_AN_EARLIER_RUN = ("result.json", "responses.npz", "report.html", "report.pdf")


class OutputError(SolverError):
    """A file of a run cannot be written; the message has its path and the reason."""


class OtherRunError(SolverError):
    """A folder holds a run that was cut off, and is not the one that is to be written there."""


class RunFolder(Journal):
    """What a run writes, as it goes: problem.json, the journal, after each generation the two tables, then its result.

    Parameters
    ----------
    stored
        What an earlier part of this run left.

    Raises
    ------
    OutputError
        When a file cannot be written, here and in every method that keeps something.
    """

    def __init__(self, folder: Path, problem: Problem, run: RunIdentity, stored: Stored | None) -> None:
        self.folder, self.problem, self.run = folder, problem, run
        self.kept = 0
        with _writing(folder):
            folder.mkdir(parents=True, exist_ok=True)
        with _writing(folder / JOURNAL):
            super().__init__(folder / JOURNAL, run, stored)
        if stored is not None:
            self.kept = len(stored.evaluations)
        try:
            self._begin_tables(stored is None)
        except BaseException:
            self.close()
            raise

    def _begin_tables(self, anew: bool) -> None:
        folder = self.folder
        with _writing(folder / "problem.json"):
            write_problem(folder / "problem.json", self.problem, self.run.seed)
            for name in _LEFT_BY_AN_EARLIER_RUN if anew else ():
                (folder / name).unlink(missing_ok=True)
        self._tables = {
            "evaluations.csv": _Table(folder / "evaluations.csv", evaluation_header(self.problem)),
            "generations.csv": _Table(folder / "generations.csv", generation_header(self.problem)),
        }

    def start(self, course: Course, slots: int) -> Progress:
        """Return the search at its start, as it was then."""
        with _writing(self.path):
            return super().start(course, slots)

    def finished(self, position: FloatArray, evaluation: Evaluation, seconds: float) -> None:
        """Append an outcome to the journal."""
        with _writing(self.path):
            super().finished(position, evaluation, seconds)
        self.kept += 1

    def closed(self, generation: int, evaluations: Sequence[Evaluation], step: Step, seconds: float) -> None:
        """Append a generation to the journal and the tables."""
        with _writing(self.path):
            super().closed(generation, evaluations, step, seconds)
        rows = [evaluation_row(self.problem, generation, i, e) for i, e in enumerate(evaluations)]
        self._tables["evaluations.csv"].append(rows)
        record = generation_record(self.problem, generation, [e.objective for e in evaluations], step.progress)
        self._tables["generations.csv"].append([generation_row(self.problem, record)])

    def search_ended(self, result: CalibrationResult, *, figures: bool) -> bool:
        """Write what a search has found, without intervals and as ``running``; return whether it is written.

        Not where as many runs as may follow take less than a minute, at the pace of the search.
        """
        answer = result.answer
        if answer is None or answer.most * result.seconds < _SHORT_ANSWER * result.evaluations:
            return False
        self.finish(result)
        if figures:
            from geoswarm.solver.report.document.build import report_of_result

            with _writing(self.folder):
                report_of_result(self.problem, result).save(self.folder)
        return True

    def finish(self, result: CalibrationResult, report: Report | None = None) -> list[Path]:
        """Write all tables of a result and return their files; the journal stays until :meth:`complete`.

        ``report``: its intervals and verdicts, and what it found beyond the search.
        """
        statistics = None if report is None else report.statistics
        writers: dict[str, Callable[[Path], None]] = {
            "result.json": lambda path: write_result(path, self.problem, result, statistics),
            "problem.json": lambda path: write_problem(path, self.problem, result.seed),
            "evaluations.csv": lambda path: write_evaluations(path, self.problem, result),
            "generations.csv": lambda path: write_generations(path, self.problem, result),
            "responses.npz": lambda path: write_responses(path, self.problem, result),
        }
        for name, write in writers.items():
            with _writing(self.folder / name):
                write(self.folder / name)
        return [self.folder / name for name in writers]

    def complete(self) -> None:
        """Drop the journal: everything in it is written elsewhere."""
        self.close()
        with _writing(self.path):
            self.path.unlink(missing_ok=True)


class _Table:
    """A CSV file that grows."""

    def __init__(self, path: Path, header: Sequence[object]) -> None:
        self.path = path
        with _writing(path), path.open("w", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerow(header)

    def append(self, rows: Sequence[Sequence[object]]) -> None:
        with _writing(self.path), self.path.open("a", newline="", encoding="utf-8") as stream:
            csv.writer(stream, lineterminator="\n").writerows(rows)


def open_run_folder(
    folder: Path, problem: Problem, *, seed: int | None, offer: WarmStartRuns | None, resume: bool
) -> RunFolder | None:
    """Make a folder ready for a run, or for the rest of one that was cut off there.

    None with ``resume`` where the run is finished. With ``resume`` and nothing to go on from, the run begins.

    Parameters
    ----------
    seed
        Instead of the problem's.

    Raises
    ------
    OtherRunError
        When a run that was cut off is there and is not to go on, or is another one.
    OutputError
        When the folder cannot be written.
    """
    document = {name: value for name, value in problem.document().items() if name != "seed"}
    wanted = problem.seed if seed is None else seed
    try:
        stored = read_journal(folder / JOURNAL)
    except (ValueError, KeyError, TypeError) as error:
        raise OtherRunError(f"{folder / JOURNAL} cannot be read ({error}); delete it to start over") from error
    except OSError as error:
        raise OutputError(f"{folder / JOURNAL}: {error.strerror}") from error
    if stored is None:
        if resume and _ended(folder / "result.json"):
            return None
        return RunFolder(folder, problem, RunIdentity(document, choose_seed(wanted), _digest(offer)), None)
    if not resume:
        raise OtherRunError(
            f"{folder} holds {len(stored.evaluations)} runs of an interrupted calibration: --resume continues "
            f"it; to start over, delete {folder / JOURNAL} or give another folder"
        )
    run = RunIdentity(document, stored.run.seed if wanted is None else wanted, _digest(offer))
    different = stored.run.differences(run)
    if different:
        raise OtherRunError(
            f"{folder} holds an interrupted calibration with another {', '.join(different)}; --resume needs "
            f"the problem that it started with: {folder / 'problem.json'}"
        )
    return RunFolder(folder, problem, run, stored)


def _ended(result: Path) -> bool:
    """Whether a run has written its last result: not that of its search, whose journal was deleted to start over."""
    try:
        return bool(json.loads(result.read_text(encoding="utf-8"))["state"] != "running")
    except FileNotFoundError:
        return False
    except (OSError, ValueError, KeyError, TypeError):
        return True  # what is wrong with it is said where it is shown


def _digest(offer: WarmStartRuns | None) -> str | None:
    if offer is None:
        return None
    found = hashlib.sha256(offer.parameters.tobytes())
    for responses in offer.responses:
        for name in sorted(responses):
            found.update(responses[name].tobytes())
    return found.hexdigest()


@contextmanager
def _writing(path: Path) -> Iterator[None]:
    try:
        yield
    except OSError as error:
        raise OutputError(f"{error.filename or path}: {error.strerror or error}") from error
