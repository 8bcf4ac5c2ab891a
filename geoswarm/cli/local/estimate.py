"""``geoswarm estimate``: first estimates from the readings with a ruler, and from index properties."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.options import json_option, problem_argument
from geoswarm.cli.words.output import echo_json, echo_table, note, number

if TYPE_CHECKING:
    from geoswarm.solver.parameter_estimates.index import ParameterEstimate
    from geoswarm.solver.parameter_estimates.proposal import Proposed
    from geoswarm.solver.parameter_estimates.values import ClassicalValue

__all__ = ["estimate_command"]


@click.command("estimate")
@problem_argument
@json_option
def estimate_command(problem: Path, as_json: bool) -> None:
    """Estimate parameters from the readings and index properties; no forward run.

    Evaluates laboratory tests by the usual graphical constructions (Cc, Cs, preconsolidation stress, c_v, Cα, Mohr
    circles, E50) and the section index_properties by published correlations, and converts both to parameters of the
    law. Ends with a section 'parameters' with bounds and initial values to copy. The problem need not have
    'parameters' and 'stopping' yet.
    """
    from geoswarm.solver.parameter_estimates.classical import classical_values
    from geoswarm.solver.parameter_estimates.index import estimates_of, index_document
    from geoswarm.solver.parameter_estimates.proposal import ordered, proposed, with_parameters
    from geoswarm.solver.problem import load_problem

    loaded = load_problem(problem, with_parameters)
    values, index, proposal = classical_values(loaded), estimates_of(loaded), proposed(loaded)
    sections = {one.name: one.section for one in proposal}
    if as_json:
        echo_json(
            {
                "name": loaded.name,
                "classical": [_value(one) for one in values],
                "index_properties": index_document(index),
                "parameters": sections,
                "constraints": ordered(sections),
            }
        )
        return
    _show_values(values)
    _show_index(index)
    _show_proposal(proposal, ordered(sections))


def _value(one: ClassicalValue) -> dict[str, Any]:
    from dataclasses import asdict

    return asdict(one)


def _show_values(values: Sequence[ClassicalValue]) -> None:
    known = [one for one in values if one.value is not None]
    if known:
        rows = [
            (one.part, "" if one.stage is None else str(one.stage), one.symbol, number(one.value), one.unit, one.method)
            for one in known
        ]
        titles = ("test", "stage", "", "value", "unit", "method")
        used = [i for i in range(len(titles)) if i > 1 or any(row[i] for row in rows)]
        echo_table(
            "From the readings",
            tuple(titles[i] for i in used),
            [tuple(row[i] for i in used) for row in rows],
            right=(used.index(3),),
        )
    else:
        note("No classical evaluation is possible from these readings.")
    missing = [one for one in values if one.value is None and one.stage is None]
    for one in missing:
        note(f"Not from these readings: {f'{one.part}: ' if one.part else ''}{one.symbol} ({one.method}): {one.why}")


def _show_index(index: Sequence[ParameterEstimate]) -> None:
    if not index:
        return
    rows = []
    for one in index:
        told = one.correlated.correlation
        outside = f" (beyond its range: {one.correlated.outside})" if one.correlated.outside else ""
        ends = "" if one.ends is None else f"{number(one.ends[0], 3)} to {number(one.ends[1], 3)}"
        quantity = f"{one.quantity} = {number(one.quantity_value, 3)}"
        rows.append((one.parameter, number(one.value, 3), ends, quantity, told.equation, f"{told.source}{outside}"))
    columns = ("parameter", "value", "with scatter", "by", "equation", "source")
    echo_table("By index properties", columns, rows, right=(1,))


def _show_proposal(proposal: Sequence[Proposed], constraints: Sequence[str]) -> None:
    from geoswarm.solver.problem.text.writing import problem_yaml

    if not proposal:
        note("No parameter of this problem belongs to a soil law: nothing is proposed.")
        return
    click.echo("\nTo begin with; what has no estimate is in its usual range:\n")
    sections = {one.name: one.section for one in proposal}
    document: dict[str, Any] = {"parameters": sections} | ({"constraints": list(constraints)} if constraints else {})
    lines = problem_yaml(document).splitlines()
    notes = {f"  {one.name}:": _basis(one) for one in proposal}
    for line in lines:
        click.echo(f"{line}{next((f'  # {text}' for start, text in notes.items() if line.startswith(start)), '')}")


def _basis(one: Proposed) -> str:
    if one.as_given:
        return "as given"
    if not one.candidates:
        return f"usual range{f': {one.info.source}' if one.info.source else ''}"
    read = list(dict.fromkeys(c.source for c in one.candidates if c.reading))
    index = sum(not c.reading for c in one.candidates)
    by_index = f"{index} correlation{'s' if index > 1 else ''}" if index else ""
    most = [*read[:3], *([f"{len(read) - 3} more"] if len(read) > 3 else [])]
    return ", ".join(filter(None, ["; ".join(most), by_index]))
