"""Compiles Fortran sources of Abaqus user routines to a library, with gfortran.

What is compiled with them is in the folder ``fortran``: ABA_PARAM.INC, and the utilities that such routines call.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from geoswarm.solver.errors import SolverError
from geoswarm.solver.user_laws.library import loaded

__all__ = ["BuildError", "Built", "build_umat"]

_FOLDER = Path(__file__).parent / "fortran"
_INCLUDE, _UTILITIES = _FOLDER / "aba_param.inc", _FOLDER / "utilities.f90"
_INCLUDE_NAMES = ("aba_param.inc", "ABA_PARAM.INC")

_WRAPPED = (
    *("stop_string", "stop_numeric", "error_stop_string", "error_stop_numeric"),
    *("exit_i4", "abort", "runtime_error_at"),
)
"""Functions of gfortran's library that end the process; calls of them go to the utilities."""

_FLAGS = (
    "-O2",
    "-fPIC",
    "-std=legacy",  # most routines are written in FORTRAN 77 with extensions
    "-frecursive",  # local arrays on the stack, as Abaqus compiles them: no state between calls unless SAVE says so
)
_SUFFIXES = (".f", ".for", ".ftn", ".f77", ".f90", ".f95", ".f03", ".f08")
_LONGEST = 4000


class BuildError(SolverError):
    """Sources cannot be compiled; the message says why, with what the compiler wrote."""


@dataclass(frozen=True, slots=True)
class Built:
    """A library, the call that made it, and what the compiler wrote."""

    library: Path
    call: tuple[str, ...]
    printed: str


def build_umat(
    sources: Sequence[Path],
    output: Path,
    *,
    function: str = "umat_",
    compiler: str = "gfortran",
    flags: Sequence[str] = (),
) -> Built:
    """Compile and link a user routine.

    Parameters
    ----------
    sources
        Fortran files, fixed form (.f, .for) or free form (.f90); modules before those that use them.
    output
        The library that is written.
    function
        Symbol that it must have.
    compiler, flags
        Name or path of gfortran, and further flags, which come last.

    Raises
    ------
    BuildError
        The compiler is missing, refuses the sources, or the library lacks the routine.
    """
    if not sources:
        raise BuildError("no source is given; name at least one Fortran file")
    for source in sources:
        if not source.is_file():
            raise BuildError(f"{source} is not a file")
        if source.suffix.lower() not in _SUFFIXES:
            raise BuildError(f"{source}: the name of a Fortran source ends in one of {', '.join(_SUFFIXES)}")
    program = shutil.which(compiler)
    if program is None:
        raise BuildError(
            f"the compiler {compiler} was not found; install gfortran (Debian: apt-get install gfortran), or compile "
            "the routine elsewhere to a shared library and name that in the problem"
        )
    wraps = [f"-Wl,--wrap=_gfortran_{one}" for one in _WRAPPED] if sys.platform == "linux" else []
    complete = ["-Wl,-z,defs"] if sys.platform == "linux" else []
    output.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="geoswarm-umat-") as folder:
        for name in _INCLUDE_NAMES:
            shutil.copyfile(_INCLUDE, Path(folder) / name)
        made = Path(folder) / "made.so"
        call = [
            program,
            *("-shared", *_FLAGS, *flags),
            *("-I", folder, "-J", folder),
            str(_UTILITIES),
            *map(str, sources),
            *("-o", str(made), *wraps, *complete),
        ]
        done = subprocess.run(call, capture_output=True, text=True, errors="replace", check=False)
        printed = (done.stdout + done.stderr).strip()
        if done.returncode != 0:
            raise BuildError(f"{compiler} failed:\n{printed[-_LONGEST:]}{_hint(printed)}")
        if not hasattr(loaded(made), function):
            raise BuildError(
                f"{', '.join(one.name for one in sources)}: there is no {function}; a routine SUBROUTINE UMAT becomes "
                "umat_; --function names another"
            )
        shutil.copyfile(made, output)
    return Built(output, tuple(call), printed)


def _hint(printed: str) -> str:
    if "undefined reference" in printed:
        return (
            "\nThe routine calls what is neither in its sources nor among the utilities supplied (SINV, SPRINC, "
            "SPRIND, ROTSIG, XIT, STDB_ABQERR); name the sources that have it."
        )
    if "Unclassifiable statement" in printed or "truncated" in printed:
        return "\nLines of fixed form end in column 72; --flag=-ffixed-line-length-none takes longer ones."
    return ""
