"""Writes what ``geoswarm run --output`` writes."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from geoswarm.solver.errors import SolverError
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult

if TYPE_CHECKING:
    from geoswarm.solver.report.document.build import Report
    from geoswarm.solver.report.folder.run_folder import RunFolder

__all__ = ["opened_folder", "write_folder"]


def opened_folder(folder: Path, problem: Problem, *, seed: int | None = None, resume: bool = False) -> RunFolder:
    """Prepare a folder for a run, or for the rest of one.

    Raises
    ------
    SolverError
        It cannot be written, or holds another run, or one that is finished.
    """
    from geoswarm.solver.report.folder.run_folder import OtherRunError, open_run_folder

    try:
        opened = open_run_folder(folder, problem, seed=seed, offer=None, resume=resume)
    except OtherRunError as error:
        raise OtherRunError(str(error).replace("--resume", "calibrate(..., resume=True)")) from None
    if opened is None:
        raise SolverError(
            f"the run in {folder} is finished; read it (geoswarm statistics {folder}), or leave out resume"
        )
    return opened


def write_folder(folder: RunFolder, found: CalibrationResult, report: Report | None) -> list[Path]:
    """Write all tables, and the report where there is one; return the files.

    Raises
    ------
    SolverError
        A file cannot be written; the message has its path.
    """
    from geoswarm.solver.report.folder.run_folder import OutputError

    written = folder.finish(found, report)
    if report is None:
        return written
    try:
        return written + report.save(folder.folder)
    except OSError as error:
        raise OutputError(f"{error.filename or folder.folder}: {error.strerror or error}") from error
