"""Forward model that is a program of the user's: templates are filled, it is started, its output is read.

::

    forward_model:
      kind: command
      run: [ccx, -i, footing]
      templates: {footing.inp: footing.inp.in}
      series:
        settlement: {file: footing.dat, each: "displacements .* time +(?P<t>\\\\S+)", row: 5, x: t, y: "-column4"}

A program is started only by problem files on this machine, never by what came over the network.
"""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import ConfigDict, Field, field_validator, model_validator
from pydantic.json_schema import SkipJsonSchema

from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.external.errors import TemplateError
from geoswarm.solver.external.inputs.parameter_files import ParameterFileKind
from geoswarm.solver.external.inputs.texts import read_template_file
from geoswarm.solver.external.outputs.fields import RelativePath
from geoswarm.solver.external.outputs.series import SeriesReader
from geoswarm.solver.external.runs.fingerprints import fingerprint
from geoswarm.solver.external.runs.folder import Keep
from geoswarm.solver.external.runs.verdict import Fail, Success
from geoswarm.solver.forward.base import ForwardModelSpec, in_unit
from geoswarm.solver.section import Name

if TYPE_CHECKING:
    from geoswarm.solver.forward.programs.command_model import CommandModel

__all__ = ["CommandSpec"]

Argument = Annotated[str, Field(max_length=4096)]
Call = Annotated[tuple[Argument, ...], Field(min_length=1, max_length=200)]


