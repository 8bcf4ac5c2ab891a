"""Templates, instruction files and files of the program, on their way from a control file's folder to a problem's."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path

from geoswarm.solver.external.errors import TemplateError
from geoswarm.solver.external.inputs.pest_template import parse_pest_template
from geoswarm.solver.external.inputs.texts import read_template_file
from geoswarm.solver.external.outputs.fields import relative_path
from geoswarm.solver.external.outputs.pest.instructions import parse_instructions
from geoswarm.solver.external.pest_control.case import PestCase, PestControlError

__all__ = ["beside", "instruction_names", "model_file", "other_files", "template_with"]

_OF_PEST = {
    *(".pst", ".rec", ".rei", ".res", ".sen", ".seo", ".par", ".jco", ".jcb", ".jst", ".rst", ".rmr", ".rmf", ".svd"),
    *(".mtt", ".cnd", ".log", ".hp", ".rsd", ".rns", ".rnj", ".rnu", ".ipar", ".iobj", ".isen"),
}


def template_with(path: Path, file: str, renamed: Mapping[str, str]) -> tuple[bytes, frozenset[str]]:
    """Return a template with new names in its spaces, which stay as wide, and the names, old ones, that it uses.

    Raises
    ------
    PestControlError
        It cannot be read, or is none.
    """
    try:
        text = read_template_file(path)
        template = parse_pest_template(text, file)
    except TemplateError as error:
        raise PestControlError(str(error)) from None
    if not template.names & renamed.keys():
        return path.read_bytes(), template.names
    first, _, body = text.partition("\n")
    marker = first.split()[1][0]
    lines = []
    for line in body.split("\n"):
        parts = line.split(marker)
        parts[1::2] = [
            part.replace(part.strip(), renamed.get(part.strip().lower(), part.strip())) for part in parts[1::2]
        ]
        lines.append(marker.join(parts))
    return "\n".join([first, *lines]).encode("utf-8", errors="surrogateescape"), template.names


def instruction_names(path: Path, file: str) -> tuple[bytes, tuple[str, ...]]:
    """Return an instruction file and the names, in lower case, that it reads.

    Raises
    ------
    PestControlError
        It cannot be read, or is none.
    """
    try:
        names = parse_instructions(read_template_file(path).replace("\r\n", "\n"), file).names
    except TemplateError as error:
        raise PestControlError(str(error)) from None
    return path.read_bytes(), names


def model_file(name: str) -> str:
    """A file of the model, which lies below the folder of a run.

    Raises
    ------
    PestControlError
        It does not.
    """
    try:
        return relative_path(name)
    except ValueError as error:
        raise PestControlError(f"model file {error}") from None


def beside(case: PestCase, words: Iterable[str]) -> list[str]:
    """Those of some words that are files or folders beside the control file, and not made by a run."""
    made = {pair.model for pair in (*case.templates, *case.instructions)}
    found = []
    for text in words:
        name = re.sub(r"^(\./)+", "", text)
        if name in made or name.startswith(("/", "~", "-")) or ".." in name.split("/") or not name.strip("./"):
            continue
        if (case.path.parent / name).exists():
            found.append(name.rstrip("/"))
    return list(dict.fromkeys(found))


def other_files(case: PestCase, copied: Iterable[str], folder: Path) -> list[str]:
    """Files next to the control file that are neither copied, nor PEST's own, nor made by a run."""
    pairs = (*case.templates, *case.instructions)
    known = {*copied, case.path.name, *(pair.pest for pair in pairs), *(pair.model for pair in pairs)}
    names = []
    for path in sorted(case.path.parent.iterdir()):
        hidden = path.name.startswith((".", "__pycache__")) or path.suffix.lower() in _OF_PEST
        if not hidden and path.name not in known and path.resolve() != folder.resolve():
            names.append(path.name + ("/" if path.is_dir() else ""))
    return names
