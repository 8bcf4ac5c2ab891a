"""Registered models that the service hands out: fetched by hash, if a list says so that was signed with a known secret.

Each version has a folder of its own, named after its hash, that is there only once all of its files were compared with
the list. What the machine has itself comes first.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import secrets
import shutil
import time
from collections.abc import Callable
from pathlib import Path

from geoswarm.agent.errors import AgentError, KeyRefusedError
from geoswarm.agent.server import Server
from geoswarm.solver.errors import SignedListError
from geoswarm.solver.registered.folders import VARIABLE, version_of
from geoswarm.solver.registered.signed import ListedFile, ListedModel, SignedList

__all__ = ["FetchedModels"]

log = logging.getLogger(__name__)

DRAFT = "draft-"
BROKEN = "broken-"
LEFT_SECONDS = 86_400.0  # a draft that old belongs to no living agent


class FetchedModels:
    """Models of the service on this machine.

    Parameters
    ----------
    folder
        Where they are kept; several agents may share it.
    secret
        With which the list must be signed.
    give_up
        Whether the agent ends: then nothing more is fetched.
    """

    def __init__(self, folder: Path, server: Server, secret: bytes, give_up: Callable[[], bool]) -> None:
        self._folder, self._server, self._secret, self._give_up = folder, server, secret, give_up
        self._own = os.environ.get(VARIABLE, "")
        self._seen = folder / f"seen-{hashlib.sha256(secret).hexdigest()[:16]}.json"  # the newest list so far
        self._told = ""

    def update(self) -> str:
        """Fetch what is listed and not here; return what ``GEOSWARM_MODELS`` is now, with the machine's own first.

        What cannot be fetched is logged, and tried again the next time.

        Raises
        ------
        KeyRefusedError
        """
        faults: list[str] = []
        models: dict[str, ListedModel] = {}
        try:
            self._tidy()
            models = dict(self._listed().models)
        except KeyRefusedError:
            raise
        except (AgentError, SignedListError, OSError) as error:
            faults.append(str(error))
            with contextlib.suppress(OSError, SignedListError):  # what was listed before is still genuine
                models = dict(self._known().models)
        here = []
        for name, model in models.items():
            if self._give_up():
                break
            if self._has_another(name, model):
                faults.append(f"{name}: this machine has another version of its own, which comes first; remove one")
            try:
                here.append(self._have(name, model))
            except KeyRefusedError:
                raise
            except (AgentError, SignedListError, OSError, ValueError) as error:
                faults.append(f"{name}: {error}")
        told = "; ".join(faults)
        if told and told != self._told:
            log.warning("models of the service cannot be fetched: %s", told)
        self._told = told
        return os.pathsep.join([*([self._own] if self._own else []), *map(str, here)])

    def _listed(self) -> SignedList:
        """The list that the service has now."""
        found = SignedList.read(self._server.signed_models(), self._secret)
        try:
            known: SignedList | None = self._known()
        except (OSError, SignedListError):
            known = None
        if known is not None and found.signed_at < known.signed_at:
            raise SignedListError(
                "the service's list of models is older than one that it has sent before; sign it again if that is meant"
            )
        if known is None or found.document() != known.document():
            draft = self._seen.with_name(f"{DRAFT}{secrets.token_hex(8)}")
            draft.write_bytes(found.document())
            draft.replace(self._seen)
        return found

    def _known(self) -> SignedList:
        return SignedList.read(self._seen.read_bytes(), self._secret)

    def _has_another(self, name: str, model: ListedModel) -> bool:
        own = [Path(text) / name for text in self._own.split(os.pathsep) if text]
        first = next((folder for folder in own if (folder / "model.yaml").is_file()), None)
        return first is not None and not _is_sound(first, model)

    def _have(self, name: str, model: ListedModel) -> Path:
        """Return the folder around a model, fetched if it was not here or not sound."""
        place = self._folder / model.version
        if place.is_dir():
            if _is_sound(place / name, model):
                return place
            log.warning("model %s: %s has changed on this machine, it is fetched again", name, place)
            place.replace(self._folder / f"{BROKEN}{secrets.token_hex(8)}")
        draft = self._folder / f"{DRAFT}{secrets.token_hex(8)}"
        try:
            for file in model.files:
                if self._give_up():
                    raise SignedListError("the agent ends")
                self._fetch(draft / name, file)
            if version_of(draft / name) != model.version:
                raise SignedListError("its files are those of the list, but its version is another one; sign it again")
            with contextlib.suppress(OSError):  # another agent of this machine was faster
                draft.rename(place)
        finally:
            shutil.rmtree(draft, ignore_errors=True)
        if not _is_sound(place / name, model):
            raise SignedListError(f"{place} cannot be used: something else is there; remove it")
        log.info("model %s was fetched: version %s", name, model.version[:12])
        return place

    def _fetch(self, folder: Path, file: ListedFile) -> None:
        """Fetch one file, into a place that the list has been found to keep below the folder."""
        path = folder.joinpath(*file.path.split("/"))
        path.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
        digest, size = hashlib.sha256(), 0
        with path.open("xb") as written:
            for piece in self._server.model_file(file.sha256):
                size += len(piece)
                if size > file.size:
                    break
                digest.update(piece)
                written.write(piece)
        if size != file.size or digest.hexdigest() != file.sha256:
            raise SignedListError(f"{file.path} is not what was signed: the service sent something else")
        if file.executable:
            path.chmod(0o700)

    def _tidy(self) -> None:
        """Make the folder, and remove what killed agents have left in it."""
        self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
        for path in self._folder.iterdir():
            with contextlib.suppress(OSError):
                if path.name.startswith((DRAFT, BROKEN)) and time.time() - path.stat().st_mtime > LEFT_SECONDS:
                    shutil.rmtree(path) if path.is_dir() else path.unlink()


def _is_sound(folder: Path, model: ListedModel) -> bool:
    try:
        return version_of(folder) == model.version
    except (OSError, ValueError):
        return False
