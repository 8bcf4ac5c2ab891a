"""Imports the file of a function by its path, under a name of its own, once in a process.

The name is not ``__main__``, so what stands below ``if __name__ == "__main__":`` is not executed: a script can be the
file of a function. A file inside a package (a folder with ``__init__.py``) is imported as that package's module.
"""

from __future__ import annotations

import ast
import hashlib
import importlib.abc
import importlib.util
import sys
import threading
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any

from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.python.failures import failure_of

__all__ = [
    "NOT_IMPORTED",
    "file_being_imported",
    "fingerprint",
    "folder_importable",
    "function_of_session",
    "keep_function",
    "load_function",
]

NOT_IMPORTED = "cannot be imported"
"""In the message of every evaluation that failed for that."""

_lock = threading.RLock()
_loaded: dict[tuple[Path, str], ModuleType | RunFailedError] = {}
_importing: list[Path] = []


def fingerprint(source: bytes) -> str:
    """Return the SHA-256 of the contents of a file."""
    return hashlib.sha256(source).hexdigest()


def file_being_imported() -> Path | None:
    """Return the file of a function that is being imported now, None: none is."""
    return _importing[-1] if _importing else None


@contextmanager
def folder_importable(folder: Path) -> Iterator[None]:
    """Have the modules of a folder importable, first of all, meanwhile."""
    name = str(folder)
    if sys.path[:1] == [name]:
        yield
        return
    sys.path.insert(0, name)
    try:
        yield
    finally:
        if name in sys.path:
            sys.path.remove(name)


def load_function(folder: Path, file: str, version: str, function: str) -> Callable[..., Any]:
    """Return a function of a file.

    Parameters
    ----------
    folder
        Importable meanwhile.
    file
        Relative to it.
    version
        SHA-256 of its contents: another file is not the same forward model.

    Raises
    ------
    RunFailedError
        The file is gone or has changed, cannot be imported, or has no such function. A file that could not be imported
        is not tried again.
    """
    path = (folder / file).resolve()
    with _lock:
        key = (path, version)
        if key not in _loaded:
            try:
                _loaded[key] = _imported(folder, path, version)
            except RunFailedError as error:
                _loaded[key] = error
        module = _loaded[key]
    if isinstance(module, RunFailedError):
        raise RunFailedError("bad_output", str(module))
    found = getattr(module, function, None)
    if not callable(found):
        raise RunFailedError("bad_output", f"{file} has no function {function} after it was imported")
    return found  # type: ignore[no-any-return]  # anybody's function


def _imported(folder: Path, path: Path, version: str) -> ModuleType:
    try:
        source = path.read_bytes()
    except OSError as error:
        raise RunFailedError("bad_output", f"{path} cannot be read: {error.strerror or error}") from None
    if fingerprint(source) != version:
        raise RunFailedError(
            "bad_output", f"{path} has changed since this problem was made of it; start the calibration over"
        )
    package = _package_of(folder, path)
    if package is None:
        _refuse_other_siblings(source, path)
    _importing.append(path)
    try:
        with folder_importable(folder):
            return _as_file(path, source) if package is None else _as_module(package, path)
    except RunFailedError:
        raise
    except (Exception, SystemExit) as error:  # noqa: BLE001  anybody's file
        told = failure_of(error, str(path), f"{path.name} {NOT_IMPORTED}: it")
        raise RunFailedError("bad_output", str(told)) from None
    finally:
        _importing.pop()


class _Source(importlib.abc.SourceLoader):
    """Loads what was read, never a compiled copy of an earlier version."""

    def __init__(self, path: Path, source: bytes) -> None:
        self._path, self._source = path, source

    def get_filename(self, fullname: str) -> str:
        del fullname
        return str(self._path)

    def get_data(self, path: str | bytes) -> bytes:
        del path
        return self._source


def _as_file(path: Path, source: bytes) -> ModuleType:
    name = f"geoswarm_function_{path.stem}_{hashlib.sha256(str(path).encode()).hexdigest()[:8]}"
    loader = _Source(path, source)
    spec = importlib.util.spec_from_file_location(name, path, loader=loader)
    if spec is None:
        raise RunFailedError("bad_output", f"{path} cannot be imported")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        loader.exec_module(module)
    except BaseException:
        sys.modules.pop(name, None)
        raise
    return module


def _as_module(name: str, path: Path) -> ModuleType:
    module = import_module(name)
    found = getattr(module, "__file__", None)
    if found is None or Path(found).resolve() != path:
        raise RunFailedError(
            "bad_output", f"{path} is {name}, but this process has another one of that name: {found}; rename one"
        )
    return module


def _package_of(folder: Path, path: Path) -> str | None:
    """Dotted name of a file inside a package below the folder; None: it is a file of its own."""
    try:
        parts = path.relative_to(folder.resolve()).with_suffix("").parts
    except ValueError:
        return None
    if len(parts) > 1 and (folder / parts[0] / "__init__.py").is_file():
        return ".".join(parts)
    return None


def _refuse_other_siblings(source: bytes, path: Path) -> None:
    """What a file imports from beside it must not be loaded already from another place: it would get that silently."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            names = [node.module]
        else:
            continue
        for name in {full.partition(".")[0] for full in names}:
            beside = [path.parent / f"{name}.py", path.parent / name / "__init__.py"]
            wanted = next((one for one in beside if one.is_file()), None)
            there = getattr(sys.modules.get(name), "__file__", None)
            if wanted is not None and name in sys.modules and (there is None or not _same(Path(there), wanted)):
                raise RunFailedError(
                    "bad_output",
                    f"{path.name} imports {name}, and {wanted} is in the same folder; but that name is taken by "
                    f"{there or 'a module of Python'}: rename the file",
                )


def _same(first: Path, second: Path) -> bool:
    return first.resolve() == second.resolve()


_functions: dict[str, Callable[..., Any]] = {}


def keep_function(function: Callable[..., Any]) -> str:
    """Keep a function; return the word by which problems of this process find it again."""
    for word, known in _functions.items():
        if known is function:
            return word
    word = uuid.uuid4().hex
    _functions[word] = function
    return word


def function_of_session(word: str, name: str) -> Callable[..., Any]:
    """Return a function that was kept.

    Raises
    ------
    RunFailedError
        It was one of another process, or of an earlier one.
    """
    try:
        return _functions[word]
    except KeyError:
        raise RunFailedError(
            "bad_output",
            f"{name} was a function of a Python session that has ended; write it into a file (kind: python, file: "
            "model.py) to run it again",
        ) from None
