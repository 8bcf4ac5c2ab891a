"""How the verdict on the fit is shown: before every result that does not hold without it."""

from __future__ import annotations

import textwrap
from collections.abc import Mapping
from typing import Any

import click

from geoswarm.cli.output import note

__all__ = ["interval_heading", "show_fit"]

_WRONG = {
    "lack_of_fit": "THE MODEL DOES NOT DESCRIBE THE DATA",
    "error_not_met": "THE STATED ERROR IS NOT MET",
}
_WIDTH = 100


def show_fit(fit: Mapping[str, Any] | None) -> None:
    """Write what is wrong with the fit, and what to do, to stdout; a fit that could not be tested is a note."""
    if fit is None or fit["kind"] == "describes":
        return
    if fit["kind"] == "untested":
        note(f"Note: {fit['sentence']}")
        return
    click.secho(_WRONG[fit["kind"]], bold=True, fg="red")
    click.echo(textwrap.fill(fit["sentence"], _WIDTH, initial_indent="  ", subsequent_indent="  "))
    click.echo("  What to do:")
    for number, remedy in enumerate(fit["remedies"], 1):
        click.echo(textwrap.fill(remedy, _WIDTH, initial_indent=f"  {number}. ", subsequent_indent="     "))


def interval_heading(level: float, fit: Mapping[str, Any] | None) -> tuple[str, str]:
    """Headings of the two ends of an interval; they say where it does not hold."""
    from geoswarm.solver.identifiability.misfits import SHORT

    doubt = SHORT.get("" if fit is None else fit["kind"], "")
    return f"{level:.0%} from" + (f" ({doubt})" if doubt else ""), "to"
