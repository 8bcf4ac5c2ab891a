"""The problem made from a control file: its text with remarks, and its files."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePosixPath

from geoswarm.solver.expressions import CONSTANTS, FUNCTIONS
from geoswarm.solver.external.copies import Copies
from geoswarm.solver.external.pest_control.case import PestCase, PestControlError
from geoswarm.solver.external.pest_control.command_line import SCRIPT, CommandLine, command_line
from geoswarm.solver.external.pest_control.files import (
    beside,
    instruction_names,
    model_file,
    other_files,
    template_with,
)
from geoswarm.solver.external.pest_control.names import same_length
from geoswarm.solver.external.pest_control.parameters import ParameterLine, parameter_lines
from geoswarm.solver.external.pest_control.series import PestSeries, series_of

__all__ = ["PROBLEM", "Imported", "imported"]

PROBLEM = "problem.yaml"
_RESERVED = {"and", "or", "not", "x", *FUNCTIONS, *CONSTANTS}
_WIDTH = 118


@dataclass(frozen=True, slots=True)
class Imported:
    """A problem made from a control file: what to write, and notes."""

    copies: Copies
    notes: tuple[str, ...]


def imported(case: PestCase, folder: Path, files: Sequence[str] = ()) -> Imported:
    """Make a problem of a control file; nothing is written yet.

    Parameters
    ----------
    folder
        Where the problem will lie.
    files
        Files and folders beside the control file that the program needs, beyond those on its command line.

    Raises
    ------
    PestControlError, FileInTheWayError
        It cannot be made, or would overwrite something.
    """
    if (folder / PROBLEM).exists():
        raise PestControlError(f"{folder / PROBLEM} exists and is never overwritten; give another --output DIR")
    copies, notes = Copies(folder), list(case.notes)
    renamed = same_length((one.name for one in case.parameters), _accepted)
    templates = _templates(case, copies, renamed)
    instructions, read = _instructions(case, copies)
    series, told = series_of(case, read)
    notes += told
    if not any(one.counts for one in series):
        raise PestControlError(f"{case.path}: all observations have weight 0; there is nothing to fit")
    parameters, told = parameter_lines(case.parameters, renamed)
    notes += told
    notes += [f"parameter {old} is called {new}: a problem does not accept its name" for old, new in renamed.items()]
    call = command_line(case.commands, case.path.parent)
    notes += call.notes
    own = _program(case, copies, call, files)
    others = other_files(case, own, folder)
    if others:
        listed = ", ".join(others[:12]) + (f" and {len(others) - 12} more" if len(others) > 12 else "")
        notes.append(
            f"each run has a new folder with the files that are listed under files and link only; beside the control "
            f"file lie {listed}: import with --files NAME what the program reads of them"
        )
    for one in series:
        if one.counts:
            copies.add_as(f"{one.name}.csv", _readings(one), 0o644)
    listed_files = [*own, *([SCRIPT] if call.script else [])]
    text = _text(case, call, listed_files, templates, instructions, series, parameters, notes)
    copies.add_as(PROBLEM, text.encode(), 0o644)
    return Imported(copies, tuple(notes))


def _accepted(name: str) -> bool:
    return re.fullmatch(r"[A-Za-z_]\w{0,99}", name, re.ASCII) is not None and name not in _RESERVED


def _place(name: str) -> str:
    """Where a template or instruction file goes: its own place, where that is below the folder."""
    path = PurePosixPath(name)
    return path.name if path.is_absolute() or ".." in path.parts or ":" in name else str(path)


def _templates(case: PestCase, copies: Copies, renamed: Mapping[str, str]) -> dict[str, str]:
    """Template by the file that it becomes."""
    found: dict[str, str] = {}
    used: set[str] = set()
    for pair in case.templates:
        content, names = template_with(case.path.parent / pair.pest, pair.pest, renamed)
        used |= names
        place = _place(pair.pest)
        found[model_file(pair.model)] = copies.add(place if place.endswith(".tpl") else f"{place}.tpl", content)
    unknown = sorted(used - {one.name for one in case.parameters})
    if unknown:
        raise PestControlError(f"{case.path}: templates use {', '.join(unknown[:10])}, which are not parameters")
    return found


def _instructions(case: PestCase, copies: Copies) -> tuple[dict[str, str], dict[str, tuple[str, ...]]]:
    """Names of the copies, and what each file reads, by the names in the control file."""
    places: dict[str, str] = {}
    read: dict[str, tuple[str, ...]] = {}
    for pair in case.instructions:
        content, names = instruction_names(case.path.parent / pair.pest, pair.pest)
        model_file(pair.model)
        places[pair.pest], read[pair.pest] = copies.add(_place(pair.pest), content), names
    return places, read


def _program(case: PestCase, copies: Copies, call: CommandLine, files: Sequence[str]) -> list[str]:
    """Names of the files and folders of the program, which are copied."""
    words = call.arguments if call.script is None else ()
    missing = [name for name in files if not (case.path.parent / name).exists()]
    if missing:
        raise PestControlError(f"--files {missing[0]}: is not in {case.path.parent}")
    found = beside(case, [*words, *files])
    for name in found:
        source = case.path.parent / name
        for path in sorted(source.rglob("*")) if source.is_dir() else [source]:
            if path.is_file() and "__pycache__" not in path.parts:
                place = path.relative_to(case.path.parent).as_posix()
                copies.add_as(place, path.read_bytes(), path.stat().st_mode & 0o777)
    return found


def _readings(series: PestSeries) -> bytes:
    rows = [
        f"{x!r},{one.value!r},{one.weight * one.weight!r},{_cell(one.name)}"
        for x, one in zip(series.x, series.observations, strict=True)
    ]
    return ("x,y,weight,observation\n" + "\n".join(rows) + "\n").encode()


def _cell(text: str) -> str:
    return f'"{text.replace(chr(34), chr(34) * 2)}"' if re.search(r'[,;"\t]', text) else text


def _text(
    case: PestCase,
    call: CommandLine,
    files: Sequence[str],
    templates: Mapping[str, str],
    instructions: Mapping[str, str],
    series: Sequence[PestSeries],
    parameters: Sequence[ParameterLine],
    notes: Sequence[str],
) -> str:
    """The problem file."""
    free = sum(line.section.startswith("lower:") for line in parameters)
    lines = [
        f"# Made of the control file {case.path.name}. The objective is PEST's, the sum of (weight * residual)^2.",
        *(["# Not carried over, or to be known:"] if notes else []),
        *(line for note in notes for line in _remark(note, "# - ", "#   ")),
        f"name: {_plain(re.sub(r'[^A-Za-z0-9_.-]', '_', case.path.stem))}",
        "forward_model:",
        "  kind: command",
        *(f"  # {line}" for line in ([f"{SCRIPT} is to be:", *call.script.splitlines()] if call.script else [])),
        f"  run: {_list(call.arguments)}",
        *([f"  files: {_list(files)}"] if files else []),
        "  templates:",
        *(f"    {_plain(target)}: {_plain(source)}" for target, source in templates.items()),
        "  series:",
    ]
    for one in series:
        observed = "" if one.counts else "; not observed, as all weights are 0"
        lines += [
            *_remark(f"observation group {one.group}{observed}; x is {one.x_from}", "    # ", "    # "),
            f"    {one.name}:",
            f"      file: {_plain(one.files.model)}",
            f"      instructions: {_plain(instructions[one.files.pest])}",
            "      observations:",
            *(f"        {_plain(o.name)}: {x!r}" for o, x in zip(one.observations, one.x, strict=True)),
        ]
    lines.append("parameters:")
    group = None
    for line in parameters:
        if line.group != group:
            group = line.group
            lines.append(f"  # parameter group {group}")
        lines.append(f"  {line.name}: {{{line.section}}}{f'   # {line.remark}' if line.remark else ''}")
    lines.append("observations:   # weight of a point: square of PEST's; of a series: number of its points")
    lines += [
        f"  - {{series: {one.name}, file: {one.name}.csv, weight: {len(one.observations)}}}"
        for one in series
        if one.counts
    ]
    lines += [
        "method: {kind: particle_swarm}",
        f"stopping: {{max_evaluations: {max(500, 200 * free)}, stagnation_generations: 30}}",
        "seed: 1",
    ]
    return "\n".join(lines) + "\n"


def _remark(text: str, first: str, then: str) -> list[str]:
    return textwrap.wrap(
        text, _WIDTH, initial_indent=first, subsequent_indent=then, break_long_words=False, break_on_hyphens=False
    )


def _list(texts: Iterable[str]) -> str:
    return f"[{', '.join(map(_plain, texts))}]"


def _plain(text: str) -> str:
    """A text as YAML reads it."""
    if re.fullmatch(r"[A-Za-z_./][\w./-]*", text, re.ASCII) and text.lower() not in ("null", "true", "false", ".nan"):
        return text
    return '"' + text.replace("\\", "\\\\").replace('"', '\\"') + '"'
