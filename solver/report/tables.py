"""Result, evaluations and generations as files that other programs read."""

from __future__ import annotations

import csv
import json
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from geoswarm.solver.local import CalibrationResult
from geoswarm.solver.problem import Problem
from geoswarm.solver.report.record import Optimum
from geoswarm.solver.versions import versions

__all__ = [
    "parameter_column",
    "result_document",
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


def result_document(problem: Problem, result: CalibrationResult, optimum: Optimum | None = None) -> dict[str, Any]:
    """Return the whole result but its history, JSON-able; values in base units.

    ``objective`` and ``parameters`` are the best of the search. Where the report polished them, ``polished`` has the
    parameters that fit better, and how many further runs it took.
    """
    best = result.best
    polished = None if optimum is None else optimum.polished
    return {
        "name": problem.name,
        "state": result.state,
        "stop_reasons": list(result.stop_reasons),
        "objective": result.objective,
        "parameters": result.parameters,
        "evaluations": result.evaluations,
        "failed_evaluations": result.failed_evaluations,
        "generations": result.generations,
        "seconds": result.seconds,
        "seed": result.seed,
        "error": result.error,
        "versions": dict(versions()),
        "polished": polished
        and {
            "objective": polished.objective,
            "parameters": problem.values(polished.parameters.tolist()),
            "evaluations": polished.evaluations,
        },
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


def write_result(path: Path, problem: Problem, result: CalibrationResult, optimum: Optimum | None = None) -> None:
    """Write :func:`result_document` as JSON."""
    _write_json(path, result_document(problem, result, optimum))


def write_problem(path: Path, problem: Problem, seed: int) -> None:
    """Write the canonical problem with the seed that was used: running it again needs no other file."""
    _write_json(path, problem.document() | {"seed": seed})


def write_evaluations(path: Path, problem: Problem, result: CalibrationResult) -> None:
    """Write one row an evaluation: place, outcome, free parameters, misfit of each series, why it failed.

    Same columns as the CSV export of a service, without what only a service knows (attempts, worker, times).
    """
    series = [o.series for o in problem.observations]
    before, after = ("generation", "particle", "state", "objective"), ("reason", "message", "seconds")
    parameters = [parameter_column(name) for name in problem.free_names]
    header = [*before, *parameters, *(f"misfit.{name}" for name in series), *after]

    def rows() -> Iterable[Sequence[object]]:
        for record in result.history:
            e = record.evaluation
            state = "finished" if e.reason is None else "failed"
            misfits = [e.misfits.get(name) for name in series]
            place = [record.generation, record.particle, state, e.objective]
            yield [*place, *e.parameters.tolist(), *misfits, e.reason, e.message, e.seconds]

    _write_csv(path, header, rows())


def write_responses(path: Path, problem: Problem, result: CalibrationResult) -> None:
    """Write the responses of the successful evaluations as a NumPy archive, for statistics and other weights later.

    Arrays ``generation`` and ``particle``, shape (n,), and ``response.SERIES``, shape (n, m_g), base units.
    """
    good = [r for r in result.history if r.evaluation.reason is None]
    arrays = {
        f"response.{o.series}": np.array([r.evaluation.responses[o.series] for r in good]).reshape(-1, o.x.size)
        for o in problem.observations
    }
    place = {
        "generation": np.array([r.generation for r in good], dtype=np.int64),
        "particle": np.array([r.particle for r in good], dtype=np.int64),
    }
    np.savez_compressed(path, **place, **arrays)  # type: ignore[arg-type]  # the stubs take any further keyword for an option


def write_generations(path: Path, problem: Problem, result: CalibrationResult) -> None:
    """Write one row a generation: totals so far, its best objective, the best so far with all parameters."""
    names = list(problem.parameters)
    before = ("generation", "evaluations", "failed", "best_objective", "objective")
    header = [*before, *(parameter_column(name, before) for name in names)]

    def rows() -> Iterable[Sequence[object]]:
        for r in result.generation_records:
            values = [None] * len(names) if r.parameters is None else [r.parameters[name] for name in names]
            yield [r.number, r.evaluations, r.failed, r.best_objective, r.objective, *values]

    _write_csv(path, header, rows())


def _write_json(path: Path, data: object) -> None:
    path.write_text(json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n", encoding="utf-8")


def _write_csv(path: Path, header: Sequence[str], rows: Iterable[Sequence[object]]) -> None:
    """Write a CSV file; None becomes an empty cell, numbers keep every digit."""
    with path.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(header)
        writer.writerows(rows)
