"""The forward model that a program is: one run of it for each evaluation."""

from __future__ import annotations

import hashlib
import os
import sys
import time
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, Issue, ProblemError
from geoswarm.solver.external.errors import InputError, OutputError, RunFailedError, TemplateError
from geoswarm.solver.external.inputs.parameter_files import parameter_text
from geoswarm.solver.external.inputs.pest_template import PestTemplate, parse_pest_template
from geoswarm.solver.external.inputs.template import SLOT, Template, parse_template
from geoswarm.solver.external.inputs.texts import write_input_file
from geoswarm.solver.external.interpolation import at_points
from geoswarm.solver.external.reading_time import reading
from geoswarm.solver.external.runs.folder import Keep, RunFolder, private_folder, tidy
from geoswarm.solver.external.runs.program import Ended, NotStartedError, run_program
from geoswarm.solver.external.runs.secrets import Secrets, private_values
from geoswarm.solver.external.runs.slots import slot
from geoswarm.solver.external.runs.sources import Sources
from geoswarm.solver.external.runs.verdict import OUTPUT as RULE_OUTPUT
from geoswarm.solver.external.runs.verdict import FileState, judge, not_of_run, states
from geoswarm.solver.external.trial import is_watched, note
from geoswarm.solver.forward.base import ForwardRun, NotedResponse, ParameterInfo
from geoswarm.solver.forward.programs.foreign import ForeignModel, series_in_base_units
from geoswarm.solver.system.activity import has_waited, waiting
from geoswarm.solver.system.environment import clean_environment
from geoswarm.solver.units import base_unit, convert

if TYPE_CHECKING:
    from geoswarm.solver.forward.programs.command import CommandSpec

__all__ = ["CommandModel", "ProgramRun"]

AnyTemplate: TypeAlias = Template | PestTemplate

Read: TypeAlias = Callable[[Mapping[str, tuple[FloatArray, FloatArray]]], dict[str, FloatArray]]
"""Makes responses of x and y of each series, in base units."""

OUTPUT = "output.txt"
"""File in the run folder with what the program has printed."""

NO_LICENCE = "no_licence"

_COLLECTIONS, _PIECES = (".pvd", ".pvtu", ".xdmf"), (".vtu", ".pvtu", ".h5", ".hdf5")

_LINES = 12  # of what a program printed that are shown with a failure


