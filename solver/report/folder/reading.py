"""A run from the files that ``geoswarm run --output`` wrote."""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import SolverError
from geoswarm.solver.identifiability import Samples
from geoswarm.solver.identifiability.stored.findings import Findings, answer_of, join_findings
from geoswarm.solver.identifiability.stored.posterior import sample_posterior
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.progress.answer import Answer
from geoswarm.solver.progress.result import GenerationRecord
from geoswarm.solver.report.compared import compared_with, read_set
from geoswarm.solver.report.document.build import Report, linearise_stored
from geoswarm.solver.report.folder.folder_findings import column, evaluations_of_folder, findings_of_folder, read_table
from geoswarm.solver.report.folder.run_folder import JOURNAL
from geoswarm.solver.report.folder.tables import parameter_column
from geoswarm.solver.report.record import BestFit, RunRecord, record_of_result
from geoswarm.solver.report.uncertainty import Uncertainty
from geoswarm.solver.runs.journal import read_journal
from geoswarm.solver.runs.local import result_so_far

__all__ = ["FolderError", "StoredRun", "all_findings", "report_of_folder", "run_of_folder"]

_NEEDED = ("problem.json", "result.json", "evaluations.csv", "generations.csv")


class FolderError(SolverError):
    """A folder does not hold a run; the message says what is missing."""


@dataclass(frozen=True, slots=True)
class StoredRun:
    """Problem, record and successful evaluations of the search of a run that was written to a folder.

    ``answer``: the runs after the search, with their evaluations.
    """

    problem: Problem
    record: RunRecord
    samples: Samples
    answer: tuple[Answer, list[Evaluation]] | None = None


def run_of_folder(folder: Path) -> StoredRun:
    """Read a run, or what one has found so far whose search has ended.

    Parameters
    ----------
    folder
        With run.journal, or with problem.json, result.json, evaluations.csv, generations.csv; with responses.npz the
        evaluations can also be re-weighted point by point.

    Raises
    ------
    FolderError
        When a file is missing or cannot be read.
    """
    if (folder / JOURNAL).is_file():
        return _run_so_far(folder)
    missing = [name for name in _NEEDED if not (folder / name).is_file()]
    if missing:
        raise FolderError(
            f"{folder} lacks {', '.join(missing)}; a folder that 'geoswarm run PROBLEM --output DIR' wrote is accepted"
        )
    try:
        problem = parse_problem(json.loads((folder / "problem.json").read_text(encoding="utf-8")), programs=True)
        result = json.loads((folder / "result.json").read_text(encoding="utf-8"))
        rows = read_table(folder / "evaluations.csv")
        record = _record(problem, result, rows, read_table(folder / "generations.csv"))
        samples, after = _samples(problem, rows, folder / "responses.npz"), None
        if result.get("answer") is not None:
            answer = Answer.from_plan(result["answer"])
            samples = samples.select(samples.generations < answer.generation)
            after = answer, evaluations_of_folder(folder, problem)[answer.evaluations :]
    except (KeyError, ValueError, TypeError, IndexError) as error:
        raise FolderError(f"{folder} cannot be read as a run: {type(error).__name__}: {error}") from error
    return StoredRun(problem, record, samples, after)


def _run_so_far(folder: Path) -> StoredRun:
    """Read a journal: nothing is said of an unfinished search, but of its answer what there is."""
    remedy = f"'geoswarm run {folder / 'problem.json'} --output {folder} --resume' continues"
    try:
        stored = read_journal(folder / JOURNAL)
        result = problem = None
        if stored is not None:
            problem = parse_problem({**stored.run.problem, "seed": stored.run.seed}, programs=True)
            result = result_so_far(problem, stored)
    except (KeyError, ValueError, TypeError, OSError) as error:
        raise FolderError(f"{folder / JOURNAL} cannot be read: {type(error).__name__}: {error}") from error
    if problem is None or result is None or (result.answer is None and not result.stop_reasons):
        raise FolderError(f"{folder} holds a search that was interrupted or is still running; {remedy} it")
    record, answer = replace(record_of_result(problem, result), finished_at=None, versions=None), result.answer
    if not result.stop_reasons:
        record = replace(record, warnings=(f"runs for minimum and intervals are missing: {remedy} them",))
    samples = Samples.from_result(problem, result)
    if answer is None:
        return StoredRun(problem, record, samples)
    return StoredRun(problem, record, samples, (answer, [e.evaluation for e in result.history[answer.evaluations :]]))


