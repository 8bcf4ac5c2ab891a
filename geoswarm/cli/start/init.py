"""``geoswarm init`` and ``geoswarm inline``: a problem to begin with, and one without files for other programs."""

from __future__ import annotations

import json
from pathlib import Path

import click

from geoswarm.cli.options import problem_argument
from geoswarm.cli.start.examples import example_problem
from geoswarm.cli.start.starters import STARTERS, Starter
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note

__all__ = ["init_command", "inline_command"]


@click.command("init")
@click.argument("kind", type=click.Choice(tuple(STARTERS)), default="oedometer", metavar="[KIND]")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path(),
    metavar="DIR",
    help="Folder to write to; the working folder if not given.",
)
def init_command(kind: str, output: Path) -> None:
    """Write a commented starter problem with its data.

    KIND is oedometer (unless given), isotropic_compression, triaxial, direct_simple_shear, consolidation,
    crs_oedometer, column, formula, combined, section or tests (a table of tests). The data are synthetic;
    replace them with yours. Existing files are never overwritten.
    """
    files = _files(STARTERS[kind])
    there = [str(output / name) for name in files if (output / name).exists()]
    if there:
        raise BadInputError(f"{', '.join(there)}: there already, and never overwritten; give another --output DIR")
    output.mkdir(parents=True, exist_ok=True)
    for name, text in files.items():
        (output / name).write_text(text, encoding="utf-8")
    problem = output / "problem.yaml"
    note(f"Written: {', '.join(str(output / name) for name in files)}")
    note(f"Next: put your readings in, then geoswarm check {problem}, geoswarm run {problem} --output {output / 'run'}")


@click.command("inline")
@problem_argument
@click.option(
    "--output", type=click.Path(dir_okay=False, path_type=Path), metavar="FILE", help="File; stdout if not given."
)
def inline_command(problem: Path, output: Path | None) -> None:
    """Write a problem as JSON with its data inside, as the body of POST /api/v1/jobs.

    For programs that send problems themselves:

        geoswarm inline PROBLEM | curl -H 'Content-Type: application/json' --data-binary @- URL/api/v1/jobs
    """
    from geoswarm.solver.problem import load_problem

    text = json.dumps(load_problem(problem).document(), indent=2, ensure_ascii=False, allow_nan=False)
    if output is None:
        click.echo(text)
        return
    output.write_text(text + "\n", encoding="utf-8")
    note(f"Written to {output}")


def _files(starter: Starter) -> dict[str, str]:
    """Texts by name, the problem first."""
    with example_problem(starter.example) as path:
        data = {file.name: file.read_text(encoding="utf-8") for file in sorted(path.parent.glob("*.csv"))}
        text = (
            starter.text
            or f"# A starting point: replace data and numbers with yours.\n{path.read_text(encoding='utf-8')}"
        )
    used = {name: _with_headings(content, starter.headings.get(name)) for name, content in data.items() if name in text}
    return {"problem.yaml": text, **used, **starter.files}


def _with_headings(content: str, headings: str | None) -> str:
    """The rows of an example's data under other headings, marked as what they are."""
    if headings is None:
        return content
    rows = [line for line in content.splitlines() if not line.startswith("#")][1:]
    return "\n".join(["# SYNTHETIC readings, to be replaced with yours", headings, *rows]) + "\n"
