"""Forward model that the operator of this machine has registered: users name it, and give numbers and settings only.

::

    forward_model: {kind: registered, model: footing, settings: {increments: 40}}
"""

from __future__ import annotations

import contextlib
import os
import re
import tempfile
from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field
from pydantic.json_schema import SkipJsonSchema

from geoswarm.solver.errors import Issue, ProblemError, SolverError, UnknownForwardModelError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.forward.registry import parse_spec
from geoswarm.solver.registered.declaration import Declared, read_declaration
from geoswarm.solver.registered.folders import NAME, find_folder, version_of
from geoswarm.solver.registered.settings import Given, SettingName, chosen, numbers_of, setting_issues

if TYPE_CHECKING:
    from geoswarm.solver.registered.model import RegisteredModel

__all__ = ["RegisteredSpec", "without_paths"]


_BEGINS = r"(?:(?<![\w./~-])|(?<=\s-[A-Za-z]))"  # no part of a relative path, of an address or of a unit
_SIGNS = r"\s'\"`<>|:;,()\[\]{}="
_ENDS = rf"(?=[/{_SIGNS}]|\.?(?:\s|$))"
_ABSOLUTE = re.compile(rf"{_BEGINS}/(?P<first>[^/{_SIGNS}]+)(?:/[^/{_SIGNS}]*)*")


class RegisteredSpec(ForwardModelSpec):
    """A model that the operator of the service has registered."""

    kind: Literal["registered"] = "registered"
    model: Annotated[str, Field(pattern=NAME)] = Field(description="Name of the model.")
    settings: dict[SettingName, Given] = Field({}, max_length=100, description="Settings that the model declares.")
    # Only in canonical problems, so that results can be read where the model is not; users do not write it.
    version: SkipJsonSchema[Annotated[str, Field(pattern=r"^[0-9a-f]{64}$")] | None] = Field(
        None, description="SHA-256 of the model's files"
    )
    declared: SkipJsonSchema[Declared | None] = Field(None, description="its parameters and series")

    @property
    def runs_outside(self) -> bool:
        """They are; the operator has accepted that."""
        return True

    @property
    def kernels(self) -> frozenset[str]:
        """Those of the section that the operator has declared; none where the model is not here or is broken."""
        try:
            return parse_spec(read_declaration(find_folder(self.model)).forward_model).kernels
        except (SolverError, OSError, ValueError):  # building it reports what is wrong
            return frozenset()

    def with_files(self, folder: Path | None, path: str) -> RegisteredSpec:
        """With version, parameters and series of the model as it is here; as it was where it is not the same."""
        from geoswarm.solver.registered.model import declared_at

        del folder
        try:
            place = find_folder(self.model)
            version = version_of(place)
        except (UnknownForwardModelError, OSError, ValueError) as error:
            if self.declared is not None:
                return self
            raise self._broken(path, error) from None
        if self.declared is not None and self.version not in (None, version):
            return self
        try:
            declaration, declared = read_declaration(place), declared_at(place, version)
        except (ProblemError, OSError, ValueError) as error:
            raise self._broken(path, error) from None
        issues = setting_issues(declaration.settings, self.settings, f"{path}.settings")
        if self.version not in (None, version):
            issues.append(Issue(f"{path}.version", self._changed(version)))
        if issues:
            raise ProblemError(issues)
        return self.model_copy(update={"version": version, "declared": declared})

    def unavailable(self) -> str | None:
        """Why it cannot be run on this machine: there is no such model, or another version of it."""
        try:
            version = version_of(find_folder(self.model))
        except (UnknownForwardModelError, OSError, ValueError) as error:
            return self.shown(str(error))
        return None if self.version in (None, version) else self._changed(version)

    def shown(self, text: str) -> str:
        """A message or log without the folders of this machine, and without the address of a server behind it."""
        if "/" not in text:
            return text
        folders: list[Path] = []
        with contextlib.suppress(SolverError, OSError):
            folders.append(find_folder(self.model))
            section = read_declaration(folders[0]).forward_model
            address = section.get("url")
            if isinstance(address, str):
                text = text.replace(address.strip().rstrip("/"), f"the server of {self.model}")
        return without_paths(text, self.model, folders)

    def _broken(self, path: str, error: Exception) -> ProblemError:
        unknown = isinstance(error, UnknownForwardModelError)
        message = str(error) if unknown else f"model {self.model} is broken: {error}"
        return ProblemError([Issue(f"{path}.model", self.shown(message))])

    def _changed(self, version: str) -> str:
        return (
            f"model {self.model} has version {version[:12]} on this machine, the problem wants "
            f"{(self.version or '')[:12]}: its files have changed; restore them, or submit the problem again"
        )

    def program(self) -> tuple[ForwardModel, dict[str, float]]:
        """Build what runs, and the settings that are numbers.

        Raises
        ------
        ProblemError
            The model is not here, has changed, or its own files are wrong.
        """
        from geoswarm.solver.registered.model import program_of

        self.require_available("forward_model.model")
        place = find_folder(self.model)
        declaration = read_declaration(place)
        if issues := setting_issues(declaration.settings, self.settings, "forward_model.settings"):
            raise ProblemError(issues)
        values = chosen(declaration.settings, self.settings)
        model = program_of(place, declaration, self.settings, private=True)
        self.require_available("forward_model.model")  # changed in this moment
        return model, numbers_of(declaration.settings, values)

    def build(self) -> RegisteredModel:
        """Build the forward model.

        Raises
        ------
        ProblemError
            The section was not completed by :meth:`with_files`.
        """
        from geoswarm.solver.registered.model import RegisteredModel

        if self.declared is None:
            raise ProblemError([Issue("forward_model.model", f"model {self.model} is not known here")])
        return RegisteredModel(self, self.declared)


def without_paths(text: str, model: str, folders: Iterable[Path] = ()) -> str:
    """Return a text in which paths are relative: to the model by its name, else the name of a file alone.

    Parameters
    ----------
    model, folders
        Name of the model, and folders that stand for it.

    Examples
    --------
    >>> without_paths("/srv/m/deck.inp, /usr/bin/env: 3 kN/m", "footing", [Path("/srv/m")])
    'footing/deck.inp, env: 3 kN/m'
    """
    text = text.replace("file://", "")
    for folder in sorted({str(one) for one in folders}, key=len, reverse=True):
        text = re.sub(_BEGINS + re.escape(folder) + _ENDS, lambda _: model, text)
    temporary = tempfile.gettempdir().rstrip(os.sep)
    text = re.sub(_BEGINS + re.escape(temporary) + r"/(?=[^/\s])", "", text)
    return _ABSOLUTE.sub(_last, text)


def _last(found: re.Match[str]) -> str:
    """The last part of a path, where there is such a folder at all."""
    if not os.path.lexists(f"/{found['first']}"):
        return found[0]
    return found[0].rstrip("/").rpartition("/")[2]
