"""``geoswarm evaluate``: one forward calculation with given parameters."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.options import json_option, problem_argument, read_values, values_option
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.kernels import ready
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, note, number
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from geoswarm.solver.calibration import Evaluation
    from geoswarm.solver.problem import Problem

__all__ = ["evaluate_command", "given_values", "parameter_values"]


@click.command("evaluate")
@problem_argument
@values_option("Value of a free or fixed parameter, in base units (kN, m, day, degree)")
@json_option
def evaluate_command(problem: Path, given: tuple[str, ...], as_json: bool) -> None:
    """Run one forward calculation with given parameters.

    A free parameter without --set takes its 'initial' value from the problem file. Linked parameters follow from the
    others. Values that lie outside the bounds or violate a constraint are calculated with a warning: bounds
    apply only to the search. With --json, all numbers are in base units (m, day, kPa); without it, tables are in the
    units of the observations.
    """
    from geoswarm.solver.calibration import Calibration
    from geoswarm.solver.problem import load_problem

    loaded = load_problem(problem)
    values = parameter_values(loaded, given_values(loaded, given))
    for warning in _doubts(loaded, values):
        note(f"Warning: {warning}")
    ready(loaded)
    evaluation = Calibration(loaded, loaded.seed or 0).evaluate_values(values)
    if as_json:
        echo_json(_document(loaded, values, evaluation))
    if evaluation.reason is not None:
        raise FailedRunError(f"the forward run failed ({evaluation.reason}): {evaluation.message}")
    if not as_json:
        _show(loaded, values, evaluation)


def given_values(problem: Problem, given: Sequence[str]) -> dict[str, float]:
    """Read the texts of ``--set`` for parameters of a problem.

    Raises
    ------
    BadInputError
        As :func:`read_values`; also for an unknown or linked name.
    """
    from geoswarm.solver.problem.given import given_mistake

    return read_values(given, partial(given_mistake, problem))


def parameter_values(problem: Problem, given: Mapping[str, float]) -> dict[str, float]:
    """Return the value of every parameter: given ones, else ``initial`` or fixed ones, and linked ones from those.

    Raises
    ------
    BadInputError
        When a free parameter has neither a given nor an initial value.
    """
    from geoswarm.solver.problem.given import values_from, without_value

    missing = without_value(problem, given)
    if missing:
        options = " ".join(f"--set {name}=..." for name in missing)
        raise BadInputError(f"free parameters without a value (they have no 'initial' either): {options}")
    return values_from(problem, given)


def _doubts(problem: Problem, values: Mapping[str, float]) -> list[str]:
    doubts = [
        f"{p.name} = {number(values[p.name])} is outside its bounds {number(p.lower)} to {number(p.upper)}"
        for p in problem.free
        if not p.lower <= values[p.name] <= p.upper
    ]
    return doubts + [f"the constraint '{c.text}' does not hold" for c in problem.constraints if not c.value(values)]


def _document(problem: Problem, values: Mapping[str, float], evaluation: Evaluation) -> dict[str, Any]:
    document: dict[str, Any] = {
        "objective": evaluation.objective,
        "misfits": evaluation.misfits,
        "responses": {},
        "parameters": dict(values),
    }
    if evaluation.reason is not None:
        return document | {"reason": evaluation.reason, "message": evaluation.message}
    known = {info.name: info for info in problem.model.series}
    for o in problem.observations:
        document["responses"][o.series] = {
            "x": o.x.tolist(),
            "y": evaluation.responses[o.series].tolist(),
            "x_unit": known[o.series].x_unit,
            "y_unit": known[o.series].y_unit,
        }
    return document


def _show(problem: Problem, values: Mapping[str, float], evaluation: Evaluation) -> None:
    from geoswarm.cli.words.output import parameter_rows, root_mean_square, with_unit
    from geoswarm.solver.problem.weighting import series_shares
    from geoswarm.solver.report.curves import objective_unit, series_curves

    echo_facts(problem.name, {"objective": with_unit(number(evaluation.objective), objective_unit(problem))})
    echo_table(None, ("parameter", "", "value", "unit"), parameter_rows(problem, values), right=(2,))
    shares = {share.series: share for share in series_shares(problem, evaluation.misfits)}
    rows = []
    for curve in series_curves(problem, evaluation.responses, values):
        share = shares[curve.series]
        rows.append(
            (
                curve.series,
                str(len(curve.measured_x)),
                with_unit(number(curve.measured_x[-1]), curve.x_unit),
                with_unit(number(curve.measured_y[-1]), curve.y_unit),
                with_unit(number(curve.at_points[-1]), curve.y_unit),
                root_mean_square(share),
                number(share.misfit),
                per_cent(share.share),
            )
        )
    echo_table(
        None,
        ("series", "points", "last x", "measured", "calculated", "root mean square", "misfit", "share"),
        rows,
        right=range(1, 8),
    )
