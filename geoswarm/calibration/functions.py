"""How a function reaches the processes that call it: by its file and name, or why it cannot.

Evaluation processes are not copies of this one: they import the file of the function, under another name than
``__main__``. So a function is sent that is written in a file, by ``def``, outside of any other, and is still what
stands there. A script that calibrates while it is being imported would do so again there: it must have its call below
``if __name__ == "__main__":``. Any other function stays in this process.
"""

from __future__ import annotations

import ast
import inspect
import sys
import warnings
from collections.abc import Callable, Mapping
from pathlib import Path
from types import CodeType, FrameType, FunctionType
from typing import Any

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.external.python.loading import file_being_imported, fingerprint, keep_function
from geoswarm.solver.external.python.signature import Signature, SignatureError, signature_in, signature_of

__all__ = ["InProcessWarning", "function_section", "refuse_while_imported", "warn_in_process"]

GUARD = 'if __name__ == "__main__":'


class InProcessWarning(UserWarning):
    """A function runs in this process: several workers and limits do not apply.

    Examples
    --------
    >>> import warnings
    >>> import geoswarm as gs
    >>> with warnings.catch_warnings():
    ...     warnings.simplefilter("ignore", gs.InProcessWarning)  # one worker is meant
    ...     result = gs.calibrate(
    ...         lambda x, a: a * x,
    ...         parameters={"a": gs.free(0, 10)},
    ...         observations=gs.observed([1, 2], [2, 4]),
    ...         stopping={"max_evaluations": 20},
    ...         seed=1,
    ...     )
    >>> result.state
    'finished'
    """


def function_section(function: Callable[..., Any], series: Mapping[str, Any]) -> tuple[dict[str, Any], str | None]:
    """Return the ``forward_model`` section of a function, and why it stays in this process (None if it does not).

    Parameters
    ----------
    series
        How its values are to be read.

    Raises
    ------
    ProblemError
        The function takes arguments that cannot be given.
    """
    called = _called(function)
    try:
        signature = signature_of(function, called)
    except SignatureError as error:
        raise ProblemError([Issue("forward_model.function", str(error))]) from None
    section: dict[str, Any] = {"kind": "python", "function": called[:200], "series": dict(series)}
    try:
        return section | _in_file(function, signature), None
    except _StaysError as reason:
        own = {"signature": signature.model_dump(mode="json"), "session": keep_function(function)}
        return section | own, str(reason)


def warn_in_process(called: str, reason: str, *, lost: str) -> None:
    """Warn, at the line of the user's call, that a function stays in this process."""
    message = f"{called} is calculated in this process, because it {reason}\n{lost}"
    warnings.warn(message, InProcessWarning, stacklevel=_levels_to_user())


def refuse_while_imported(what: str) -> None:
    """Refuse a call that is made while the file of a function is being imported.

    Raises
    ------
    ProblemError
        It says what to do.
    """
    path = file_being_imported()
    if path is not None:
        message = (
            f"{path.name} calls {what} while it is imported for its function; put all but definitions below {GUARD}"
        )
        raise ProblemError([Issue("", message)])


class _StaysError(Exception):
    """A function cannot be found by another process; the message completes 'because it'."""


def _in_file(function: Callable[..., Any], signature: Signature) -> dict[str, Any]:
    """File, folder and version of a function."""
    plain = inspect.unwrap(getattr(function, "py_func", function))
    name, qualified = getattr(function, "__name__", None), getattr(function, "__qualname__", None)
    if not isinstance(plain, FunctionType) or not isinstance(name, str):
        raise _StaysError(f"is a {type(function).__name__}, no function that is written by def in a file")
    if name == "<lambda>":
        raise _StaysError("is a lambda, which no other process can find; write it by def, outside of any function")
    if name != qualified:
        raise _StaysError(f"is {qualified}, inside of something else; write it outside of any function or class")
    module = sys.modules.get(function.__module__ or "")
    file = getattr(module, "__file__", None)
    if getattr(module, name, None) is not function or file is None or file.startswith("<"):
        raise _StaysError("was not written in a file (a notebook, or an interactive session); write it into a file")
    path = Path(file).resolve()
    if path.suffix != ".py" or not path.is_file():
        raise _StaysError(f"is in {path}, which is no .py file")
    source = path.read_bytes()
    if not _holds(source, path, plain.__code__):
        raise _StaysError(f"is not what {path.name} contains now; import it again")
    try:
        same = signature_in(source, path.name, name) == signature
    except SignatureError as error:
        raise _StaysError(f"cannot be found by its name: {error}") from None
    if not same:
        raise _StaysError(f"takes other arguments than its definition in {path.name}")
    if _called_while_read(path):
        raise _StaysError(f"is in {path.name}, which calls this outside of a main guard; put the call below {GUARD}")
    folder, relative = _place(path)
    return {"folder": str(folder), "file": relative, "version": fingerprint(source), "signature": _plain(signature)}


def _plain(signature: Signature) -> dict[str, Any]:
    return signature.model_dump(mode="json")


def _place(path: Path) -> tuple[Path, str]:
    """The folder from which a file is imported, above its packages, and its name below that."""
    folder = path.parent
    while (folder / "__init__.py").is_file() and folder.parent != folder:
        folder = folder.parent
    return folder, path.relative_to(folder).as_posix()


def _holds(source: bytes, path: Path, wanted: CodeType) -> bool:
    """Whether a file, compiled, holds this very code."""
    try:
        pending = [compile(source, str(path), "exec", dont_inherit=True)]
    except (SyntaxError, ValueError):
        return False
    while pending:
        code = pending.pop()
        if code == wanted:
            return True
        pending += [inner for inner in code.co_consts if isinstance(inner, CodeType)]
    return False


def _called_while_read(path: Path) -> bool:
    """Whether the present call comes from the outermost level of a file, and not from below its main guard."""
    frame: FrameType | None = sys._getframe()
    while frame is not None:
        if frame.f_code.co_name == "<module>" and _is(frame.f_code.co_filename, path):
            return not _is_guarded(path, frame.f_lineno)
        frame = frame.f_back
    return False


def _is(file: str, path: Path) -> bool:
    return not file.startswith("<") and Path(file).resolve() == path


def _is_guarded(path: Path, line: int) -> bool:
    for node in ast.parse(path.read_bytes()).body:
        if isinstance(node, ast.If) and _is_main(node.test) and node.body:
            last = node.body[-1].end_lineno or 0
            if node.body[0].lineno <= line <= last:
                return True
    return False


def _is_main(test: ast.expr) -> bool:
    if isinstance(test, ast.BoolOp) and isinstance(test.op, ast.And):
        return any(_is_main(part) for part in test.values)
    return ast.unparse(test) in ("__name__ == '__main__'", "'__main__' == __name__")


def _called(function: Callable[..., Any]) -> str:
    inner = getattr(function, "func", function)  # of a partial
    name = getattr(function, "__name__", None) or getattr(inner, "__name__", None)
    return name if isinstance(name, str) and name else type(function).__name__


def _levels_to_user() -> int:
    """How far up the first frame outside of this package is, as warnings count."""
    package = str(Path(__file__).parent)
    frame: FrameType | None = sys._getframe(1)
    level = 1
    while frame is not None and frame.f_code.co_filename.startswith(package):
        frame, level = frame.f_back, level + 1
    return level
