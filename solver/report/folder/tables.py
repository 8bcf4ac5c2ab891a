"""Result, evaluations and generations as files that other programs read."""

from __future__ import annotations

import csv
import json
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.parameter_estimates.classical import classical_values
from geoswarm.solver.parameter_estimates.index import estimates_of, index_document
from geoswarm.solver.problem import Problem
from geoswarm.solver.progress.result import CalibrationResult, EvaluationRecord, GenerationRecord
from geoswarm.solver.report.document.laboratory import calculated_values
from geoswarm.solver.report.document.laboratory_table import laboratory_document
from geoswarm.solver.report.terms import values_in_terms
from geoswarm.solver.system.versions import versions
from geoswarm.solver.words import csv_cell

if TYPE_CHECKING:
    from geoswarm.solver.identifiability import Statistics

__all__ = [
    "evaluation_header",
    "evaluation_row",
    "generation_header",
    "generation_row",
    "parameter_column",
    "result_document",
    "summary_document",
    "write_evaluations",
    "write_generations",
    "write_problem",
    "write_responses",
    "write_result",
]

_TAKEN = frozenset(
    {"generation", "particle", "state", "objective", "reason", "message", "attempts", "worker"}
    | {"started_at", "finished_at", "seconds"}
)
"""Columns that a parameter of the same name must not shadow."""


def parameter_column(name: str, taken: Collection[str] = _TAKEN) -> str:
    """Return the column of a parameter; one that is called like another column gets the prefix ``parameter.``."""
    return f"parameter.{name}" if name in taken else name


def summary_document(problem: Problem, result: CalibrationResult, statistics: Statistics | None) -> dict[str, Any]:
    """Return what a search has found, JSON-able; values in base units.

    ``objective`` and ``parameters`` are the best of all runs, ``search_best`` those of the search where further runs
    followed it. ``intervals`` has the 95 % interval of each free parameter or None, ``verdicts`` the kind of its
    verdict.
    """
    return {
        "state": result.state,
        "stop_reasons": list(result.stop_reasons),
        "objective": result.objective,
        "parameters": result.parameters,
        "intervals": None if statistics is None else statistics.intervals,
        "verdicts": None if statistics is None else statistics.kinds,
        "search_best": None if result.answer is None else result.answer.search_best(problem),
        "evaluations": result.evaluations,
        "generations": result.generations,
        "seconds": result.seconds,
        "seed": result.seed,
    }


def result_document(
    problem: Problem,
    result: CalibrationResult,
    statistics: Statistics | None = None,
) -> dict[str, Any]:
    """Return the whole result but its history, JSON-able; values in base units.

    Beside :func:`summary_document`, ``laboratory`` has the parameters of laboratory tests as Cc, Cs, C_alpha and
    preconsolidation stress.
    """
    best = result.best
    values = result.parameters
    linearisation = None if statistics is None else statistics.linearisation
    return {
        "name": problem.name,
        **summary_document(problem, result, statistics),
        "failed_evaluations": result.failed_evaluations,
        "error": result.error,
        "answer": None if result.answer is None else result.answer.plan(),
        "versions": dict(versions()),
        "laboratory": [] if values is None else laboratory_document(values_in_terms(problem, values, linearisation)),
        "classical": laboratory_document(classical_values(problem)),
        "classical_of_calculated": []
        if values is None or best is None
        else laboratory_document(calculated_values(problem, values, best.responses)),
        "index_properties": index_document(estimates_of(problem)),
        "best": best
        and {
            "generation": result.best_generation,
            "particle": result.best_particle,
            "misfits": best.misfits,
            "responses": {
                o.series: {"x": o.x.tolist(), "y": best.responses[o.series].tolist()} for o in problem.observations
            },
        },
    }


def write_result(
    path: Path,
    problem: Problem,
    result: CalibrationResult,
    statistics: Statistics | None = None,
) -> None:
    """Write :func:`result_document` as JSON."""
    _write_json(path, result_document(problem, result, statistics))


