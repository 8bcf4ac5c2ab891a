"""The environment of processes that calculate, and what forward models see of it: no password, no key."""

from __future__ import annotations

import os
import platform
from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase
from functools import cache
from pathlib import Path

from geoswarm.solver.errors import SolverError

__all__ = ["ALLOWED", "SWITCH", "clean_environment", "numerics", "same_bits"]

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""One numerical thread, as there is one worker a core."""

SWITCH = "GEOSWARM_SAME_BITS"
"""``off``: linear algebra and NumPy use all instructions of the processor."""

WIDER = "X86_V4 AVX512_ICL AVX512_SPR"
WIDER_BEFORE_2_4 = "AVX512F AVX512CD AVX512_SKX AVX512_CLX AVX512_CNL AVX512_ICL"
"""NumPy's names for what x86-64-v3 does not have; it warns of a name that it does not know."""

ALLOWED = (
    *("PATH", "HOME", "USER", "LOGNAME", "SHELL", "HOSTNAME", "TMPDIR", "TEMP", "TMP", "TERM", "DISPLAY"),
    *("LANG", "LANGUAGE", "LC_*", "TZ", "TZDIR", "XDG_*"),
    *(
        "LD_LIBRARY_PATH",
        "VIRTUAL_ENV",
        "CONDA_PREFIX",
        "PYTHON*",
        "NPY_*",
        "NUMBA_*",
        "OMP_*",
        "OPENBLAS_*",
        "MKL_*",
        "CUDA_*",
    ),
    *("SSL_CERT_FILE", "SSL_CERT_DIR", "GEOSWARM_MODELS"),
    # without these no program starts on Windows, or finds its libraries and its licence
    *("SYSTEMROOT", "SYSTEMDRIVE", "WINDIR", "COMSPEC", "PATHEXT", "USERNAME", "USERPROFILE", "COMPUTERNAME"),
    *("APPDATA", "LOCALAPPDATA", "PROGRAMDATA", "PROGRAMFILES*", "COMMONPROGRAMFILES*", "NUMBER_OF_PROCESSORS"),
    *("PROCESSOR_*", "OS"),
)
"""Names, with ``*`` for any letters."""


def numerics() -> dict[str, str]:
    """Return the environment of a process that calculates: one numerical thread, and :func:`same_bits`."""
    return ONE_THREAD | same_bits()


def same_bits() -> dict[str, str]:
    """Return variables with which NumPy and OpenBLAS give the same bits on every x86-64-v3 processor.

    They take effect in a process that has not loaded NumPy yet. Variables that are set already are not in the answer.
    On other processors, and where :data:`SWITCH` is ``off``, it is empty.

    Raises
    ------
    SolverError
        The switch has another value than ``on`` and ``off``.
    """
    switch = os.environ.get(SWITCH, "on")
    if switch not in ("on", "off"):
        raise SolverError(f"{SWITCH} is {switch!r}; it must be on or off")
    pinned = _limits(_flags()) if switch == "on" else {}
    return {name: value for name, value in pinned.items() if name not in os.environ}


def _limits(flags: frozenset[str]) -> dict[str, str]:
    """Limit both libraries to x86-64-v3 if the processor has more; a program ends with SIGILL if it has less."""
    if not {"avx2", "bmi2", "fma"} <= flags:
        return {}
    limits = {"OPENBLAS_CORETYPE": "Haswell"}
    if "avx512f" in flags:
        from importlib.metadata import version  # takes a tenth of the start of a short command

        numpy = tuple(int(part) for part in version("numpy").split(".")[:2])
        limits["NPY_DISABLE_CPU_FEATURES"] = WIDER if numpy >= (2, 4) else WIDER_BEFORE_2_4
    return limits


@cache
def _flags() -> frozenset[str]:
    """Return Linux's names of what the processor can do; none on other systems and architectures."""
    cpuinfo = Path("/proc/cpuinfo")
    if platform.machine() != "x86_64" or not cpuinfo.exists():
        return frozenset()
    with cpuinfo.open(encoding="utf-8") as text:  # one line for each core
        return frozenset(next((line.partition(":")[2] for line in text if line.startswith("flags")), "").split())


def clean_environment(environment: Mapping[str, str], passed: Sequence[str] = ()) -> dict[str, str]:
    """Return the variables of :data:`ALLOWED` and those that the operator passes on, names with ``*`` or without.

    >>> clean_environment({"PATH": "/bin", "GEOSWARM_API_KEY": "secret", "LM_HOST": "a"}, ["LM_*"])
    {'PATH': '/bin', 'LM_HOST': 'a'}
    """
    patterns = (*ALLOWED, *passed)
    return {name: value for name, value in environment.items() if any(fnmatchcase(name, p) for p in patterns)}