class CommandSpec(ForwardModelSpec):
    """A program that reads files and writes files."""

    model_config = ConfigDict(
        extra="forbid", frozen=True, allow_inf_nan=False, populate_by_name=True, serialize_by_alias=True
    )

    programs: ClassVar[bool] = True

    kind: Literal["command"] = "command"
    run: Call = Field(
        description="Program and arguments, never a shell; {slot} and {python} are replaced, also in environment."
    )
    then: tuple[Call, ...] = Field(
        (), max_length=10, description="Other calls, tried in turn when the previous one failed."
    )
    files: tuple[RelativePath, ...] = Field(
        (),
        max_length=1000,
        description="Files and folders next to the problem file that are copied into the run folder.",
    )
    link: tuple[RelativePath, ...] = Field(
        (), max_length=1000, description="Files and folders that are linked there: large ones, which no run changes."
    )
    templates: dict[RelativePath, RelativePath] = Field(
        {},
        max_length=100,
        description="Template by the file that it becomes: {{E}}, {{nu:%.6e}}; PEST templates end in .tpl.",
    )
    write: dict[RelativePath, ParameterFileKind] = Field(
        {}, max_length=100, description="Files with all parameters: json, yaml or csv."
    )
    environment: dict[Name, Argument] = Field(
        {}, max_length=100, description="Environment variables, in addition to a minimal set."
    )
    pass_: tuple[Name, ...] = Field(
        (),
        alias="pass",
        max_length=100,
        description="Variables of your own environment that are passed on, never shown.",
    )
    slots: int | None = Field(
        None,
        ge=1,
        le=10_000,
        description="Runs at once on a machine, for licences; waiting for one does not count as run time.",
    )
    pool: Annotated[str, Field(pattern=r"^[A-Za-z0-9_-]{1,64}$")] | None = Field(
        None, description="Name of the slots; problems with one name share them. Otherwise each folder has its own."
    )
    seconds: float | None = Field(
        None,
        gt=0.0,
        description="Wall time after which a call is killed; also the limit for reading each output.",
        json_schema_extra=in_unit("s"),
    )
    licence_pause: float = Field(
        30.0,
        ge=0.01,
        le=3600.0,
        description="Pause after no_licence before the next call.",
        json_schema_extra=in_unit("s"),
    )
    licence_patience: float = Field(
        86_400.0, ge=0.0, description="How long an evaluation waits for a licence.", json_schema_extra=in_unit("s")
    )
    success: Success = Field(Success(), description="Signs of a successful run.")
    fail: Fail = Field(Fail(), description="Signs of why a run has failed.")
    series: dict[Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=100)], SeriesReader] = Field(
        min_length=1, max_length=1000, description="How each series is read."
    )
    units: dict[Annotated[str, Field(max_length=100)], Annotated[str, Field(max_length=50)]] = Field(
        {},
        max_length=1000,
        description="Unit of parameters by name, as tables and figures show it: {E: kPa}; nothing is converted.",
    )
    keep: Keep = Field("failed", description="Which run folders are kept: failed (the last 20), all or none.")
    folder: str | None = Field(None, description="Folder of its files; that of the problem file unless given.")
    # Only in canonical problems; users do not write it.
    contents: SkipJsonSchema[dict[str, str] | None] = Field(None, description="texts of the templates")
    versions: SkipJsonSchema[dict[str, str] | None] = Field(None, description="fingerprints of copied and linked files")

    @field_validator("run", "then")
    @classmethod
    def _named(cls, value: Any) -> Any:
        calls = value if value and isinstance(value[0], tuple) else (value,)
        if any(call and not call[0].strip() for call in calls):
            raise ValueError("the program is empty; write for example [ccx, -i, footing]")
        return value

    @model_validator(mode="after")
    def _told_apart(self) -> CommandSpec:
        seen: dict[str, str] = {}
        made = [("files", self.files), ("link", self.link), ("templates", self.templates), ("write", self.write)]
        for field, names in made:
            for name in names:
                if name in seen:
                    raise ValueError(f"{name} is in {seen[name]} and in {field}; give it in one of them only")
                seen[name] = field
        for name in (*self.success.files, *(one for reader in self.series.values() for one in reader.files)):
            if any(name == link or name.startswith(f"{link}/") for link in self.link):
                raise ValueError(
                    f"{name} is read, but is linked or lies in a linked folder, so it could be that of another run; "
                    "have the program write into its run folder, or copy that folder (files)"
                )
        for name, field in seen.items():
            inside = next((link for link in self.link if field != "link" and name.startswith(f"{link}/")), None)
            if inside is not None:
                raise ValueError(
                    f"{name} in {field} lies in the linked folder {inside}: runs at once would write over each other; "
                    "copy that folder (files), or choose another place"
                )
        return self

    def with_files(self, folder: Path | None, path: str) -> CommandSpec:
        """With the texts of its templates and the fingerprints of the files that it copies and links."""
        if self.contents is not None and self.folder is not None:
            return self
        if folder is None:
            raise ProblemError([Issue(path, "kind: command names files; it is accepted from problem files only")])
        base = (folder / (self.folder or "")).resolve()
        issues: list[Issue] = []
        contents: dict[str, str] = {}
        for target, source in self.templates.items():
            try:
                contents[source] = read_template_file(base / source)
            except TemplateError as error:
                issues.append(Issue(f"{path}.templates.{target}", f"{source} {error.message}"))
        versions: dict[str, str] = {}
        for field, names in (("files", self.files), ("link", self.link)):
            for index, name in enumerate(names):
                if (base / name).is_file() or (base / name).is_dir():
                    versions[name] = fingerprint(base / name)
                else:
                    what = "is neither a file nor a folder" if (base / name).exists() else f"is not in {base}"
                    issues.append(Issue(f"{path}.{field}[{index}]", f"{name} {what}"))
        series = {}
        for name, reader in self.series.items():
            try:
                series[name] = reader.with_sources(base)
            except TemplateError as error:
                issues.append(Issue(f"{path}.series.{name}", str(error)))
        if issues:
            raise ProblemError(issues)
        given = {"folder": str(base), "contents": contents, "versions": versions, "series": series}
        return self.model_copy(update=given)

    def build(self) -> CommandModel:
        """Build the forward model.

        Raises
        ------
        ProblemError
            A template cannot be understood.
        """
        from geoswarm.solver.forward.programs.command_model import CommandModel

        return CommandModel(self)
