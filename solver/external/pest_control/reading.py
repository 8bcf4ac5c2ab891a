"""Reads a control file of PEST, version 1 or 2, with pyEMU.

pyEMU stops at a section without lines and says nothing of some others. So the headings are read apart, and what it
found is compared with them: nothing is lost in silence.
"""

from __future__ import annotations

import contextlib
import gc
import importlib
import io
import math
import re
import tempfile
import warnings
from pathlib import Path
from typing import Any

from geoswarm.solver.external.pest_control.case import (
    PestCase,
    PestControlError,
    PestObservation,
    PestPair,
    PestParameter,
)
from geoswarm.solver.external.pest_control.sections import (
    Sections,
    external_files,
    left_out,
    plain_text,
    sections_of,
    with_exponents,
)
from geoswarm.solver.system.extras import needs_extra

__all__ = ["read_case"]

_OWN = {"extra", "longname"}  # columns that pyEMU adds: remarks in lines, and names of a file beside
_OF_PARAMETERS = _OWN | {
    *(
        "parnme",
        "partrans",
        "parchglim",
        "parval1",
        "parlbnd",
        "parubnd",
        "pargp",
        "scale",
        "offset",
        "dercom",
        "partied",
    )
}
_OF_OBSERVATIONS = _OWN | {"obsnme", "obsval", "weight", "obgnme"}
_TRANSFORMS = ("none", "log", "fixed", "tied")


def read_case(path: Path) -> PestCase:
    """Read a control file and the files of data that it names.

    Raises
    ------
    PestControlError
        pyEMU is not installed, or the file cannot be read or understood.
    """
    try:
        text = _decoded(path.read_bytes())
    except OSError as error:
        raise PestControlError(f"{path}: {error.strerror or error}") from None
    try:
        sections = sections_of(text)
    except PestControlError as error:
        raise PestControlError(f"{path} {error}") from None
    control = _control(path, plain_text(text))
    _complete(path, sections, control)
    _counted(path, sections, control)
    return PestCase(
        path,
        tuple(_parameter(row, path) for row in control.parameter_data.to_dict("records")),
        tuple(_observation(row, path) for row in control.observation_data.to_dict("records")),
        _pairs(control.model_input_data),
        _pairs(control.model_output_data),
        tuple(control.model_command),
        (*left_out(sections), *_columns(control)),
    )


def _decoded(content: bytes) -> str:
    """UTF-8, with its mark or without, else Latin-1."""
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError:
        return content.decode("latin-1")


def _control(path: Path, text: str) -> Any:
    """The ``Pst`` of pyEMU, which prints warnings and has no error classes of its own: each of its errors is reported.

    It reads a copy with the text in its own form: exponents with e, small letters.
    """
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            pst = importlib.import_module("pyemu").Pst
    except ImportError:
        raise PestControlError(needs_extra("reading control files of PEST", "pyemu")) from None
    with (
        contextlib.redirect_stdout(io.StringIO()),
        warnings.catch_warnings(),
        tempfile.TemporaryDirectory() as folder,
    ):
        warnings.simplefilter("ignore")
        copy = Path(folder) / path.name
        copy.write_text(text)
        for name in external_files(text):
            if (path.parent / name).is_file():
                Path(folder, name).write_text(with_exponents(_decoded((path.parent / name).read_bytes())))
        try:
            return pst(str(copy), parse_metadata=False)
        except Exception as error:  # noqa: BLE001  pyEMU raises Exception itself
            told = re.sub(r"^error reading ctrl file '.*?': ", "", str(error).replace(folder, str(path.parent)))
        gc.collect()  # closes what pyEMU has left open, without a warning
    raise PestControlError(f"{path} cannot be read as a PEST control file: {told[:500]}")


