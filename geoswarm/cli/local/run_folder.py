"""The folder of ``geoswarm run --output``: what is there, what is kept, how to go on."""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from geoswarm.cli.service.progress import counted
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.output import duration, echo_facts, echo_json, note, number, reasons_in_words
from geoswarm.cli.words.result import show_fit, show_values

if TYPE_CHECKING:
    from geoswarm.solver.calibration import WarmStartRuns
    from geoswarm.solver.problem import Problem
    from geoswarm.solver.progress.result import CalibrationResult
    from geoswarm.solver.report.document.build import Report
    from geoswarm.solver.report.folder.run_folder import RunFolder

__all__ = ["kept", "open_folder", "show_finished", "write_output"]

_SUMMARY = (
    *("state", "stop_reasons", "objective", "parameters", "intervals", "verdicts", "search_best"),
    *("evaluations", "generations", "seconds", "seed"),
)


def open_folder(
    folder: Path, problem: Problem, seed: int | None, offer: WarmStartRuns | None, resume: bool
) -> RunFolder | None:
    """Make the folder of a run ready; None when a run to go on with is finished already.

    Raises
    ------
    BadInputError
        When the folder holds another run, or cannot be written.
    """
    from geoswarm.solver.report.folder.run_folder import OtherRunError, OutputError, open_run_folder

    try:
        opened = open_run_folder(folder, problem, seed=seed, offer=offer, resume=resume)
    except (OtherRunError, OutputError) as error:
        raise BadInputError(f"--output {folder}: {error}") from error
    if resume and opened is not None:
        note(f"continuing after {opened.kept} runs" if opened.kept else "nothing to continue: starting a new run")
    return opened


def show_finished(folder: Path, problem: Problem, as_json: bool) -> None:
    """Show the result of a run that is finished.

    Raises
    ------
    BadInputError
        When it is the run of another problem.
    FailedRunError
        When it had failed.
    """
    try:
        result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        stored = json.loads((folder / "problem.json").read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise BadInputError(f"--resume: {folder} cannot be read as a run: {error}") from error
    wanted = problem.document()
    different = [name for name in wanted if name != "seed" and stored.get(name) != wanted[name]]
    if different or wanted.get("seed") not in (None, stored.get("seed")):
        raise BadInputError(
            f"--resume: {folder} holds a finished run with another {', '.join(different) or 'seed'}; "
            "give another folder, or leave out --resume to overwrite it"
        )
    note(f"the run in {folder} is finished: there is nothing to continue")
    if as_json:
        echo_json({name: result.get(name) for name in _SUMMARY})  # folders of earlier versions lack some
    elif result["parameters"] is not None:
        from geoswarm.cli.words.output import with_unit
        from geoswarm.solver.report.curves import objective_unit
        from geoswarm.solver.report.folder.reading import report_of_folder
        from geoswarm.solver.report.jsonable import jsonable

        statistics = report_of_folder(folder).statistics
        found = None if statistics is None else jsonable(statistics.to_json())
        if found is not None:
            show_fit(found["fit"])
        show_values(problem, result["parameters"], found, problem.name)
        facts = {
            "objective": with_unit(number(result["objective"]), objective_unit(problem)),
            "stopped": reasons_in_words(result["stop_reasons"]),
            "evaluations": str(result["evaluations"]),
            "time of the runs": duration(result["seconds"]),
        }
        echo_facts(None, facts)
    if result["state"] == "failed":
        raise FailedRunError(result["error"] or "no forward run succeeded")


@contextmanager
def kept(folder: RunFolder | None, problem: Path) -> Iterator[None]:
    """When a run is cut off, tell what is kept of it and how to go on.

    Raises
    ------
    FailedRunError
        When a file cannot be written.
    """
    from geoswarm.solver.report.folder.run_folder import OutputError

    if folder is None:
        yield
        return
    remedy = f"'geoswarm run {problem} --output {folder.folder} --resume' continues"
    try:
        yield
    except KeyboardInterrupt:
        note(f"{folder.kept} finished runs are kept in {folder.path}: {remedy}")
        raise
    except OutputError as error:
        raise FailedRunError(
            f"{error}\n{folder.kept} finished runs are kept in {folder.path}: once it can be written, {remedy}"
        ) from error
    except OSError as error:
        where = error.filename or folder.folder
        raise FailedRunError(
            f"{where}: {error.strerror or error}\n"
            f"{folder.kept} finished runs are kept in {folder.path}: once it can be written, {remedy}"
        ) from error
    finally:
        folder.close()


def write_output(result: CalibrationResult, folder: RunFolder, report: Report | None, *, figures: bool) -> list[Path]:
    """Write all files of a result; without figures the tables only."""
    written = folder.finish(result, report)
    if report is not None and figures:
        with counted(f"Writing the report and {len(report.figures.shown)} figures to {folder.folder}") as told:
            written += report.save(folder.folder, told=told)
    folder.complete()
    return written
