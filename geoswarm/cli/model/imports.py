"""``geoswarm import``: problems made of the files of other tools."""

from __future__ import annotations

from pathlib import Path

import click

from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note

__all__ = ["import_command"]


@click.group("import")
def import_command() -> None:
    """Make a problem of the files of another tool."""


@import_command.command("pest")
@click.argument("case", type=click.Path(exists=True, dir_okay=False, path_type=Path), metavar="CASE.pst")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    required=True,
    metavar="DIR",
    help="Folder for the problem; may be that of the control file.",
)
@click.option(
    "--files",
    multiple=True,
    metavar="NAME",
    help="File or folder beside the control file that the program needs; may be repeated.",
)
def import_pest(case: Path, output: Path, files: tuple[str, ...]) -> None:
    """Make a problem of a control file of PEST or PEST++ (version 1 or 2).

    Writes problem.yaml, the readings, and copies of the templates, the instruction files and the program's files that
    stand on the command line. What a problem cannot say is listed. Nothing that is there is overwritten.

        geoswarm import pest case.pst --output problem
    """
    from geoswarm.solver.errors import ProblemError
    from geoswarm.solver.external.pest_control.case import PestControlError
    from geoswarm.solver.external.pest_control.problem import PROBLEM, imported
    from geoswarm.solver.external.pest_control.reading import read_case
    from geoswarm.solver.problem import load_problem

    try:
        made = imported(read_case(case), output, files)
    except PestControlError as error:
        raise BadInputError(str(error)) from None
    made.copies.write()
    problem = output / PROBLEM
    for text in made.notes:
        note(f"Note: {text}.")
    note(f"Written to {output}: {', '.join(made.copies.contents)}")
    try:
        load_problem(problem)
    except ProblemError as error:
        for issue in error.issues:
            note(f"To do: {issue}")
    note(f"Next: geoswarm check {problem}")
