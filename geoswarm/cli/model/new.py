"""``geoswarm model new``: a first problem file for a program, with a template made of an example of its input."""

from __future__ import annotations

import re
import shlex
import shutil
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import click

from geoswarm.cli.words.error_messages import BadInputError
from geoswarm.cli.words.output import note

__all__ = ["Mark", "marked", "new_command"]

_NUMBER = re.compile(r"(?<![\w.])[+-]?(?:\d+\.?\d*|\.\d+)(?:[eEdD][+-]?\d+)?(?![\w.])")
_NAME = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


@dataclass(frozen=True, slots=True)
class Mark:
    """A value of the example that is a parameter: its name, the value as a number, and the line, None: any."""

    name: str
    value: float
    line: int | None


@click.command("new")
@click.option("--run", "call", prompt="Program and arguments", help="Program and arguments, as at a shell.")
@click.option(
    "--input",
    "example",
    type=click.Path(exists=True, dir_okay=False, path_type=Path),
    prompt="Example of its input file",
    help="An input file that the program understands.",
)
@click.option(
    "--mark",
    "marks",
    multiple=True,
    metavar="NAME=VALUE[@LINE]",
    help="A number of the example that is a parameter; may be repeated. The line distinguishes equal numbers.",
)
@click.option("--result", prompt="File that it writes its results to", help="File with the results, in the run folder.")
@click.option(
    "--output",
    type=click.Path(file_okay=False, path_type=Path),
    default=Path(),
    metavar="DIR",
    help="Folder to write to; the working folder if not given.",
)
def new_command(call: str, example: Path, marks: tuple[str, ...], result: str, output: Path) -> None:
    """Write a problem file for your own program.

    Makes a template from an example of the program's input file: the numbers that you mark become parameters. Asks for
    what is not given. Copies the programs and files that the call names. Existing files are never overwritten.

        geoswarm model new --run "./settle" --input input.txt --mark E=2e4 --mark nu=0.3 --result output.csv
    """
    try:
        arguments = shlex.split(call)
    except ValueError as error:
        raise BadInputError(f"--run {call}: {error}") from None
    if not arguments:
        raise BadInputError("--run is empty; give the program and its arguments")
    chosen = [parse_mark(text) for text in (marks or _asked())]
    template = marked(_text(example), chosen, example.name)
    here = _own_files(arguments, Path())
    own = here or _own_files(arguments, output)
    copied = [] if output.resolve() == Path.cwd() else here
    files = {
        f"{example.name}.in": template,
        "readings.csv": "x,y\n1,0.0\n2,0.0\n",
        "problem.yaml": problem_text(arguments, own, example.name, chosen, result),
    }
    there = [str(output / name) for name in (*files, *copied) if (output / name).exists()]
    if there:
        raise BadInputError(f"{', '.join(there)}: there already, and never overwritten; give another --output DIR")
    output.mkdir(parents=True, exist_ok=True)
    for name in copied:
        (output / name).parent.mkdir(parents=True, exist_ok=True)
        shutil.copy(name, output / name)
    for name, text in files.items():
        (output / name).write_text(text, encoding="utf-8", newline="")
    problem = output / "problem.yaml"
    note(f"Written: {', '.join(str(output / name) for name in (*files, *copied))}")
    note(f"Next: state in {problem} how the series is read, and put your readings in readings.csv;")
    note(f"geoswarm model try {problem} shows what a run reads and writes, geoswarm check {problem} validates it.")


def _asked() -> list[str]:
    click.echo("Numbers of the example that are parameters, as NAME=VALUE or NAME=VALUE@LINE; an empty line ends.")
    marks: list[str] = []
    while text := click.prompt("Parameter", default="", show_default=False):
        marks.append(text)
    return marks


def parse_mark(text: str) -> Mark:
    """Read ``E=2e4`` or ``E=2e4@12``.

    Raises
    ------
    BadInputError

    Examples
    --------
    >>> parse_mark("E=2e4@12")
    Mark(name='E', value=20000.0, line=12)
    """
    name, equals, rest = (part.strip() for part in text.partition("="))
    value, at, line = (part.strip() for part in rest.partition("@"))
    if not equals or not _NAME.fullmatch(name):
        raise BadInputError(f"--mark {text}: give NAME=VALUE, for example E=2e4")
    if not _NUMBER.fullmatch(value) or (at and not line.isdecimal()):
        raise BadInputError(f"--mark {text}: '{rest}' is neither a number nor a number @ line")
    return Mark(name, _value(value), int(line) if at else None)