def write_problem(path: Path, problem: Problem, seed: int) -> None:
    """Write the canonical problem with the seed that was used: running it again needs no other file."""
    _write_json(path, problem.document() | {"seed": seed})


def evaluation_header(problem: Problem) -> list[str]:
    """Return the columns of evaluations.csv: place, outcome, free parameters, misfit of each series, why it failed.

    Same columns as the CSV export of a service, without what only a service knows (attempts, worker, times).
    """
    parameters = [parameter_column(name) for name in problem.free_names]
    misfits = [f"misfit.{o.series}" for o in problem.observations]
    return ["generation", "particle", "state", "objective", *parameters, *misfits, "reason", "message", "seconds"]


def evaluation_row(problem: Problem, generation: int, particle: int, e: Evaluation) -> list[object]:
    """Return one row of evaluations.csv."""
    state = "finished" if e.reason is None else "failed"
    misfits = [e.misfits.get(o.series) for o in problem.observations]
    message = e.message and csv_cell(e.message)
    return [generation, particle, state, e.objective, *e.parameters.tolist(), *misfits, e.reason, message, e.seconds]


def write_evaluations(path: Path, problem: Problem, result: CalibrationResult) -> None:
    """Write one row an evaluation."""
    rows = (evaluation_row(problem, r.generation, r.particle, r.evaluation) for r in result.history)
    _write_csv(path, evaluation_header(problem), rows)


def write_responses(path: Path, problem: Problem, result: CalibrationResult) -> None:
    """Write the responses of the successful evaluations as a NumPy archive, for statistics and other weights later.

    Arrays ``generation`` and ``particle``, shape (n,), and ``response.SERIES``, shape (n, m_g), base units; the same
    behind ``partial.`` of predictions of which a test failed, nan for its series.
    """
    good = [r for r in result.history if r.evaluation.reason is None]
    arrays = _archived(problem, good)
    partial = [r for r in result.history if r.evaluation.reason is not None and r.evaluation.responses]
    if partial:
        arrays |= {f"partial.{name}": values for name, values in _archived(problem, partial).items()}
    np.savez_compressed(path, **arrays)  # type: ignore[arg-type]  # the stubs take any further keyword for an option


def _archived(problem: Problem, records: Sequence[EvaluationRecord]) -> dict[str, npt.NDArray[Any]]:
    """Arrays of :func:`write_responses` for some evaluations."""
    arrays: dict[str, npt.NDArray[Any]] = {
        "generation": np.array([r.generation for r in records], dtype=np.int64),
        "particle": np.array([r.particle for r in records], dtype=np.int64),
    }
    for o in problem.observations:
        nothing = np.full(o.x.size, np.nan)
        found = [r.evaluation.responses.get(o.series, nothing) for r in records]
        arrays[f"response.{o.series}"] = np.array(found).reshape(-1, o.x.size)
    return arrays


_OF_GENERATIONS = ("generation", "evaluations", "failed", "best_objective", "objective")


def generation_header(problem: Problem) -> list[str]:
    """Return the columns of generations.csv: totals so far, its best objective, the best so far with all parameters."""
    return [*_OF_GENERATIONS, *(parameter_column(name, _OF_GENERATIONS) for name in problem.parameters)]


def generation_row(problem: Problem, r: GenerationRecord) -> list[object]:
    """Return one row of generations.csv."""
    values = [None if r.parameters is None else r.parameters[name] for name in problem.parameters]
    return [r.number, r.evaluations, r.failed, r.best_objective, r.objective, *values]


def write_generations(path: Path, problem: Problem, result: CalibrationResult) -> None:
    """Write one row a generation."""
    _write_csv(path, generation_header(problem), (generation_row(problem, r) for r in result.generation_records))


def _write_json(path: Path, data: object) -> None:
    path.write_text(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file; None becomes an empty cell, numbers keep every digit."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
