"""The forward model that a registered folder and some settings make."""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, Issue, ProblemError, in_words, message_of
from geoswarm.solver.external.errors import RunFailedError
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec, ForwardRun, NotedResponse
from geoswarm.solver.forward.programs.command import CommandSpec
from geoswarm.solver.forward.programs.command_model import CommandModel
from geoswarm.solver.forward.programs.foreign import ForeignModel
from geoswarm.solver.forward.registry import find_spec, parse_spec
from geoswarm.solver.parameter_info import outside_limits
from geoswarm.solver.problem.issues import issues_of
from geoswarm.solver.problem.parameters import missing_parameters
from geoswarm.solver.registered.declaration import FILE, Declaration, Declared, DeclaredSeries, read_declaration
from geoswarm.solver.registered.folders import version_of
from geoswarm.solver.registered.settings import Given, chosen, numbers_of, texts_of

if TYPE_CHECKING:
    from geoswarm.solver.registered.spec import RegisteredSpec

__all__ = ["RegisteredModel", "declared_at", "declared_of", "program_of"]


def program_of(
    folder: Path, declaration: Declaration, given: Mapping[str, Given], *, private: bool = False
) -> ForwardModel:
    """Build the model of the program in a registered folder.

    Parameters
    ----------
    folder, declaration
        Of the model.
    given
        Settings that were chosen, as the declaration allows.
    private
        Whether others than the operator read its messages.

    Raises
    ------
    ProblemError
        ``model.yaml`` or a file that it names is wrong; each issue has its path in it.
    """
    values = chosen(declaration.settings, given)
    spec = _section(folder, declaration)
    texts = texts_of(declaration.settings, values)
    model: ForwardModel = CommandModel(spec, texts, private=private) if isinstance(spec, CommandSpec) else spec.build()
    known = declaration.parameters.keys() | numbers_of(declaration.settings, values).keys()
    for info in missing_parameters(model, known):
        where = "parameters, nor among settings with a number"
        raise ProblemError([Issue(f"{FILE}: parameters.{info.name}", f"is used, but not declared among {where}")])
    return model


def declared_of(folder: Path, declaration: Declaration) -> Declared:
    """What problems keep of a model.

    Raises
    ------
    ProblemError
        As :func:`program_of`.
    """
    series = {
        info.name: DeclaredSeries(description=info.description, x_unit=info.x_unit, y_unit=info.y_unit)
        for info in program_of(folder, declaration, {}).series
    }
    return Declared(parameters=declaration.parameters, series=series)


@lru_cache(maxsize=256)
def declared_at(folder: Path, version: str) -> Declared:
    """What problems keep of a version of a model: found once, as nothing of it changes.

    Parameters
    ----------
    version
        Of the folder, as it is now.

    Raises
    ------
    ProblemError
        As :func:`program_of`.
    ValueError
        The files are being changed.
    """
    declared = declared_of(folder, read_declaration(folder))
    if version_of(folder) != version:
        raise ValueError("its files are being changed; try again when that is done")
    return declared


def _section(folder: Path, declaration: Declaration) -> ForwardModelSpec:
    section: dict[str, Any] = declaration.forward_model
    try:
        spec = parse_spec(section)
    except ValidationError as error:
        schema = find_spec(str(section["kind"])).model_json_schema
        raise ProblemError(issues_of(error, section, "forward_model", schema)) from None
    for law in spec.user_laws:
        library = Path(law.library)
        if library.is_absolute() or ".." in library.parts or law.file != law.library:
            text = f"'{library}': the library must lie in the folder of the model, whose files are its version; link it"
            raise ProblemError([Issue(f"{FILE}: library", text)])
    return spec.with_files(folder, "forward_model")


class RegisteredModel(ForeignModel):
    """A model of the operator's, with the parameters and series that it has declared.

    Parameters
    ----------
    spec
        Section of the problem, with what it has kept of the model.
    declared
        The same.
    """

    def __init__(self, spec: RegisteredSpec, declared: Declared) -> None:
        self._spec = spec
        super().__init__(
            (one.info(name) for name, one in declared.parameters.items()),
            (one.info(name) for name, one in declared.series.items()),
        )

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """Values outside the declared limits."""
        return outside_limits(self._parameters.values(), parameters)

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of series at x, each of shape (m_g,), base units; the model is needed at the first run.

        Runs of a model that is not here, or has changed, fail (``worker_lost``), and those of one that cannot be built
        (``not_started``). Messages are those that users of a service may see.
        """
        shown = self._spec.shown
        run: ForwardRun | None = None

        def calculate(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            nonlocal run
            try:
                run = run or self._program(points)
                response = run(parameters)
            except ForwardError as error:
                raise RunFailedError(error.reason, shown(message_of(error))) from None
            except MemoryError:
                raise
            except Exception as error:  # noqa: BLE001  anybody's function, or a fault of ours: it may name a folder
                told = shown(f"the forward model raised {in_words(error)}")
                raise RunFailedError("bad_output", told) from None
            return NotedResponse(response, shown(response.note)) if isinstance(response, NotedResponse) else response

        return calculate

    def _program(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build what runs, with the defaults of parameters and the settings that are numbers; raises ForwardError."""
        if why := self._spec.unavailable():
            raise RunFailedError("worker_lost", why)  # tried again: the worker will refuse the job
        try:
            model, numbers = self._spec.program()
            run = model.prepare(points)
        except ProblemError as error:
            raise RunFailedError("not_started", str(error)) from None
        known = {info.name: info.default for info in self.parameters if info.default is not None} | numbers

        def calculate(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
            return run({**known, **{name: parameters[name] for name in self._parameters if name in parameters}})

        return calculate
