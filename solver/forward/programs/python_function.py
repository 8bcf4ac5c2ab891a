"""Forward model from a Python function in a file next to the problem file.

::

    forward_model:
      kind: python
      file: model.py
      function: settlement
      series: {settlement: {x_unit: day, y_unit: mm}}

The arguments of the function are the parameters; an argument ``x`` receives the observed points. The function gets x
and returns its values in the units that the series declares. The file is read to know the arguments, and executed only
when a calculation is made, never for a problem that came over the network.
"""

from __future__ import annotations

import keyword
from pathlib import Path, PurePosixPath
from typing import TYPE_CHECKING, Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, field_validator
from pydantic.json_schema import SkipJsonSchema

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.external.python.signature import Signature, SignatureError, signature_in
from geoswarm.solver.forward.base import ForwardModelSpec

if TYPE_CHECKING:
    from geoswarm.solver.forward.programs.python_model import PythonModel

__all__ = ["PythonSeries", "PythonSpec"]

_LARGEST = 4 * 2**20


class PythonSeries(BaseModel):
    """How the values of a series are to be read."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    x_unit: str = Field("dimensionless", description="unit in which the function gets x")
    y_unit: str = Field("dimensionless", description="unit in which the function returns values")
    description: str = Field("", max_length=200, description="what the series is")


class PythonSpec(ForwardModelSpec):
    """A Python function in a file next to the problem file."""

    depends_on_section: ClassVar[bool] = True
    programs: ClassVar[bool] = True

    kind: Literal["python"] = "python"
    file: str | None = Field(None, max_length=1000, description="the .py file, relative to the problem file; needed")
    function: str = Field(max_length=200, description="a function of it; its arguments are the parameters")
    series: dict[Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=100)], PythonSeries] = Field(
        min_length=1, max_length=1000, description="what the function returns, by name, and in which units"
    )
    quick_runs: bool = Field(
        False, description="whether its runs are so short that up to 200 may follow a short search, for intervals"
    )
    folder: str | None = Field(None, description="folder of the file; that of the problem file unless given")
    # Only in canonical problems; users do not write it.
    version: SkipJsonSchema[str | None] = Field(None, description="SHA-256 of the file")
    signature: SkipJsonSchema[Signature | None] = Field(None, description="arguments of the function")
    session: SkipJsonSchema[str | None] = Field(None, description="of a function of a Python session, without file")

    @property
    def quick(self) -> bool:
        """When the section says so."""
        return self.quick_runs

    @property
    def only_here(self) -> bool:
        """When the function lives in this process."""
        return self.session is not None

    @field_validator("file")
    @classmethod
    def _relative(cls, value: str | None) -> str | None:
        if value is None:
            return value
        path = PurePosixPath(value)
        outside = path.is_absolute() or ".." in path.parts or "\\" in value or ":" in value
        if outside or path.suffix != ".py" or not value.isprintable():
            raise ValueError(f"'{value[:100]}' is accepted as the relative name of a .py file only, such as model.py")
        return value

    def with_files(self, folder: Path | None, path: str) -> PythonSpec:
        """With the folder, the fingerprint and the arguments of the function."""
        if self.signature is not None and (self.session is not None or (self.folder and self.version)):
            return self
        if self.file is None:
            raise ProblemError([Issue(f"{path}.file", "is missing; name the .py file of the function")])
        if not self.function.isidentifier() or keyword.iskeyword(self.function):
            message = f"'{self.function[:100]}' is not the name of a function; write for example settlement"
            raise ProblemError([Issue(f"{path}.function", message)])
        if folder is None and not (self.folder and Path(self.folder).is_absolute()):
            raise ProblemError(
                [Issue(f"{path}.file", "kind: python names a file; it is accepted from problem files only")]
            )
        base = (Path(folder or ".") / (self.folder or "")).resolve()
        source = _contents(base / self.file, f"{path}.file")
        from geoswarm.solver.external.python.loading import fingerprint

        try:
            signature = signature_in(source, self.file, self.function)
        except SignatureError as error:
            raise ProblemError([Issue(f"{path}.function", str(error))]) from None
        given = {"folder": str(base), "version": fingerprint(source), "signature": signature}
        return self.model_copy(update=given)

    def build(self) -> PythonModel:
        """Build the forward model; nothing is executed.

        Raises
        ------
        ProblemError
            The unit of a series is unknown.
        """
        from geoswarm.solver.forward.programs.python_model import PythonModel

        return PythonModel(self)


def _contents(path: Path, place: str) -> bytes:
    if not path.is_file():
        what = "is not a file" if path.exists() else "is not there"
        raise ProblemError([Issue(place, f"{path} {what}; name a .py file beside the problem file")])
    try:
        with path.open("rb") as file:
            source = file.read(_LARGEST + 1)
    except OSError as error:
        raise ProblemError([Issue(place, f"{path} cannot be read: {error.strerror or error}")]) from None
    if len(source) > _LARGEST:
        raise ProblemError([Issue(place, f"{path} is larger than {_LARGEST} bytes, which no function needs")])
    return source
