"""``model.yaml``: what the operator declares of a registered model.

::

    title: Footing on soft ground
    forward_model: {kind: command, run: [ccx, -i, footing], templates: {footing.inp: footing.inp.in}, series: {...}}
    parameters:
      E: {unit: kPa, lower: 100, upper: 1e6, typical: [1000, 50000], description: Stiffness of the ground.}
    settings:
      increments: {type: integer, default: 20, lower: 1, upper: 1000}
"""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field, ValidationError, model_validator

from geoswarm.solver.declared_parameter import DeclaredParameter
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.external.runs.fingerprints import FileStamp, settled
from geoswarm.solver.forward.base import SeriesInfo
from geoswarm.solver.forward.registry import kinds
from geoswarm.solver.problem.text.reading import read_problem_file
from geoswarm.solver.registered.settings import Setting, SettingName
from geoswarm.solver.section import Name

__all__ = ["FILE", "Declaration", "Declared", "DeclaredParameter", "DeclaredSeries", "read_declaration"]

FILE = "model.yaml"
SeriesName = Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_.]*$", max_length=200)]


class DeclaredSeries(BaseModel):
    """A series as users see it, in base units."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    description: str = Field("", max_length=300)
    x_unit: str = Field("", max_length=50)
    y_unit: str = Field("", max_length=50)

    def info(self, name: str) -> SeriesInfo:
        """As forward models tell it."""
        return SeriesInfo(name, self.description, "x", self.x_unit, name, self.y_unit, x_increasing=False)


class Declared(BaseModel):
    """What a problem keeps of the model that it names, so that its results can be read where the model is not."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    parameters: dict[Name, DeclaredParameter] = Field(max_length=100)
    series: dict[SeriesName, DeclaredSeries] = Field(max_length=1000)


class Declaration(BaseModel):
    """All of ``model.yaml``."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    title: str = Field("", max_length=100)
    description: str = Field("", max_length=2000)
    forward_model: dict[str, Any]
    parameters: dict[Name, DeclaredParameter] = Field(min_length=1, max_length=100)
    settings: dict[SettingName, Setting] = Field({}, max_length=100)

    @model_validator(mode="after")
    def _apart(self) -> Declaration:
        twice = self.parameters.keys() & self.settings.keys()
        if twice:
            raise ValueError(f"{min(twice)} is a parameter and a setting; a name can only be one of the two")
        kind = self.forward_model.get("kind")
        accepted = [one for one in kinds() if one != "registered"]
        if kind not in accepted:
            raise ValueError(f"forward_model.kind must be one of {', '.join(accepted)}, got {kind!r}")
        folder = Path(str(self.forward_model.get("folder") or ""))
        if folder.is_absolute() or ".." in folder.parts:
            raise ValueError(
                f"forward_model.folder must lie in the folder of the model, whose files are its version: "
                f"put the files there, or a link, not '{folder}'"
            )
        return self


def read_declaration(folder: Path) -> Declaration:
    """Read the ``model.yaml`` of a folder; one that has not changed is not read again.

    Raises
    ------
    ProblemError
        It is missing or wrong; each issue has its path in the file.
    """
    path = folder / FILE
    try:
        stamp = settled(path)
    except OSError:
        raise ProblemError([Issue(str(path), "is missing")]) from None
    return _read(path) if stamp is None else _kept(path, stamp)


@lru_cache(maxsize=256)
def _kept(path: Path, stamp: FileStamp) -> Declaration:
    del stamp
    return _read(path)


def _read(path: Path) -> Declaration:
    try:
        return Declaration.model_validate(read_problem_file(path))
    except ValidationError as error:
        raise ProblemError(
            [
                Issue(".".join(map(str, detail["loc"])), detail["msg"].removeprefix("Value error, "))
                for detail in error.errors(include_url=False)
            ]
        ) from None