def _complete(path: Path, sections: Sections, control: Any) -> None:
    """Refuse a file of which pyEMU has read a part only."""
    wanted = {
        "parameter data": control.parameter_data,
        "observation data": control.observation_data,
        "model command line": control.model_command,
    }
    for heading, found in wanted.items():
        if found is None or len(found) == 0:
            raise PestControlError(f"{path}: section '* {heading}' is missing or empty")
    for headings, found, what in (
        (("model input/output", "model input"), control.model_input_data, "template"),
        (("model input/output", "model output"), control.model_output_data, "instruction"),
    ):
        if len(found) == 0:
            present = any(heading in sections for heading in headings)
            empty = next((heading for heading, lines in sections.items() if not lines), None)
            why = (
                f"section '* {empty}' is empty, and what follows was not read" if present and empty else "there is none"
            )
            raise PestControlError(f"{path}: no {what} file was found ({why}); at least one is needed")


def _counted(path: Path, sections: Sections, control: Any) -> None:
    """Compare the counts of the control data, version 1, with what the sections hold."""
    words = [line.split() for line in sections.get("control data", [])]
    if len(words) < 3 or not all(all(word.isdigit() for word in line[:2]) for line in words[1:3]):
        return
    stated = (*words[1][:2], *words[2][:2])
    for name, count, found, what in zip(
        ("NPAR", "NOBS", "NTPLFLE", "NINSFLE"),
        stated,
        (control.parameter_data, control.observation_data, control.model_input_data, control.model_output_data),
        ("parameters", "observations", "template files", "instruction files"),
        strict=True,
    ):
        if int(count) != len(found):
            raise PestControlError(
                f"{path}: {name} is {count}, but the file has {len(found)} {what}; correct one of them"
            )


def _columns(control: Any) -> list[str]:
    """Columns of tables, which version 2 admits, that no problem can say."""
    notes = []
    for table, what, known in (
        (control.parameter_data, "parameter data", _OF_PARAMETERS),
        (control.observation_data, "observation data", _OF_OBSERVATIONS),
    ):
        more = [str(name) for name in table.columns if name not in known and table[name].notna().any()]
        if more:
            notes.append(f"columns of {what} that are not carried over: {', '.join(more)}")
    return notes


def _parameter(row: dict[str, Any], path: Path) -> PestParameter:
    name, transform = str(row["parnme"]).lower(), str(row["partrans"]).lower()
    if transform not in _TRANSFORMS:
        message = f"PARTRANS of parameter {name} must be one of {', '.join(_TRANSFORMS)}, got {transform[:40]}"
        raise PestControlError(f"{path}: {message}")
    numbers = [_finite(row, key, name, path) for key in ("parval1", "parlbnd", "parubnd", "scale", "offset")]
    value, lower, upper, scale, offset = numbers
    parent = row.get("partied")
    tied_to = str(parent).lower() if transform == "tied" and isinstance(parent, str) else None
    return PestParameter(name, transform, value, lower, upper, str(row["pargp"]).lower(), scale, offset, tied_to)


def _observation(row: dict[str, Any], path: Path) -> PestObservation:
    name = str(row["obsnme"]).lower()
    value, weight = (_finite(row, key, name, path) for key in ("obsval", "weight"))
    if weight < 0.0:
        raise PestControlError(f"{path}: the weight of observation {name} must be at least 0, got {weight:g}")
    return PestObservation(name, value, weight, str(row["obgnme"]).lower())


def _finite(row: dict[str, Any], key: str, name: str, path: Path) -> float:
    value = float(row[key])
    if not math.isfinite(value):
        raise PestControlError(f"{path}: {key.upper()} of {name} must be a finite number, got {value}")
    return value


def _pairs(table: Any) -> tuple[PestPair, ...]:
    rows = table.to_dict("records")
    return tuple(PestPair(_plain(row["pest_file"]), _plain(row["model_file"])) for row in rows)


def _plain(name: Any) -> str:
    """A name of a file with / between folders, without quotes and ``./``."""
    text = str(name).strip("\"'").replace("\\", "/")
    while text.startswith("./"):
        text = text[2:]
    return text
