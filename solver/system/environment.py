"""What forward models see of the environment: no password, no key, nothing that one deployment alone has."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fnmatch import fnmatchcase

__all__ = ["ALLOWED", "ONE_THREAD", "clean_environment"]

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "NUMBA_NUM_THREADS"), "1")
"""Environment of a process that evaluates: one numerical thread, as there is one worker a core."""

ALLOWED = (
    *("PATH", "HOME", "USER", "LOGNAME", "SHELL", "HOSTNAME", "TMPDIR", "TEMP", "TMP", "TERM", "DISPLAY"),
    *("LANG", "LANGUAGE", "LC_*", "TZ", "TZDIR", "XDG_*"),
    *("LD_LIBRARY_PATH", "VIRTUAL_ENV", "CONDA_PREFIX", "PYTHON*", "NUMBA_*", "OMP_*", "OPENBLAS_*", "MKL_*", "CUDA_*"),
    *("SSL_CERT_FILE", "SSL_CERT_DIR", "GEOSWARM_MODELS"),
    # without these no program starts on Windows, or finds its libraries and its licence
    *("SYSTEMROOT", "SYSTEMDRIVE", "WINDIR", "COMSPEC", "PATHEXT", "USERNAME", "USERPROFILE", "COMPUTERNAME"),
    *("APPDATA", "LOCALAPPDATA", "PROGRAMDATA", "PROGRAMFILES*", "COMMONPROGRAMFILES*", "NUMBER_OF_PROCESSORS"),
    *("PROCESSOR_*", "OS"),
)
"""Names, with ``*`` for any letters."""


def clean_environment(environment: Mapping[str, str], passed: Sequence[str] = ()) -> dict[str, str]:
    """Return the variables of :data:`ALLOWED` and those that the operator passes on, names with ``*`` or without.

    >>> clean_environment({"PATH": "/bin", "GEOSWARM_API_KEY": "secret", "LM_HOST": "a"}, ["LM_*"])
    {'PATH': '/bin', 'LM_HOST': 'a'}
    """
    patterns = (*ALLOWED, *passed)
    return {name: value for name, value in environment.items() if any(fnmatchcase(name, p) for p in patterns)}
