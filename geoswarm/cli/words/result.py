"""How a result is shown: the verdict on the fit first, then values with intervals and verdicts, and what to do next."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.words.output import echo_table, ends, note, number, symbol_and_unit
from geoswarm.solver.words import per_cent

if TYPE_CHECKING:
    from geoswarm.solver.problem import Problem

__all__ = ["interval_heading", "show_fit", "show_values", "values_json"]

_WIDTH = 100


def show_fit(fit: Mapping[str, Any] | None) -> None:
    """Write what is wrong with the fit, and what to do, to stdout; a fit that could not be tested is a note."""
    if fit is None or fit["kind"] == "describes":
        return
    if fit["kind"] == "untested":
        note(f"Note: {' '.join((fit['sentence'], *fit['remedies']))}")
        return
    click.secho(fit["headline"].upper(), bold=True, fg="red")
    click.echo(textwrap.fill(fit["sentence"], _WIDTH, initial_indent="  ", subsequent_indent="  "))
    click.echo("  What to do:")
    for place, remedy in enumerate(fit["remedies"], 1):
        click.echo(textwrap.fill(remedy, _WIDTH, initial_indent=f"  {place}. ", subsequent_indent="     "))


def interval_heading(level: float, fit: Mapping[str, Any] | None) -> tuple[str, str]:
    """Headings of the two ends of an interval; they say where it does not hold."""
    from geoswarm.solver.identifiability.misfits import SHORT

    doubt = "" if fit is None or fit["tests"] else SHORT.get(fit["kind"], "")
    return f"{per_cent(level)} from" + (f" ({doubt})" if doubt else ""), "to"


def values_json(found: Mapping[str, Any] | None) -> dict[str, Any]:
    """Return what statistics as plain JSON say of each parameter and of the fit, as a job does; None without any."""
    if found is None:
        return dict.fromkeys(("intervals", "verdicts", "fit", "shares"))
    known = None if found["linearisation"] is None else found["linearisation"]["parameters"]
    names = [verdict["parameter"] for verdict in found["verdicts"]]
    return {
        "intervals": {name: None if known is None else known[name]["interval"] for name in names},
        "verdicts": {verdict["parameter"]: verdict["kind"] for verdict in found["verdicts"]},
        "fit": found["fit"]["kind"],
        "shares": found["weights"],
    }


def show_values(
    problem: Problem, values: Mapping[str, float], found: Mapping[str, Any] | None, title: str | None = None
) -> None:
    """Write a table of the parameters, why some of them are not identified, and one next step.

    Parameters
    ----------
    values
        Of all parameters.
    found
        Statistics as plain JSON, None where there are none.
    title
        Above the table.
    """
    columns = ("parameter", "", "best fit", "95 % from", "to", "unit", "verdict")
    echo_table(title, columns, _parameter_rows(problem, values, found), right=(2, 3, 4))
    if found is None or not (found["fit"]["kind"] in ("describes", "untested") or found["fit"]["tests"]):
        return  # what is wrong with the fit stands above, with what to do
    doubtful = [verdict for verdict in found["verdicts"] if verdict["kind"] != "identified"]
    for verdict in doubtful:
        click.echo(textwrap.fill(verdict["sentence"], _WIDTH, initial_indent="  ", subsequent_indent="    "))
    steps = [remedy["text"] for verdict in doubtful for remedy in verdict["what_to_do"]]
    steps += [proposal["sentence"] for verdict in doubtful for proposal in verdict["proposals"]]
    steps += [remedy["text"] for remedy in found["basins"]["what_to_do"]]
    if steps:
        click.echo(textwrap.fill(f"Next: {steps[0]}", _WIDTH, initial_indent="  ", subsequent_indent="    "))


def _parameter_rows(
    problem: Problem, values: Mapping[str, float], found: Mapping[str, Any] | None
) -> list[tuple[str, ...]]:
    from geoswarm.solver.problem import FreeParameter, LinkedParameter

    linearisation = None if found is None else found["linearisation"]
    verdicts = {} if found is None else {verdict["parameter"]: verdict["words"] for verdict in found["verdicts"]}
    rows: list[tuple[str, ...]] = []
    for name, parameter in problem.parameters.items():
        symbol, unit = symbol_and_unit(problem, name)
        if isinstance(parameter, FreeParameter):
            interval = None if linearisation is None else linearisation["parameters"][name]["interval"]
            said = verdicts.get(name, "")
            if (bound := parameter.bound_at(values[name])) is not None:
                said = f"{said}, at its {bound} bound" if said else f"at its {bound} bound"
            low, high = ("-", "-") if interval is None else ends(*interval)
        else:
            said = f"= {parameter.expression.text}" if isinstance(parameter, LinkedParameter) else "fixed"
            low = high = ""
        rows.append((name, symbol, number(values[name], 5), low, high, unit, said))
    return rows
