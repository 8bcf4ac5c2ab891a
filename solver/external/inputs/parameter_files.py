"""Files of parameters for programs that read them as data: JSON, YAML or CSV."""

from __future__ import annotations

import csv
import io
import json
import re
from collections.abc import Mapping
from typing import Literal, TypeAlias

from geoswarm.solver.external.inputs.texts import checked, number_text

__all__ = ["ParameterFileKind", "parameter_text"]

ParameterFileKind: TypeAlias = Literal["json", "yaml", "csv"]

_PLAIN = re.compile(r"[A-Za-z_][A-Za-z0-9_.]*", re.ASCII)
_WORDS = frozenset({"y", "n", "yes", "no", "on", "off", "true", "false", "null"})  # no names for YAML 1.1


def parameter_text(kind: ParameterFileKind, values: Mapping[str, float]) -> str:
    """Return a file with names and values, in the order given.

    JSON and YAML hold one mapping; CSV has the heading ``name,value`` and a line for each. Every number reads back to
    the same bits; an ``int`` (such as the slot) is written without a point.

    Raises
    ------
    InputError
        A value is not finite.

    Examples
    --------
    >>> print(parameter_text("yaml", {"E": 2e4, "k": 1e-9}), end="")
    E: 20000.0
    k: 1.0e-09
    """
    written = {name: _written(name, value) for name, value in values.items()}
    if kind == "csv":
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([("name", "value"), *written.items()])
        return text.getvalue()
    if kind == "yaml":
        return "".join(f"{_key(name)}: {value}\n" for name, value in written.items()) or "{}\n"
    inner = ",\n".join(f"  {json.dumps(name)}: {value}" for name, value in written.items())
    return f"{{\n{inner}\n}}\n" if inner else "{}\n"


def _written(name: str, value: float) -> str:
    number = checked(value, f"parameter {name}")
    return str(value) if type(value) is int else number_text(number)


def _key(name: str) -> str:
    return name if _PLAIN.fullmatch(name) and name.lower() not in _WORDS else json.dumps(name)
