"""Which parameters a function has: read from the source of its file, which is not executed, or from the function."""

from __future__ import annotations

import ast
import inspect
import math
from collections.abc import Callable, Iterable, Iterator
from typing import Any

from pydantic import BaseModel, ConfigDict, Field

__all__ = ["POINTS", "Signature", "SignatureError", "signature_in", "signature_of"]

POINTS = "x"
"""Argument that receives the observed points."""

_Function = ast.FunctionDef | ast.AsyncFunctionDef


class SignatureError(ValueError):
    """A function is not there, or takes arguments that no parameter can be given to."""


class Signature(BaseModel):
    """What a function takes.

    Parameters
    ----------
    parameters
        Its parameters in order, with the number that each has by itself; None: it must be given.
    points
        Whether it takes the observed points, as ``x``.
    open
        Whether it takes parameters of any name (``**kwargs``).
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    parameters: dict[str, float | None] = Field({}, max_length=1000)
    points: bool = False
    open: bool = False


def signature_in(source: bytes, file: str, function: str) -> Signature:
    """Return what a function of a file takes; nothing of the file is executed.

    Parameters
    ----------
    source
        Contents of the file.
    file
        Its name, for messages.

    Raises
    ------
    SignatureError
        The file is no Python, has no such function, or the function takes what cannot be given.

    Examples
    --------
    >>> signature_in(b"def f(x, E, nu=0.3): ...", "model.py", "f").parameters
    {'E': None, 'nu': 0.3}
    """
    try:
        tree = ast.parse(source, file)
    except SyntaxError as error:
        place = "" if error.lineno is None else f", line {error.lineno}"
        raise SignatureError(f"{file}{place} is not valid Python: {error.msg}") from None
    except (ValueError, RecursionError, MemoryError) as error:
        raise SignatureError(f"{file} cannot be read as Python: {error or type(error).__name__}") from None
    found: _Function | None = None
    other: str | None = None
    names: dict[str, None] = {}
    for statement in _statements(tree.body):
        if isinstance(statement, _Function):
            names[statement.name] = None
            if statement.name == function:
                found, other = statement, None
        elif what := _binds(statement, function):
            found, other = None, f"line {statement.lineno} {what}"
    if other is not None:
        raise SignatureError(
            f"{function} of {file}: {other}; a function that is written there as def {function}(...) is accepted"
        )
    if found is None:
        public = [name for name in names if not name.startswith("_")]
        raise SignatureError(f"{file} has no function {function}; it has {', '.join(public[:50]) or 'none'}")
    return _of_definition(found, f"{function} of {file}")


def signature_of(function: Callable[..., Any], called: str) -> Signature:
    """Return what a function takes that is at hand.

    Parameters
    ----------
    called
        What it is called in messages.

    Raises
    ------
    SignatureError
        It does not say what it takes, or takes what cannot be given.
    """
    try:
        found = inspect.signature(function)
    except (TypeError, ValueError):
        raise SignatureError(
            f"{called} does not say which arguments it takes; wrap it: lambda E, k: {called}(...)"
        ) from None
    if inspect.iscoroutinefunction(function):
        raise SignatureError(f"{called} is async; a plain function is accepted")
    kinds = inspect.Parameter
    named, positional, many, is_open = [], [], False, False
    for one in found.parameters.values():
        if one.kind is kinds.POSITIONAL_ONLY:
            positional.append(one.name)
        elif one.kind is kinds.VAR_POSITIONAL:
            many = True
        elif one.kind is kinds.VAR_KEYWORD:
            is_open = True
        else:
            named.append((one.name, one.default is not kinds.empty, _number(one.default)))
    return _signature(called, named, positional, many, is_open)


def _of_definition(found: _Function, called: str) -> Signature:
    if isinstance(found, ast.AsyncFunctionDef):
        raise SignatureError(f"{called} is async; a plain function is accepted")
    arguments = found.args
    plain = [*arguments.posonlyargs, *arguments.args]
    defaults: list[ast.expr | None] = [None] * (len(plain) - len(arguments.defaults)) + list(arguments.defaults)
    pairs = [*zip(plain, defaults, strict=True), *zip(arguments.kwonlyargs, arguments.kw_defaults, strict=True)]
    named = [
        (argument.arg, default is not None, _literal(default))
        for argument, default in pairs
        if argument not in arguments.posonlyargs
    ]
    positional = [argument.arg for argument in arguments.posonlyargs]
    return _signature(called, named, positional, arguments.vararg is not None, arguments.kwarg is not None)


def _signature(
    called: str, named: Iterable[tuple[str, bool, float | None]], positional: list[str], many: bool, is_open: bool
) -> Signature:
    """``named``: name, whether it has a default, and that default if it is a number."""
    if positional:
        raise SignatureError(
            f"{called} takes {', '.join(positional)} by position only; arguments are given by name: leave the / out"
        )
    if many:
        raise SignatureError(f"{called} takes *arguments without names; write one argument for each parameter")
    parameters: dict[str, float | None] = {}
    points = False
    for name, optional, value in named:
        if name == POINTS:
            points = True
        elif not optional or value is not None:
            parameters[name] = value
    return Signature(parameters=parameters, points=points, open=is_open)


def _literal(default: ast.expr | None) -> float | None:
    """A default that is written as a number, else None."""
    if default is None:
        return None
    try:
        return _number(ast.literal_eval(default))
    except (ValueError, TypeError, SyntaxError, MemoryError, RecursionError):
        return None


def _number(value: Any) -> float | None:
    if isinstance(value, bool) or not isinstance(value, int | float):
        return None
    try:
        number = float(value)
    except OverflowError:
        return None
    return number if math.isfinite(number) else None


def _statements(body: Iterable[ast.stmt]) -> Iterator[ast.stmt]:
    """Statements of a module, also those below its if, try, with and for."""
    for statement in body:
        yield statement
        if isinstance(statement, _Function | ast.ClassDef):
            continue
        for field in ("body", "orelse", "finalbody"):
            yield from _statements(getattr(statement, field, ()))
        for handler in getattr(statement, "handlers", ()):
            yield from _statements(handler.body)


def _binds(statement: ast.stmt, name: str) -> str | None:
    """How a statement makes something else of a name, or None."""
    if isinstance(statement, ast.ClassDef) and statement.name == name:
        return "makes it a class"
    if isinstance(statement, ast.Import | ast.ImportFrom):
        bound = [alias.asname or alias.name.partition(".")[0] for alias in statement.names]
        return "imports it from elsewhere" if name in bound else None
    targets: list[ast.expr] = []
    if isinstance(statement, ast.Assign):
        targets = statement.targets
    elif isinstance(statement, ast.AnnAssign | ast.AugAssign):
        targets = [statement.target]
    return "assigns it" if any(_is_bound(target, name) for target in targets) else None


def _is_bound(target: ast.expr, name: str) -> bool:
    """Whether an assignment binds the name itself, not an item or attribute of it."""
    if isinstance(target, ast.Name):
        return target.id == name
    if isinstance(target, ast.Tuple | ast.List):
        return any(_is_bound(inner, name) for inner in target.elts)
    return isinstance(target, ast.Starred) and _is_bound(target.value, name)