class CommandModel(ForeignModel):
    """A program as a forward model; its parameters are all names in the templates.

    Parameters
    ----------
    spec
        Its section, with the contents of its files.
    texts
        Further names that are replaced in arguments and environment, ``{name}``.
    private
        Whether messages hide the values of its environment, which is not the reader's.

    Raises
    ------
    ProblemError
        A template cannot be understood, or the unit of a series is unknown.
    """

    def __init__(self, spec: CommandSpec, texts: Mapping[str, str] | None = None, *, private: bool = False) -> None:
        self.spec = spec
        self.private = private
        self.texts = dict(texts or {})
        self.templates = _templates(spec)
        series = series_in_base_units(spec.series, lambda reader: f"Read from {reader.file}.")
        super().__init__(_parameters(self.templates, spec.units), series)

    @property
    def open_parameters(self) -> bool:
        """True: a problem may declare helpers, and what only files of parameters hold."""
        return True

    def unused(self, names: Collection[str]) -> tuple[str, ...]:
        """Those of some parameters that no file gets."""
        if self.spec.write:
            return ()
        used = {name for template in self.templates.values() for name in template.used(names)}
        return tuple(name for name in names if name not in used)

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of series at x, each of shape (m_g,), base units.

        Raises
        ------
        ProblemError
            What a series needs to be read is not installed.
        """
        wanted = {name: np.array(x, dtype=np.float64) for name, x in points.items()}
        lacking = [
            Issue(f"forward_model.series.{name}", lacks) for name in wanted if (lacks := self.spec.series[name].lacks)
        ]
        if lacking:
            raise ProblemError(lacking)
        run: ProgramRun | None = None

        def calculate(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            nonlocal run
            if run is None:  # nothing is read or made for a problem that is only looked at
                run = ProgramRun(self, wanted.keys())
                tidy(run.parent)
            return run(parameters, lambda found: {name: at_points(name, *found[name], x) for name, x in wanted.items()})

        return calculate


class ProgramRun:
    """Runs the program for some series.

    Parameters
    ----------
    model
        The forward model.
    series
        Names of those that are read.

    Raises
    ------
    RunFailedError
        A file has changed since the problem was read.
    """

    def __init__(self, model: CommandModel, series: Collection[str]) -> None:
        spec = self._spec = model.spec
        self._templates, self._texts, self._private = model.templates, model.texts, model.private
        self._readers = {name: spec.series[name] for name in series}
        try:
            self._sources = Sources(Path(spec.folder or "."), spec.files, spec.link, spec.versions or {})
        except ValueError as error:
            raise RunFailedError("not_started", str(error)) from None
        try:
            self.parent = private_folder("runs")
            self._slots = private_folder("slots", _mark(spec)) if spec.slots or _uses_slot(model) else None
        except OSError as error:
            raise RunFailedError("not_started", f"there is no place for run folders: {error}") from None
        self._written = (*spec.files, *spec.link, *spec.templates, *spec.write)
        self._outputs = tuple(
            dict.fromkeys((*spec.success.files, *(file for reader in self._readers.values() for file in reader.files)))
        )

        texts = {*spec.success.text, *spec.fail.text} - {RULE_OUTPUT}
        self._pieces = tuple(name for name in (*spec.files, *spec.link) if name.lower().endswith(_PIECES))
        self._looked_at = (*texts, *self._pieces)

    def __call__(
        self,
        parameters: Mapping[str, float],
        read: Read,
    ) -> dict[str, FloatArray]:
        """Run until a call succeeds.

        Parameters
        ----------
        parameters
            Values by name.
        read
            What it raises makes the run a failed one.

        Raises
        ------
        ForwardError
            All calls have failed.
        """
        if self._slots is None:
            return self._calls(parameters, 0, read)
        with slot(self._slots, self._spec.slots) as number:
            return self._calls(parameters, number, read)

    def _calls(
        self,
        parameters: Mapping[str, float],
        number: int,
        read: Read,
    ) -> dict[str, FloatArray]:
        failures: list[ForwardError] = []
        for arguments in (self._spec.run, *self._spec.then):
            try:
                response = self._with_licence(arguments, parameters, number, read)
            except ForwardError as error:
                failures.append(error)
                continue
            if not failures:
                return response
            earlier = "; ".join(f"{failure.reason}: {str(failure).partition(chr(10))[0]}" for failure in failures)
            return NotedResponse(response, f"counted: {' '.join(arguments)}, after {earlier}")
        if len(failures) == 1:
            raise failures[0]
        raise RunFailedError(failures[-1].reason, "; ".join(str(error) for error in failures))

    def _with_licence(
        self,
        arguments: Sequence[str],
        parameters: Mapping[str, float],
        number: int,
        read: Read,
    ) -> dict[str, FloatArray]:
        """One call, repeated while there is no licence for it; calls that were refused are no time of the run."""
        patience = time.monotonic() + self._spec.licence_patience
        while True:
            began = time.monotonic()
            try:
                return self._once(arguments, parameters, number, read)
            except RunFailedError as failure:
                if failure.reason != NO_LICENCE or time.monotonic() > patience:
                    raise
            has_waited(time.monotonic() - began)
            with waiting():
                time.sleep(self._spec.licence_pause)

    def _once(
        self,
        arguments: Sequence[str],
        parameters: Mapping[str, float],
        number: int,
        read: Read,
    ) -> dict[str, FloatArray]:
        """One call in a folder of its own."""
        spec = self._spec
        replaced = {**self._texts, "slot": str(number), "python": sys.executable}
        call = [_replaced(argument, replaced) for argument in arguments]
        given = {name: _replaced(value, replaced) for name, value in spec.environment.items()}
        passed = [value for name in spec.pass_ if (value := os.environ.get(name))]
        secrets = Secrets(passed, private_values(spec.environment, given) if self._private else ())
        try:
            folder = RunFolder(self.parent)
        except OSError as error:
            raise RunFailedError(
                "not_started", f"no run folder can be made in {self.parent}: {error.strerror}"
            ) from None
        keep: Keep = "all" if is_watched() else spec.keep
        ended, failure = None, None
        try:
            environment = {**clean_environment(os.environ, spec.pass_), **given}
            self._fill(folder, parameters, number)
            before = states(folder.path, (*self._outputs, *self._looked_at))
            output = folder.path / OUTPUT
            ended = run_program(call, folder.path, environment, spec.seconds, output)
            with reading("texts of success and fail", spec.seconds):
                judge(
                    ended, call[0], folder.path, folder.made_at, before, self._outputs, spec.success, spec.fail, output
                )
            self._refuse_old_pieces(folder, before)
            return read({name: self._read(name, folder.path) for name in self._readers})
        except (NotStartedError, InputError, OutputError, ForwardError, OSError) as error:
            if isinstance(error, RunFailedError) and error.reason == NO_LICENCE and not is_watched():
                keep = "none"  # it waits, and is called again
            failure = _failure(error, ended, folder, keep, secrets)
            raise failure from None
        finally:
            kept = folder.finish(keep, failed=failure is not None)
            if kept is not None and is_watched():
                words, printed = (
                    (None, "") if ended is None else (ended.words, secrets.hidden(ended.tail, str(folder.path)))
                )
                why = None if failure is None else str(failure)
                note(tuple(call), kept, self._written, words, printed, why, self._readers, spec.seconds)

    def _fill(self, folder: RunFolder, parameters: Mapping[str, float], number: int) -> None:
        """Copy, link and write what a run finds in its folder."""
        spec = self._spec
        self._sources.place(folder)
        values = {**parameters, SLOT: float(number)}
        for name, template in self._templates.items():
            target = folder.path / name
            target.parent.mkdir(parents=True, exist_ok=True)
            write_input_file(target, template.fill(values))
        for name, kind in spec.write.items():
            folder.write(name, parameter_text(kind, parameters))
        for name in self._outputs:  # many programs write into a folder, and do not make it
            (folder.path / name).parent.mkdir(parents=True, exist_ok=True)

    def _refuse_old_pieces(self, folder: RunFolder, before: Mapping[str, FileState]) -> None:
        """Results on a mesh may be named in a new file and lie in old ones."""
        collections = [one.file for one in self._readers.values() if one.file.lower().endswith(_COLLECTIONS)]
        if not collections:
            return
        old = {
            name: "older than the run"
            for name, state in states(folder.path, self._pieces).items()
            if state == before[name]
        }
        for path in folder.path.rglob("*"):
            if path.name.lower().endswith(_PIECES) and (why := not_of_run(folder.path, path, folder.made_at)):
                old.setdefault(path.relative_to(folder.path).as_posix(), why.removeprefix("is "))
        for file in collections:
            text = (folder.path / file).read_text(encoding="utf-8", errors="replace")
            named = next((name for name in old if name.rpartition("/")[2] in text), None)
            if named is not None:
                raise RunFailedError("no_output", f"{file} names {named}, which is {old[named]}")

    def _read(self, name: str, folder: Path) -> tuple[FloatArray, FloatArray]:
        """x and y of a series in base units."""
        reader = self._readers[name]
        with reading(f"series {name} from {reader.file}", self._spec.seconds):
            x, y = reader.read(folder)
        return (
            convert(x, reader.x_unit, base_unit(reader.x_unit)),
            convert(y, reader.y_unit, base_unit(reader.y_unit)),
        )


def _failure(error: Exception, ended: Ended | None, folder: RunFolder, keep: Keep, secrets: Secrets) -> RunFailedError:
    """With what the program printed last, and where its folder is."""
    reason, message = "not_started", str(error)
    if isinstance(error, InputError):
        reason = "infeasible"
    elif isinstance(error, OutputError | ForwardError):
        reason = error.reason
    elif isinstance(error, OSError):
        message = f"the run folder cannot be filled: {error.filename or folder.path}: {error.strerror or error}"
    place = str(folder.path)
    told = [secrets.hidden(message, place, *(() if ended is None else (ended.words,)))]
    printed = [] if ended is None else secrets.hidden(ended.tail, place).rstrip().splitlines()[-_LINES:]
    if printed:
        told.append("it printed:\n" + "\n".join(f"  {line}" for line in printed))
    if keep != "none":
        told.append(f"run folder: {folder.kept_as(failed=True)}")
    return RunFailedError(reason, "\n".join(told))


def _mark(spec: CommandSpec) -> str:
    """What distinguishes the slots of one program: their name, else the place of its files and the command."""
    if spec.pool:
        return f"pool-{spec.pool}"
    return hashlib.sha256(f"{spec.folder}\0{spec.run[0]}".encode()).hexdigest()[:16]


def _templates(spec: CommandSpec) -> dict[str, AnyTemplate]:
    """Template by the file that it becomes."""
    contents, issues, found = spec.contents or {}, [], {}
    for target, source in spec.templates.items():
        parse = parse_pest_template if source.endswith(".tpl") else parse_template
        try:
            found[target] = parse(contents[source], source)
        except TemplateError as error:
            issues.append(Issue(f"forward_model.templates.{target}", str(error)))
    if issues:
        raise ProblemError(issues)
    return found


def _parameters(templates: Mapping[str, AnyTemplate], units: Mapping[str, str]) -> tuple[ParameterInfo, ...]:
    """All names in the templates, and those with a unit; names of PEST have no case unless something else gives it."""
    users: dict[str, list[str]] = {}
    exact = {name for one in templates.values() if isinstance(one, Template) for name in one.names}
    lower = {name.lower(): name for name in (*units, *exact)}
    for target, template in templates.items():
        for name in sorted(template.names):
            users.setdefault(name if name in exact else lower.get(name, name), []).append(target)
    users |= {name: [] for name in units if name not in users}
    return tuple(
        ParameterInfo(
            name,
            name,
            units.get(name, ""),
            f"Used by {', '.join(targets)}." if targets else "Named in forward_model.units.",
            any_case=name not in exact and bool(targets),
        )
        for name, targets in users.items()
    )


def _uses_slot(model: CommandModel) -> bool:
    spec = model.spec
    texts = (*spec.run, *(one for call in spec.then for one in call), *spec.environment.values())
    named = any("{slot}" in text for text in texts)
    return named or any(
        SLOT in placeholder.expression.names
        for template in model.templates.values()
        if isinstance(template, Template)
        for placeholder in template.placeholders
    )


def _replaced(text: str, values: Mapping[str, str]) -> str:
    for name, value in values.items():
        text = text.replace(f"{{{name}}}", value)
    return text