def report_of_folder(
    folder: Path,
    *,
    threshold: float | None = None,
    noise: Mapping[str, float] | float | None = None,
    posterior: bool = False,
    compare: Path | None = None,
) -> Report:
    """Make the report of a run that was written to a folder, with what its follow-ups have found.

    Parameters
    ----------
    threshold
        Objective up to which a fit is good; proposed when None.
    noise
        Known standard deviation of a reading, base units.
    posterior
        Sample the posterior, too.
    compare
        File with another set of parameters, to be shown beside the result.

    Raises
    ------
    FolderError
        When a file is missing or cannot be read.
    ProblemError
        When the other set has mistakes.
    StatisticsError
        When threshold or noise are wrong, or no posterior sample can be had.
    """
    stored = run_of_folder(folder)
    problem, samples, seed = stored.problem, stored.samples, stored.record.seed
    findings = all_findings(folder, stored, noise=noise)
    found = findings.linearisation or linearise_stored(problem, samples, seed, noise=noise)
    sample = sample_posterior(Calibration(problem, seed), samples, noise=noise) if posterior else None
    return Report(
        problem,
        stored.record,
        samples,
        threshold=threshold,
        linearisation=found,
        noise=noise,
        uncertainty=Uncertainty(findings, sample),
        compared=None if compare is None else compared_with(problem, *read_set(compare)),
    )


def all_findings(folder: Path, stored: StoredRun, *, noise: Mapping[str, float] | float | None = None) -> Findings:
    """Return what a run in a folder has found after its search, and its follow-ups there.

    Raises
    ------
    FolderError
        When a follow-up cannot be read.
    StatisticsError
        When the noise is wrong.
    """
    try:
        findings = findings_of_folder(folder, stored.problem, noise=noise)
        if stored.answer is None:
            return findings
        calibration = Calibration(stored.problem, stored.record.seed)
        return join_findings([findings, answer_of(calibration, *stored.answer, noise=noise)])
    except (KeyError, ValueError, TypeError) as error:
        raise FolderError(f"follow-ups in {folder} cannot be read: {type(error).__name__}: {error}") from error


def _record(
    problem: Problem, result: Mapping[str, Any], rows: list[dict[str, str]], generations: list[dict[str, str]]
) -> RunRecord:
    best = result["best"]
    return RunRecord(
        id=None,
        state=result["state"],
        stop_reasons=tuple(result["stop_reasons"]),
        error=result["error"],
        evaluations=result["evaluations"],
        failed=result["failed_evaluations"],
        generations=result["generations"],
        failures=dict(Counter(row["reason"] for row in rows if row["reason"])),
        seconds=result["seconds"],
        seed=result["seed"],
        best=best
        and BestFit(
            best["generation"],
            best["particle"],
            result["objective"],
            result["parameters"],
            best["misfits"],
            {series: np.array(xy["y"], dtype=np.float64) for series, xy in best["responses"].items()},
        ),
        records=[_generation(problem, row) for row in generations],
        versions=result.get("versions"),  # older runs have none
    )


def _generation(problem: Problem, row: Mapping[str, str]) -> GenerationRecord:
    taken = ("generation", "evaluations", "failed", "best_objective", "objective")
    cells = {name: row[parameter_column(name, taken)] for name in problem.parameters}
    return GenerationRecord(
        int(row["generation"]),
        int(row["evaluations"]),
        int(row["failed"]),
        _number(row["best_objective"]),
        _number(row["objective"]),
        {name: float(cell) for name, cell in cells.items()} if all(cells.values()) else None,
    )


def _samples(problem: Problem, rows: list[dict[str, str]], archive: Path) -> Samples:
    good = [row for row in rows if row["state"] == "finished"]
    responses: dict[str, FloatArray] = {}
    if archive.is_file():
        with np.load(archive, allow_pickle=False) as stored:
            if len(stored["generation"]) == len(good):
                responses = {o.series: stored[f"response.{o.series}"] for o in problem.observations}
    names = [parameter_column(name) for name in problem.free_names]
    return Samples.from_arrays(
        problem,
        np.array([[float(row[name]) for name in names] for row in good], dtype=np.float64),
        np.array([float(row["objective"]) for row in good], dtype=np.float64),
        misfits={o.series: column(good, f"misfit.{o.series}") for o in problem.observations},
        responses=responses,
        generations=np.array([int(row["generation"]) for row in good], dtype=np.int64),
        particles=np.array([int(row["particle"]) for row in good], dtype=np.int64),
        failed=len(rows) - len(good),
    )


def _number(text: str) -> float | None:
    return float(text) if text else None
