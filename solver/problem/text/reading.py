"""Reads YAML and JSON problem files: YAML 1.2, no tags, duplicate keys refused, every syntax error in one line."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from itertools import chain, pairwise
from pathlib import Path
from typing import Any, Literal, TypeAlias

import numpy as np

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.problem.issues import join_path
from geoswarm.solver.problem.text.yaml_nodes import MAX_DEPTH, too_deep

__all__ = ["Form", "MAX_BYTES", "duplicate_place", "plain_document", "read_document", "read_problem_file"]

_MAX_VALUES = 4_000_000
_MAX_KEYS = 10_000

Form: TypeAlias = Literal["yaml", "json"]

MAX_BYTES: dict[Form, int] = {"yaml": 4 * 2**20, "json": 32 * 2**20}
"""Largest problem file. YAML is read slowly; JSON also carries the measured data that a client has put in."""

_HALF = re.compile("[\ud800-\udfff]")
_FORMS: dict[str, Form] = {".json": "json", ".yaml": "yaml", ".yml": "yaml"}

# What the YAML reader raises for text that it cannot make sense of, beside its own YAMLError: impossible dates
# (ValueError), unhashable keys (TypeError), lone tags (AttributeError, NotImplementedError) and the like.
_READING_ERRORS = (ValueError, TypeError, LookupError, AttributeError, AssertionError, NotImplementedError)


# A string that does not end reaches to the end of the text, so that each character is looked at once.
_PIECE = re.compile(r'"(?:[^"\\]|\\.)*+"?|[{}\[\]:,]', re.DOTALL)


def read_problem_file(path: Path) -> dict[str, Any]:
    """Read a problem file, JSON when it ends in ``.json``, YAML when it ends in ``.yaml`` or ``.yml``.

    Raises
    ------
    ProblemError
        The file is missing, unreadable, too large, or not as :func:`read_document` wants it.
    """
    form = _FORMS.get(path.suffix.lower())
    if form is None:
        raise _error(f"{path}: the name of a problem file ends in .yaml, .yml or .json")
    return read_document(_text(path, MAX_BYTES[form]), form)


def _text(path: Path, most: int) -> str:
    if path.is_fifo():  # a pipe would be waited for
        raise _error(f"{path}: a pipe, not a file")
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except FileNotFoundError:
        raise _error(f"{path}: no such file") from None
    except (OSError, ValueError) as error:
        reason = error.strerror if isinstance(error, OSError) else str(error)
        raise _error(f"{path}: cannot be read: {reason}") from None
    if len(content) > most:
        raise _too_large(most)
    try:
        return content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise _error(f"{path}: not UTF-8 text: {error.reason} at byte {error.start}") from None


def read_document(text: str, form: Form) -> dict[str, Any]:
    """Read the text of a problem.

    Returns
    -------
    Mapping of plain values (text, numbers, true, false, null, lists, mappings with text keys), in the text's order.

    Raises
    ------
    ProblemError
        Syntax error or duplicate key (both with line and column), not a mapping, too large or nested too deeply.
    """
    if len(text) > MAX_BYTES[form]:
        raise _too_large(MAX_BYTES[form])
    try:
        document = _from_json(text) if form == "json" else _from_yaml(text)
    except RecursionError:
        raise too_deep("") from None
    return plain_document(document)


def _from_json(text: str) -> Any:
    try:
        return json.loads(text, object_pairs_hook=_without_duplicates)
    except _DuplicateError as error:
        raise _error(f"key '{_short(error.key)}' is given twice, the second time{duplicate_place(text)}") from None
    except json.JSONDecodeError as error:
        raise _error(f"JSON syntax error in line {error.lineno}, column {error.colno}: {error.msg}") from None
    except ValueError:
        raise _error("JSON cannot be read: it has a number with thousands of digits") from None


class _DuplicateError(Exception):
    def __init__(self, key: str) -> None:
        self.key = key


def _without_duplicates(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    mapping: dict[str, Any] = {}
    for key, value in pairs:
        if key in mapping:
            raise _DuplicateError(key)
        mapping[key] = value
    return mapping


def _from_yaml(text: str) -> Any:
    from ruamel.yaml.constructor import DuplicateKeyError
    from ruamel.yaml.error import MarkedYAMLError, YAMLError

    from geoswarm.solver.problem.text.yaml_nodes import reader

    try:
        return reader().load(text)
    except DuplicateKeyError as error:
        key = str(error.problem).partition('"')[2].partition('"')[0]
        raise _error(f"key '{_short(key)}' is given twice, the second time{_place(error.problem_mark)}") from None
    except MarkedYAMLError as error:
        place = _place(error.problem_mark or error.context_mark)
        raise _error(
            f"YAML syntax error{place}: {_syntax(error.problem or error.context or 'not understood')}"
        ) from None
    except YAMLError as error:
        raise _error(f"YAML syntax error: {_short(' '.join(str(error).split()))}") from None
    except _READING_ERRORS as error:
        if "integer string conversion" in str(error):
            raise _error("YAML cannot be read: it has a number with thousands of digits") from None
        raise _error(f"YAML cannot be read: {_short(' '.join(str(error).split()))}") from None


def _syntax(problem: str) -> str:
    if "'\\t'" in problem:
        return "a tab; YAML is indented with spaces"
    return _short(problem.replace("'<scalar>'", "text or a number"))


def _place(mark: Any) -> str:
    return "" if mark is None else f" in line {mark.line + 1}, column {mark.column + 1}"


def plain_document(document: Any) -> dict[str, Any]:
    """Copy a document of any mappings, sequences and NumPy values into plain values, as JSON knows them.

    Raises
    ------
    ProblemError
        It is not a mapping, or a value is nothing that JSON knows (a date, bytes ...).
    """
    if not isinstance(document, Mapping):
        given = "empty" if document is None else f"a {_kind(document)}"
        raise _error(f"a problem is a mapping (name, forward_model, parameters, ...), but this is {given}")
    mapping: dict[str, Any] = _Plain().copy(document, 0)
    return mapping


class _Plain:
    def __init__(self) -> None:
        self._values = 0
        self._steps: list[str | int] = []  # to the present value; a path for each would copy long keys again and again

    def copy(self, value: Any, depth: int) -> Any:
        self._values += 1
        if depth > MAX_DEPTH:
            raise too_deep(self._path)
        if self._values > _MAX_VALUES:
            raise self._wrong(f"the problem has more than {_MAX_VALUES} values")
        if isinstance(value, np.ndarray | np.generic):
            return self.copy(value.tolist(), depth)
        if value is None or isinstance(value, str | bool | int | float):
            return self._scalar(value)
        if isinstance(value, Mapping):
            return self._mapping(value, depth)
        if isinstance(value, list) and set(map(type, value)) == {float} and self._values + len(value) <= _MAX_VALUES:
            self._values += len(value)  # long series of numbers, the quick way
            return list(value)
        if isinstance(value, list | tuple):
            return [self._inner(item, index, depth) for index, item in enumerate(value)]
        raise self._wrong(f"{_short(str(value))} is a {_kind(value)}; if text is meant, write it in quotes")

    def _inner(self, value: Any, step: str | int, depth: int) -> Any:
        self._steps.append(step)
        copied = self.copy(value, depth + 1)
        self._steps.pop()
        return copied

    def _mapping(self, mapping: Mapping[Any, Any], depth: int) -> dict[str, Any]:
        if len(mapping) > _MAX_KEYS:
            raise self._wrong(f"has {len(mapping)} keys; at most {_MAX_KEYS} are accepted")
        copied = {}
        for key, value in mapping.items():
            if type(key) is int and self._steps[-2:] == ["fail", "exit"]:  # exit statuses are numbers to their users
                key = str(key)
            if not isinstance(key, str):
                raise self._wrong(f"key {_short(str(key))} is a {_kind(key)}; write it in quotes")
            copied[key] = self._inner(value, key, depth)
        return copied

    def _scalar(self, value: Any) -> Any:
        if isinstance(value, int) and not isinstance(value, bool) and abs(value) >= 2**1024:
            raise self._wrong("number is too large; the largest is 1.79e308")
        if isinstance(value, str) and not value.isascii() and _HALF.search(value):
            raise self._wrong("text holds half a Unicode character")
        return value

    @property
    def _path(self) -> str:
        return join_path("", self._steps)

    def _wrong(self, message: str) -> ProblemError:
        return ProblemError([Issue(self._path, message)])


def _kind(value: Any) -> str:
    names = {"bool": "truth value", "int": "number", "float": "number", "str": "text", "NoneType": "null"}
    return names.get(type(value).__name__, type(value).__name__)


def _short(text: str, length: int = 200) -> str:
    return text if len(text) <= length else f"{text[:length]}..."


def _error(message: str) -> ProblemError:
    return ProblemError([Issue("", message)])


def _too_large(most: int) -> ProblemError:
    return _error(f"problem is larger than {most} bytes; put long series into CSV files (file: ...), or write JSON")


def duplicate_place(text: str) -> str:
    """Return `` in line L, column C`` of the first key that its mapping has already; empty where there is none.

    Parameters
    ----------
    text
        JSON, valid up to that place.
    """
    open_ones: list[set[str] | None] = []  # keys of the mappings around a place, None for lists
    for piece, following in pairwise(chain(_PIECE.finditer(text), [None])):
        assert piece is not None  # only the last one is
        sign = piece.group()
        if sign in "{[":
            open_ones.append(set() if sign == "{" else None)
        elif sign in "}]":
            open_ones.pop()
        elif sign[0] == '"' and following is not None and following.group() == ":" and open_ones:
            keys = open_ones[-1]
            key = json.loads(sign, strict=False)
            if keys is not None and key in keys:
                line = text.count("\n", 0, piece.start()) + 1
                return f" in line {line}, column {piece.start() - text.rfind(chr(10), 0, piece.start())}"
            if keys is not None:
                keys.add(key)
    return ""
