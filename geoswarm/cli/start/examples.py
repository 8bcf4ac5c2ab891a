"""``geoswarm examples``, and the examples as files for other commands."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict
from pathlib import Path

import click

from geoswarm.cli.options import json_option
from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import echo_json, echo_table, note
from geoswarm.solver.examples import describe_example, example_file, example_names

__all__ = ["example_problem", "examples_command"]


@click.command("examples")
@click.argument("name", required=False)
@click.argument("directory", required=False, type=click.Path(file_okay=False, path_type=Path))
@json_option
def examples_command(name: str | None, directory: Path | None, as_json: bool) -> None:
    """List the examples that are installed, or write one out.

    With NAME and DIRECTORY, writes the example's problem, data and explanation to that folder, which is created if
    needed. Existing files are never overwritten.
    """
    if name is None:
        _list(as_json)
        return
    if name not in example_names():
        from geoswarm.solver.words import did_you_mean

        hint = did_you_mean(name, example_names())
        raise BadInputError(f"there is no example '{name}'{hint}; known: {', '.join(example_names())}")
    if directory is None:
        raise BadInputError(f"give the folder to write it to: geoswarm examples {name} DIRECTORY")
    written = _write(name, directory)
    if as_json:
        echo_json({"name": name, "files": [str(path) for path in written]})
        return
    note(f"Written: {', '.join(str(path) for path in written)}")
    if describe_example(name).needs_engine:
        note(f"Next: {directory / 'README.md'} says how to run it, and what must be installed")
    else:
        note(f"Next: geoswarm run {directory / 'problem.yaml'}")


def _list(as_json: bool) -> None:
    found = [describe_example(name) for name in example_names()]
    if as_json:
        echo_json({"items": [asdict(one) for one in found]})
        return
    rows = [(one.name, one.title, one.forward_model, one.method.replace("_", " ")) for one in found]
    echo_table(None, ("name", "what it shows", "forward model", "method"), rows)
    note("'geoswarm examples NAME DIRECTORY' writes one out.")


def _write(name: str, directory: Path) -> list[Path]:
    """Write the files of an example, all of them or none."""
    with example_file(name) as problem:
        sources = [path for path in sorted(problem.parent.rglob("*")) if path.is_file() and path.suffix != ".pyc"]
        contents = {path.relative_to(problem.parent).as_posix(): path.read_bytes() for path in sources}
    there = [str(directory / file) for file in contents if (directory / file).exists()]
    if there:
        raise BadInputError(f"nothing was written, because these files exist: {', '.join(there)}")
    directory.mkdir(parents=True, exist_ok=True)
    # Its commands name the folder of the checkout.
    explanation = contents["README.md"].replace(f"examples/{name}/".encode(), f"{directory.as_posix()}/".encode())
    contents["README.md"] = explanation
    for file, content in contents.items():
        (directory / file).parent.mkdir(parents=True, exist_ok=True)
        (directory / file).write_bytes(content)
    return [directory / file for file in contents]


@contextmanager
def example_problem(name: str) -> Iterator[Path]:
    """Give the problem file of an example, its data beside it, while the body runs.

    Raises
    ------
    BadInputError
        When the installation lacks the example.
    """
    if name not in example_names():
        raise BadInputError(f"the example '{name}' is missing in this installation; reinstall geoswarm")
    with example_file(name) as path:
        yield path
