"""Registered models that the service hands out to agents: those of a signed list, file by file, by their SHA-256."""

from __future__ import annotations

import threading
from pathlib import Path

from geoswarm.solver.errors import SignedListError, UnknownForwardModelError
from geoswarm.solver.external.runs.fingerprints import SAMPLED, fingerprint
from geoswarm.solver.registered.folders import find_folder
from geoswarm.solver.registered.signed import MOST_BYTES, ListedFile, SignedList
from geoswarm.workers.errors import ModelsUnavailableError, NotHandedOutError

__all__ = ["HandedOut", "read_list"]

SIGN_AGAIN = "sign the list again ('geoswarm models sign')"


def read_list(file: Path) -> SignedList:
    """Return the list in a file; whether it is genuine is judged by the agents, which know the secret.

    Raises
    ------
    ModelsUnavailableError
        It cannot be read.
    """
    try:
        with file.open("rb") as opened:
            return SignedList.read(opened.read(MOST_BYTES + 1), None)
    except OSError as error:
        raise ModelsUnavailableError(f"the list of models cannot be read: {error.strerror or error}") from None
    except SignedListError as error:
        raise ModelsUnavailableError(f"the list of models cannot be read: {error}") from None


class HandedOut:
    """The models of one list; safe to use from several threads.

    Parameters
    ----------
    file
        The list, which may be replaced at any time; None: this service hands out nothing.
    """

    def __init__(self, file: Path | None) -> None:
        self._file = file
        self._lock = threading.Lock()
        self._stamp: tuple[int, int, int] | None = None
        self._list: SignedList | None = None
        self._files: dict[str, tuple[str, ListedFile]] = {}

    def document(self) -> bytes:
        """Return the list as agents get it.

        Raises
        ------
        NotHandedOutError
            This service hands out nothing.
        ModelsUnavailableError
        """
        with self._lock:
            return self._current().document()

    def file(self, sha256: str) -> Path:
        """Return where a file of the list lies.

        Raises
        ------
        NotHandedOutError
            No model of the list has such a file.
        ModelsUnavailableError
            It is not here, or no longer what it was when the list was signed.
        """
        with self._lock:
            self._current()
            found = self._files.get(sha256)
        if found is None:
            raise NotHandedOutError(f"no file {sha256} belongs to the list of models")
        model, listed = found
        try:
            path = find_folder(model) / listed.path
            same = path.stat().st_size == listed.size
            if same and listed.size <= SAMPLED:  # the agent looks at the whole of larger ones as well
                same = fingerprint(path) == sha256
        except (OSError, UnknownForwardModelError) as error:
            raise ModelsUnavailableError(f"model {model!r}: {listed.path} cannot be read: {error}") from None
        if not same:
            raise ModelsUnavailableError(f"model {model!r}: {listed.path} has changed since; {SIGN_AGAIN}")
        return path

    def _current(self) -> SignedList:
        """The list as it is now, read again when its file is another one; called with the lock held."""
        if self._file is None:
            raise NotHandedOutError(
                "this service hands out no models; its operator names a signed list with GEOSWARM_SIGNED_MODELS"
            )
        try:
            found = self._file.stat()
        except OSError as error:
            raise ModelsUnavailableError(f"the list of models cannot be read: {error.strerror or error}") from None
        stamp = (found.st_ino, found.st_size, found.st_mtime_ns)
        if self._list is None or stamp != self._stamp:
            self._list = read_list(self._file)
            self._files = {
                file.sha256: (name, file) for name, model in self._list.models.items() for file in model.files
            }
            self._stamp = stamp
        return self._list
