"""Synthetic readings: what a model gives at known parameters, with noise, to try a calibration before measuring."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem import load_problem
from geoswarm.solver.units import convert

__all__ = ["write_readings"]


def write_readings(
    problem_file: Path,
    truth: Mapping[str, float],
    seed: int,
    source: str,
    folder: Path | None = None,
    decimals: int = 3,
) -> Sequence[Path]:
    """Rewrite the data files of a problem: the same x, and as y the model's values with the stated errors as noise.

    Parameters
    ----------
    problem_file
        Problem whose observations have a ``file`` with columns x and y, and an ``error``.
    truth
        Values of its free parameters, base units.
    seed
        Of the noise.
    source
        What made the readings, in words, for the first line of each file.
    folder
        Where they are written; that of the problem if absent.
    decimals
        Digits after the point of a reading in its unit.

    Returns
    -------
    Sequence[Path]
        The files.

    Raises
    ------
    ProblemError
        The problem is wrong, or an observation has no file or error.
    ForwardError
        The model fails at these parameters.
    """
    from geoswarm.solver.problem.text.reading import read_problem_file

    sections = read_problem_file(problem_file)["observations"]
    issues = [
        Issue(f"observations[{number}].{key}", "is missing; synthetic readings need it")
        for number, section in enumerate(sections)
        for key in ("file", "error")
        if key not in section
    ]
    if issues:
        raise ProblemError(issues)
    problem = load_problem(problem_file)
    responses = problem.model.prepare({one.series: one.x for one in problem.observations})(
        problem.values([truth[name] for name in problem.free_names])
    )
    random = np.random.default_rng(seed)
    values = ", ".join(f"{name} {truth[name]:g}" for name in problem.free_names)
    infos, written = {info.name: info for info in problem.model.series}, []
    for section, one in zip(sections, problem.observations, strict=True):
        info, error = infos[one.series], float(section["error"])
        x_unit = one.x_unit or info.x_unit or "dimensionless"
        y_unit = one.y_unit or info.y_unit or "dimensionless"
        x = convert(one.x, info.x_unit, x_unit)
        y = convert(responses[one.series], info.y_unit, y_unit) + random.normal(0.0, error, one.x.size)
        lines = [
            f"# synthetic: not measured; {source} at {values}, normal noise of {error:g} {y_unit}, seed {seed}",
            f"# x in {x_unit}, y in {y_unit}",
            "x,y",
            *(f"{at:.10g},{value:.{decimals}f}" for at, value in zip(x, y, strict=True)),
        ]
        path = (folder or problem_file.parent) / section["file"]
        path.write_text("\n".join(lines) + "\n", encoding="utf-8")
        written.append(path)
    return written
