"""The signed list of registered models that a service hands out: which files each consists of, and that it is genuine.

The list is signed by the operator of the models, with a secret that agents know and the service does not: whoever has
taken over the service, or stands between it and the agents, cannot make them run anything else.
"""

from __future__ import annotations

import hashlib
import hmac
import json
import re
import secrets
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, field_validator

from geoswarm.solver.errors import SignedListError
from geoswarm.solver.external.runs.fingerprints import MOST_FILES, files_below
from geoswarm.solver.registered.folders import NAME, version_of

__all__ = ["MOST_BYTES", "ListedFile", "ListedModel", "SignedList", "listed", "new_secret", "read_secret"]

MOST_BYTES = 32 * 2**20
"""Largest list."""

SHORTEST_SECRET, LONGEST_SECRET = 32, 4096
PURPOSE = b"geoswarm signed models 1\n"  # what is signed for something else is no list
LONGEST_PATH, LONGEST_NAME = 400, 200
UNSAFE = re.compile(r'[\x00-\x1f\x7f\\:*?"<>|]')
DEVICES = re.compile(r"(con|prn|aux|nul|conin\$|conout\$|com[0-9¹²³]|lpt[0-9¹²³])(\..*)?", re.IGNORECASE)
ACCEPTED = 'a relative path of names with / between them, none of them . or .., none with \\ : * ? " < > |'

Digest = Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")]


class _Part(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid")


class ListedFile(_Part):
    """One file of a model: its place below the model's folder, and its SHA-256."""

    path: str = Field(max_length=LONGEST_PATH)
    size: int = Field(ge=0, lt=2**40)
    sha256: Digest
    executable: bool = False

    @field_validator("path")
    @classmethod
    def _stays_below(cls, path: str) -> str:
        """Every system takes it for a file below the folder of the model, and for the same one."""
        for name in path.split("/"):
            wrong = name in ("", ".", "..") or UNSAFE.search(name) or name[-1] in ". " or len(name) > LONGEST_NAME
            if wrong or DEVICES.fullmatch(name):
                raise ValueError(
                    f"{path[:LONGEST_NAME]!r} is not a path that every system accepts; accepted: {ACCEPTED}"
                )
        return path


class ListedModel(_Part):
    """A registered model; ``version`` is that of :func:`geoswarm.solver.registered.folders.version_of`."""

    version: Digest
    files: tuple[ListedFile, ...] = Field(min_length=1, max_length=MOST_FILES)

    @field_validator("files")
    @classmethod
    def _are_apart(cls, files: tuple[ListedFile, ...]) -> tuple[ListedFile, ...]:
        """No two are one file where letters count the same, large or small, and none is a folder of another."""
        seen = {file.path.casefold() for file in files}
        if len(seen) < len(files):
            raise ValueError("two files differ at most in large and small letters; on Windows that is one file")
        for file in files:
            parts = file.path.casefold().split("/")
            if any("/".join(parts[:count]) in seen for count in range(1, len(parts))):
                raise ValueError(f"{file.path!r} lies below a file")
        if "model.yaml" not in {file.path for file in files}:
            raise ValueError("there is no model.yaml among the files")
        return files


class _Content(_Part):
    signed_at: int = Field(ge=0, lt=2**53)
    models: dict[Annotated[str, Field(pattern=NAME)], ListedModel] = Field(max_length=1000)


class _Document(_Part):
    content: str
    signature: Digest


class SignedList:
    """A list as it is stored and sent.

    Parameters
    ----------
    signed_at
        When it was signed, by the signer's clock [s since 1970]: a later list replaces an earlier one.
    """

    def __init__(self, content: str, signature: str, signed_at: int, models: Mapping[str, ListedModel]) -> None:
        self.signed_at = signed_at
        self.models = models
        self._content, self._signature = content, signature

    @classmethod
    def signed(cls, models: Mapping[str, ListedModel], signed_at: int, secret: bytes) -> SignedList:
        """Sign a list."""
        found = _Content(signed_at=signed_at, models=dict(models))
        content = json.dumps(found.model_dump(mode="json"), sort_keys=True)
        return cls(content, _signature(content, secret), found.signed_at, found.models)

    @classmethod
    def read(cls, document: bytes, secret: bytes | None) -> SignedList:
        """Read a list that was stored or sent.

        Parameters
        ----------
        secret
            With which it was signed; None: the reader only passes it on, without knowing whether it is genuine.

        Raises
        ------
        SignedListError
            It cannot be read, or was signed with another secret, or changed since.
        """
        if len(document) > MOST_BYTES:
            raise SignedListError(f"it has {len(document)} bytes; at most {MOST_BYTES} are accepted")
        try:
            outer = _Document.model_validate_json(document)
            if secret is not None and not hmac.compare_digest(outer.signature, _signature(outer.content, secret)):
                raise SignedListError(
                    "its signature is not that of this secret: it was signed with another one, or changed since"
                )
            inner = _Content.model_validate_json(outer.content)
        except ValidationError as error:
            raise SignedListError(f"it is not a list from 'geoswarm models sign': {_first(error)}") from None
        return cls(outer.content, outer.signature, inner.signed_at, inner.models)

    def document(self) -> bytes:
        """Return it as it is stored and sent."""
        return json.dumps({"content": self._content, "signature": self._signature}).encode() + b"\n"


def listed(folder: Path) -> ListedModel:
    """Return what the list says of the model in a folder.

    Raises
    ------
    SignedListError
        A file has a name that not every system accepts.
    OSError, ValueError
        A file cannot be read, or there are too many.
    """
    files: list[dict[str, Any]] = []
    for path in files_below(folder):
        with path.open("rb") as file:
            digest = hashlib.file_digest(file, "sha256").hexdigest()
        found = path.stat()
        place = path.relative_to(folder).as_posix()
        runs = bool(found.st_mode & 0o100)
        files.append({"path": place, "size": found.st_size, "sha256": digest, "executable": runs})
    try:
        return ListedModel.model_validate({"version": version_of(folder), "files": files})
    except ValidationError as error:
        raise SignedListError(f"model {folder.name!r} cannot be handed out: {_first(error)}") from None


def new_secret() -> str:
    """Return a new secret, of 256 random bits."""
    return secrets.token_hex(32)


def read_secret(file: Path) -> bytes:
    """Return the secret in a file.

    Raises
    ------
    OSError
        It cannot be read.
    SignedListError
        It holds none.
    """
    with file.open("rb") as opened:
        secret = opened.read(LONGEST_SECRET + 1).strip()
    if not SHORTEST_SECRET <= len(secret) <= LONGEST_SECRET or len(secret.split()) != 1 or not secret.isascii():
        raise SignedListError(
            f"a secret is one word of {SHORTEST_SECRET} to {LONGEST_SECRET} ASCII characters;"
            " 'geoswarm models sign' makes one where there is none"
        )
    return secret


def _signature(content: str, secret: bytes) -> str:
    return hmac.digest(secret, PURPOSE + content.encode(), "sha256").hex()


def _first(error: ValidationError) -> str:
    faults: Sequence[Any] = error.errors(include_url=False, include_input=False)
    place = ".".join(str(part) for part in faults[0]["loc"])
    return f"{place}: {faults[0]['msg']}".removeprefix(": ")[:500]
