"""``geoswarm import``: problems made of the files of other tools."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING

import click

from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import echo_json, echo_table, note

if TYPE_CHECKING:
    from geoswarm.solver.external.copies import Copies

__all__ = ["import_command"]


@click.group("import")
def import_command() -> None:
    """Convert files of another tool to a problem."""


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
    help="File or folder next to the control file that the program needs; may be repeated.",
)
def import_pest(case: Path, output: Path, files: tuple[str, ...]) -> None:
    """Make a problem from a control file of PEST or PEST++ (version 1 or 2).

    Writes problem.yaml, the readings, and copies of the templates, the instruction files and the program's files that
    the command line names. Lists what a problem file cannot express. Existing files are never overwritten.

        geoswarm import pest case.pst --output problem
    """
    from geoswarm.solver.external.copies import FileInTheWayError
    from geoswarm.solver.external.pest_control.case import PestControlError
    from geoswarm.solver.external.pest_control.problem import PROBLEM, imported
    from geoswarm.solver.external.pest_control.reading import read_case

    try:
        made = imported(read_case(case), output, files)
    except (PestControlError, FileInTheWayError) as error:
        raise BadInputError(str(error)) from None
    _write(made.copies, made.notes, output / PROBLEM)


@import_command.command("ags")
@click.argument("file", type=click.Path(exists=True, dir_okay=False, path_type=Path), metavar="FILE.ags")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    metavar="DIR",
    help="Folder for the problem and the readings; without it the file's tests are listed.",
)
@click.option(
    "--specimen",
    "specimens",
    multiple=True,
    metavar="ID",
    help="Specimen or instrument as it is listed, or a borehole; may be repeated, several make a combined problem.",
)
@click.option("--material", metavar="LAW", help="Soil law; soft_soil, or mohr_coulomb for drained shear tests alone.")
@click.option(
    "--stage-duration",
    default="24 h",
    show_default=True,
    metavar="TIME",
    help="Duration of each increment of an oedometer test.",
)
@click.option(
    "--initial-stress",
    metavar="STRESS",
    help="Vertical stress before the first increment, e.g. '1 kPa'; a tenth of that of the increment unless given.",
)
@click.option("--json", "as_json", is_flag=True, help="List as JSON.")
def import_ags(
    file: Path,
    output: Path | None,
    specimens: tuple[str, ...],
    material: str | None,
    stage_duration: str,
    initial_stress: str | None,
    as_json: bool,
) -> None:
    """Make a problem from laboratory tests in an AGS 4 file, and CSV files of monitoring readings.

    Oedometer tests (CONG, ESCG) are compared by the void ratios at the ends of their increments, triaxial tests
    (TREG, TRIG) by the stresses at failure: such files contain nothing else. Assumptions are listed. Existing files are
    never overwritten.

        geoswarm import ags data.ags

        geoswarm import ags data.ags --output clay --specimen BH1/U3/1
    """
    from geoswarm.solver.ags.contents import chosen, contents_of, entries, picked
    from geoswarm.solver.ags.problem import PROBLEM, imported
    from geoswarm.solver.ags.reading import read_ags_file
    from geoswarm.solver.ags.tables import AgsError
    from geoswarm.solver.ags.wishes import COMMAND_LINE, Wishes
    from geoswarm.solver.external.copies import FileInTheWayError

    duration = _quantity("--stage-duration", stage_duration, "day")
    stress = None if initial_stress is None else _quantity("--initial-stress", initial_stress, "kPa")
    try:
        contents = contents_of(read_ags_file(file))
        if output is None:
            contents = chosen(contents, specimens) if specimens else contents
            rows = [(entry.id, entry.kind, entry.what) for entry in entries(contents)]
            if as_json:
                echo_json([asdict(entry) for entry in entries(contents)])
            elif rows:
                echo_table(None, ["ID", "what", "holds"], rows)
            else:
                note(f"{file.name} holds no compression tests, shear tests or monitoring that can be imported")
            return
        contents = picked(contents, specimens, COMMAND_LINE.specimen)
        made = imported(contents, output, Wishes(duration, material, stress))
    except (AgsError, FileInTheWayError) as error:
        raise BadInputError(str(error)) from None
    _write(made.copies, made.notes, output / PROBLEM if made.problem else None)


def _write(copies: Copies, notes: tuple[str, ...], problem: Path | None) -> None:
    """Write what was made, tell what was assumed, and what remains to be done."""
    from geoswarm.solver.errors import ProblemError
    from geoswarm.solver.problem import load_problem

    copies.write()
    for text in notes:
        note(f"Note: {text}.")
    note(f"Written to {copies.folder}: {', '.join(copies.contents)}")
    if problem is None:
        return
    try:
        load_problem(problem)
    except ProblemError as error:
        for issue in error.issues:
            note(f"To do: {issue}")
    note(f"Next: geoswarm check {problem}")


def _quantity(option: str, text: str, unit: str) -> float:
    """Number of a text such as ``24 h`` in a unit; raises BadInputError."""
    from geoswarm.solver.problem.tables.reading import cell_number
    from geoswarm.solver.units import UnitError, convert

    example = "24 h" if unit == "day" else "1 kPa"
    first, _, rest = text.strip().partition(" ")
    value = cell_number(first)
    if value is None or not rest.strip():
        raise BadInputError(f"{option} must be a number and a unit, such as '{example}', got '{text}'")
    try:
        value = float(convert(value, rest.strip(), unit))
    except UnitError as error:
        raise BadInputError(f"{option} '{text}': {error}") from None
    if not 0.0 < value < math.inf:
        raise BadInputError(f"{option} must be above 0 {unit}, got '{text}'")
    return value
