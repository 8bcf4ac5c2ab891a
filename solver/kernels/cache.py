"""Where compiled kernels are kept, and which have been compiled there before.

Each source has a folder of its own in it, with a fingerprint of that source and of the kernels that it imports. Numba
alone renews a cached kernel only when the kernel's own file changes, not when a kernel that it calls does; a stale
caller linked with a new callee gives wrong numbers or crashes. Soil laws are called by address and imported by no
kernel: a change in one compiles that law only. In order of preference: ``NUMBA_CACHE_DIR``, the package itself, the
user's cache folder, a temporary folder.
"""

from __future__ import annotations

import atexit
import contextlib
import hashlib
import logging
import os
import re
import shutil
import stat
import sys
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from geoswarm.solver.system.file_locks import try_lock

__all__ = ["SOLVER", "alone", "cache_folder", "fingerprint", "part_of", "settle"]

log = logging.getLogger(__name__)

VARIABLE = "NUMBA_CACHE_DIR"
SOLVER = Path(__file__).parents[1]
LOOK_SECONDS = 0.1
_LOCK = Path("compiling.lock")

_KERNELS = ("constitutive", "element_test", "fem", "laws")
_IMPORT = re.compile(rf"^from geoswarm\.solver\.((?:{'|'.join(_KERNELS)}|kernels\.jit)[\w.]*) import", re.MULTILINE)


def fingerprint(source: Path, solver: Path = SOLVER) -> str:
    """Return 16 letters that are others for any change in a source or in kernels that it imports, however far down."""
    found: dict[Path, bytes] = {}
    wanted = [source]
    while wanted:
        path = wanted.pop()
        if path not in found and path.is_file():
            found[path] = path.read_bytes()
            names = _IMPORT.findall(found[path].decode())
            wanted += [(solver / name.replace(".", "/")).with_suffix(".py") for name in names]
    digest = hashlib.sha256()
    for path in sorted(found):
        digest.update(path.relative_to(solver).as_posix().encode() if path.is_relative_to(solver) else b"")
        digest.update(found[path])
    return digest.hexdigest()[:16]


@cache
def part_of(folder: Path, source: Path) -> Path:
    """Return the folder of the kernels of one source: another one whenever they have to be compiled anew."""
    return folder / f"{source.stem}-{fingerprint(source)}"


def cache_folder(solver: Path = SOLVER) -> Path:
    """Folder of the compiled kernels in the package at ``solver``."""
    return solver / "__pycache__" / "kernels-by-source"


@cache
def settle() -> Path | None:
    """Return the folder in which this process and those that it starts keep compiled kernels; None: there is none.

    The first process that needs a temporary folder logs it in one line.
    """
    given, own = os.environ.get(VARIABLE), cache_folder()
    wanted = [_below(Path(given), own.name) if given else own]
    with contextlib.suppress(RuntimeError):  # no home is known
        base = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        wanted.append(Path(base) / "geoswarm" / own.name)
    for folder in wanted:
        if folder is not wanted[0]:
            _take_over(own, folder)
        if _writable(folder):
            break
    else:
        found = _temporary(own.name)
        because = f"because neither {' nor '.join(str(one) for one in wanted)} can be written"
        if found is None:
            log.warning("every process recompiles the kernels, %s; set %s", because, VARIABLE)
            return None
        folder = found
        log.warning("the compiled kernels are kept in %s only, %s; set %s", folder, because, VARIABLE)
    if folder is not wanted[0]:
        os.environ[VARIABLE] = str(folder)  # for the processes that this one starts
    return folder


def _below(folder: Path, name: str) -> Path:
    """Return the part of a named folder that is for our kernels, also where it is that part that was named."""
    return folder if folder.name == name else folder / name


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


def _temporary(name: str) -> Path | None:
    """Return a folder that this user alone can use: machine code is loaded from it."""
    try:
        parent = Path(tempfile.gettempdir()) / f"geoswarm-{os.getuid() if sys.platform != 'win32' else 'user'}"
        with contextlib.suppress(FileExistsError):
            parent.mkdir(mode=0o700)
        if not _private(parent):  # somebody else has made it
            parent = Path(tempfile.mkdtemp(prefix="geoswarm-"))
            atexit.register(shutil.rmtree, parent, ignore_errors=True)
    except OSError:
        return None
    folder = parent / name
    _take_over(cache_folder(), folder)
    return folder if _writable(folder) else None


def _private(folder: Path) -> bool:
    found = folder.lstat()
    if sys.platform == "win32":
        return stat.S_ISDIR(found.st_mode)
    return stat.S_ISDIR(found.st_mode) and found.st_uid == os.getuid() and not found.st_mode & 0o077


def _take_over(compiled: Path, folder: Path) -> None:
    """Begin a folder with what was compiled in the package: Numba reads no cache that it cannot write to."""
    if folder.exists() or not compiled.is_dir():
        return
    with contextlib.suppress(OSError):
        folder.parent.mkdir(parents=True, exist_ok=True)
        draft = Path(tempfile.mkdtemp(dir=folder.parent))  # the folder appears complete
        try:
            for source in compiled.rglob("*"):
                if source.is_file() and source.suffix != _LOCK.suffix:
                    target = draft / source.relative_to(compiled)
                    target.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copyfile(source, target)
            draft.rename(folder)
        finally:
            shutil.rmtree(draft, ignore_errors=True)


@contextmanager
def alone(folder: Path | None, unwanted: Callable[[], bool] = lambda: False) -> Iterator[bool]:
    """Be the only process that compiles into a folder while the body runs; others wait for it.

    Gives False when ``unwanted`` became true before it was this process's turn.
    """
    if folder is None:
        yield True
        return
    with (folder / _LOCK).open("w") as lock:  # without locks two may compile at once, and lose nothing but time
        while not unwanted():
            if try_lock(lock):
                yield True
                return
            time.sleep(LOOK_SECONDS)
        yield False
