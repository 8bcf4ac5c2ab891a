"""Opens shared libraries of the user's, and finds functions in them."""

from __future__ import annotations

import ctypes
import os
import re
from functools import cache
from pathlib import Path

from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.external.runs.fingerprints import fingerprint

__all__ = ["address_of", "loaded", "opened", "pointer_in"]

_ENVIRONMENT = {
    # Unit 7, the message file of Abaqus, goes where errors go, not into a file fort.7 in the working folder; and what
    # a routine has written is seen also when it ends its process.
    "GFORTRAN_STDERR_UNIT": "7",
    "GFORTRAN_UNBUFFERED_PRECONNECTED": "y",
}
"""For the library of gfortran, which reads it when it is loaded."""

_MISSING = re.compile(r"undefined symbol: (\S+)")


@cache
def opened(path: Path, version: str) -> ctypes.CDLL:
    """Open a library, once in a process.

    Parameters
    ----------
    version
        SHA-256 that the file must have.

    Raises
    ------
    RunFailedError
        ``not_started``: it is missing, has changed, or cannot be loaded, for instance as it lacks a function.
    """
    try:
        found = fingerprint(path)
    except OSError as error:
        raise RunFailedError("not_started", f"the library {path} cannot be read: {error.strerror or error}") from None
    if found != version:
        raise RunFailedError(
            "not_started", f"the library {path} has changed since the problem was read; start over, or restore it"
        )
    try:
        return loaded(path)
    except OSError as error:
        raise RunFailedError("not_started", f"the library {path} cannot be loaded: {_words(str(error))}") from None


def loaded(path: Path) -> ctypes.CDLL:
    """Load a library with all that it needs; raises OSError."""
    for name, value in _ENVIRONMENT.items():
        os.environ.setdefault(name, value)
    return ctypes.CDLL(str(path), mode=os.RTLD_NOW | os.RTLD_LOCAL)


def _words(message: str) -> str:
    missing = _MISSING.search(message)
    if missing is None:
        return message
    return (
        f"it calls {missing[1]}, which it does not have; `geoswarm model build-umat` links the utilities of Abaqus "
        "with a routine"
    )


def address_of(library: ctypes.CDLL, function: str) -> int:
    """Return the address of a function in a library.

    Raises
    ------
    RunFailedError
        ``not_started``: there is none of this name.
    """
    try:
        found = getattr(library, function)
    except AttributeError:
        raise RunFailedError(
            "not_started",
            f"there is no function '{function}' in {library._name}; Fortran compilers write small letters and an "
            "underscore behind (umat_)",
        ) from None
    return int(ctypes.cast(found, ctypes.c_void_p).value or 0)


def pointer_in(library: ctypes.CDLL, name: str) -> int:
    """Return the address of a pointer that a library has under a name; 0: none."""
    try:
        return ctypes.addressof(ctypes.c_void_p.in_dll(library, name))
    except ValueError:
        return 0
