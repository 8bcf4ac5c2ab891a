"""Tables of a run in a folder, and what its follow-ups have found: each has a folder of its kind inside it."""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Evaluation
from geoswarm.solver.identifiability.stored.findings import Findings, findings_of, join_findings
from geoswarm.solver.identifiability.stored.follow_ups import follow_up_of, same_question
from geoswarm.solver.methods.registry import kinds_of
from geoswarm.solver.problem import Problem, parse_problem
from geoswarm.solver.report.folder.run_folder import JOURNAL
from geoswarm.solver.report.folder.tables import parameter_column

__all__ = ["column", "evaluations_of_folder", "findings_of_folder", "read_table"]


def read_table(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file by column."""
    with path.open(newline="", encoding="utf-8") as stream:
        return list(csv.DictReader(stream))


def column(rows: list[dict[str, str]], name: str) -> FloatArray:
    """Return a column of numbers, shape (n,)."""
    return np.array([float(row[name]) for row in rows], dtype=np.float64)


def evaluations_of_folder(folder: Path, problem: Problem) -> list[Evaluation]:
    """Read all evaluations of a run in their order, failed ones too; without responses.npz they have no responses."""
    rows = read_table(folder / "evaluations.csv")
    good = [row for row in rows if row["state"] == "finished"]
    archive = folder / "responses.npz"
    responses: dict[str, FloatArray] = {}
    partial: dict[tuple[int, int], dict[str, FloatArray]] = {}
    if archive.is_file():
        with np.load(archive, allow_pickle=False) as stored:
            responses = {o.series: stored[f"response.{o.series}"] for o in problem.observations}
            if "partial.generation" in stored:
                partial = _partial(stored, problem)
    names = [parameter_column(name) for name in problem.free_names]
    misfits = {o.series: column(good, f"misfit.{o.series}") for o in problem.observations}
    place = 0
    found = []
    for row in rows:
        parameters = np.array([float(row[name]) for name in names])
        if row["state"] != "finished":
            kept = partial.get((int(row["generation"]), int(row["particle"])), {})
            found.append(Evaluation(parameters, None, {}, kept, row["reason"], row.get("message"), 0.0))
            continue
        found.append(
            Evaluation(
                parameters,
                float(row["objective"]),
                {series: float(values[place]) for series, values in misfits.items()},
                {series: np.asarray(values[place]) for series, values in responses.items()},
                None,
                None,
                0.0,
            )
        )
        place += 1
    return found


def _partial(stored: Mapping[str, FloatArray], problem: Problem) -> dict[tuple[int, int], dict[str, FloatArray]]:
    """What the tests that succeeded gave in failed runs, by generation and particle."""
    curves = {o.series: stored[f"partial.response.{o.series}"] for o in problem.observations}
    places = zip(stored["partial.generation"].tolist(), stored["partial.particle"].tolist(), strict=True)
    return {
        place: {series: values[row] for series, values in curves.items() if not np.isnan(values[row]).any()}
        for row, place in enumerate(places)
    }


def findings_of_folder(folder: Path, problem: Problem, *, noise: Mapping[str, float] | float | None = None) -> Findings:
    """Read what follow-ups found: those inside the folder of a run, or the run itself when it is one."""
    if follow_up_of(problem) is not None:
        return _read(folder, problem, noise)
    parts = []
    for kind in kinds_of("follow_up"):
        # one of a kind, but as many predictions as there are names
        for file in (folder / kind / "problem.json", *sorted((folder / kind).glob("*/problem.json"))):
            if file.is_file() and not (file.parent / JOURNAL).is_file():  # one that was cut off says nothing yet
                follow_up = parse_problem(json.loads(file.read_text(encoding="utf-8")), programs=True)
                if same_question(problem, follow_up):
                    parts.append(_read(file.parent, follow_up, noise))
    return join_findings(parts)


def _read(folder: Path, problem: Problem, noise: Mapping[str, float] | float | None) -> Findings:
    return findings_of(problem, problem.seed or 0, evaluations_of_folder(folder, problem), noise=noise)