def marked(text: str, marks: Sequence[Mark], file: str) -> str:
    """Return the text with placeholders instead of the marked numbers.

    Raises
    ------
    BadInputError
        A number is missing, or occurs in several places.

    Examples
    --------
    >>> marked("2e4, 0.3", [Mark("E", 20000.0, None)], "in.txt")
    '{{E}}, 0.3'
    """
    if not marks:
        raise BadInputError("no number is marked; give at least one --mark NAME=VALUE")
    lines = text.replace("{{", "{{{{").splitlines(keepends=True)
    taken: dict[int, list[tuple[int, int, str]]] = {}
    for mark in marks:
        found = [
            (number, match)
            for number, line in enumerate(lines, 1)
            if mark.line in (None, number)
            for match in _NUMBER.finditer(line)
            if _value(match[0]) == mark.value
        ]
        where = f"line {mark.line} of {file}" if mark.line else file
        if not found:
            raise BadInputError(f"--mark {mark.name}={mark.value:g}: there is no such number in {where}")
        if len(found) > 1:
            places = ", ".join(str(number) for number, _ in found[:10])
            raise BadInputError(
                f"--mark {mark.name}={mark.value:g}: it occurs in {len(found)} places (lines {places}); "
                f"give {mark.name}={mark.value:g}@LINE, or mark it by hand in the template as {{{{{mark.name}}}}}"
            )
        ((number, match),) = found
        taken.setdefault(number, []).append((match.start(), match.end(), mark.name))
    for number, spans in taken.items():
        line = lines[number - 1]
        for start, end, name in sorted(spans, reverse=True):
            line = f"{line[:start]}{{{{{name}}}}}{line[end:]}"
        lines[number - 1] = line
    return "".join(lines)


def problem_text(arguments: Sequence[str], own: Sequence[str], example: str, marks: Sequence[Mark], result: str) -> str:
    """The problem file."""
    bounds = {mark.name: _bounds(mark.value) for mark in marks}
    copied = f"\n  files: [{', '.join(map(_quoted, own))}]   # copied into the run folder" if own else ""
    parameters = "\n".join(f"  {name}: {{{limits}}}" for name, limits in bounds.items())
    return f"""\
# A program as a forward model. Every run has a new, empty folder, in which the template is filled.
name: {Path(arguments[0]).stem or "model"}
forward_model:
  kind: command
  run: [{", ".join(map(_quoted, arguments))}]{copied}
  templates: {{{_quoted(example)}: {_quoted(example + ".in")}}}
  seconds: 600                          # a run that takes longer is killed
  series:
    result:                             # columns by name or number, or expressions of them: "-column2"
      {{file: {_quoted(result)}, x: 1, y: 2, x_unit: "1", y_unit: "1"}}
parameters:                             # bounds of the search, to be chosen by you
{parameters}
observations:
  - {{series: result, file: readings.csv, x_unit: "1", y_unit: "1"}}   # your readings
method: {{kind: particle_swarm}}
stopping: {{max_evaluations: 200, stagnation_generations: 20}}
seed: 1
"""


def _bounds(value: float) -> str:
    """A tenth to ten times a positive value, on a logarithmic scale; as much to both sides of another."""
    if value > 0.0:
        return f"lower: {value / 10.0:g}, upper: {value * 10.0:g}, scale: log, initial: {value:g}"
    size = abs(value) or 1.0
    return f"lower: {value - size:g}, upper: {value + size:g}, initial: {value:g}"


def _own_files(arguments: Sequence[str], folder: Path) -> list[str]:
    """Arguments that are files of a folder, and so have to be copied into each run folder."""
    names = [argument.removeprefix("./") for argument in arguments]
    return [name for name in names if not name.startswith("/") and ".." not in name and (folder / name).is_file()]


def _text(path: Path) -> str:
    try:
        return path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        raise BadInputError(f"--input {path}: is not UTF-8 text") from None


def _value(text: str) -> float:
    return float(text.lower().replace("d", "e"))


def _quoted(text: str) -> str:
    """A text as YAML reads it."""
    plain = re.fullmatch(r"[A-Za-z_./][\w./-]*", text) is not None
    return text if plain else '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
