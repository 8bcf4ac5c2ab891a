"""``geoswarm models``: the models that are registered on this machine."""

from __future__ import annotations

import os
import time
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from geoswarm.cli.model.trial import echo_run
from geoswarm.cli.options import json_option, read_values, values_option
from geoswarm.cli.words.error_messages import BadInputError, FailedRunError
from geoswarm.cli.words.output import echo_facts, echo_json, echo_table, note, number

if TYPE_CHECKING:
    from geoswarm.solver.forward.base import ForwardModel
    from geoswarm.solver.registered.declaration import Declaration, DeclaredParameter

__all__ = ["models_command"]


SECRET_HELP = "File with the secret to sign with; a new one is written to it where there is none."


@click.group("models")
def models_command() -> None:
    """List, show, check and sign the models registered on this machine (GEOSWARM_MODELS)."""


@models_command.command("list")
@json_option
def list_models(as_json: bool) -> None:
    """List the registered models with their versions."""
    from geoswarm.solver.errors import ProblemError
    from geoswarm.solver.registered.declaration import read_declaration
    from geoswarm.solver.registered.folders import VARIABLE, find_folder, registered_names, version_of

    rows: list[dict[str, str]] = []
    for name in registered_names():
        folder, version = find_folder(name), ""
        try:
            version = version_of(folder)
            title = read_declaration(folder).title
        except ProblemError as error:
            title = f"broken: {error.issues[0]}"
        except (OSError, ValueError) as error:
            title = f"broken: {error}"
        rows.append({"model": name, "version": version, "title": title, "folder": str(folder)})
    if as_json:
        echo_json(rows)
    elif rows:
        cells = [(row["model"], row["version"][:12], row["title"], row["folder"]) for row in rows]
        echo_table(None, ("model", "version", "title", "folder"), cells)
    else:
        note(f"No model is registered: {VARIABLE} names folders, each folder in them with a model.yaml is a model.")


@models_command.command("show")
@click.argument("name")
@json_option
def show_model(name: str, as_json: bool) -> None:
    """Show parameters, settings and series of a registered model."""
    from geoswarm.solver.registered.folders import version_of
    from geoswarm.solver.registered.model import declared_of

    folder, declaration = _found(name)
    declared = declared_of(folder, declaration)
    version = version_of(folder)
    if as_json:
        document = {"model": name, "version": version, "folder": str(folder), **declaration.model_dump(mode="json")}
        echo_json(document | {"series": declared.model_dump(mode="json")["series"]})
        return
    echo_facts(name, {"title": declaration.title or "-", "version": version, "folder": str(folder)})
    rows = [(one, info.unit or "-", _limits(info), info.description) for one, info in declaration.parameters.items()]
    echo_table("Parameters", ("parameter", "unit", "accepted", "description"), rows)
    if declaration.settings:
        settings = [(key, one.type, str(one.default), one.description) for key, one in declaration.settings.items()]
        echo_table("Settings", ("setting", "type", "default", "description"), settings)
    series = [(key, one.x_unit or "-", one.y_unit or "-", one.description) for key, one in declared.series.items()]
    echo_table("Series", ("series", "x", "y", "description"), series)


@models_command.command("check")
@click.argument("name")
@values_option("Value of a parameter")
def check_model(name: str, given: tuple[str, ...]) -> None:
    """Run a registered model once, at its defaults, typical values or the middle of its limits.

    Shows what was written and read, and keeps the run folder. Exit code 1 when the run fails.
    """
    from geoswarm.solver.errors import ForwardError
    from geoswarm.solver.external.trial import watched
    from geoswarm.solver.forward.programs.command_model import CommandModel, ProgramRun
    from geoswarm.solver.registered.model import program_of
    from geoswarm.solver.registered.settings import chosen, numbers_of

    folder, declaration = _found(name)
    model = program_of(folder, declaration, {})
    values = read_values(given, partial(_mistake, declaration))
    values = {one: values[one] if one in values else _value(one, info) for one, info in declaration.parameters.items()}
    numbers = numbers_of(declaration.settings, chosen(declaration.settings, {}))
    if not isinstance(model, CommandModel):
        _run_once(name, model, {**values, **numbers})
        return
    failure: str | None = None
    with watched() as runs:
        try:
            ProgramRun(model, model.spec.series)({**values, **numbers}, lambda _found: {})
        except ForwardError as error:
            failure = f"the run failed ({error.reason}): {error}"
    echo_table(None, ("parameter", "value"), [(one, number(value, 10)) for one, value in values.items()], right=(1,))
    for run in runs:
        echo_run(run, whole=False)
    if failure is not None:
        raise FailedRunError(failure)


@models_command.command("sign")
@click.argument("names", nargs=-1, metavar="[NAME]...")
@click.option("--secret-file", type=click.Path(path_type=Path), required=True, metavar="FILE", help=SECRET_HELP)
@click.option(
    "--output", type=click.Path(path_type=Path), required=True, metavar="FILE", help="Where to write the list."
)
def sign_models(names: tuple[str, ...], secret_file: Path, output: Path) -> None:
    """Sign the list of models that agents may fetch: those named, all registered ones when none is.

    The service sends the list, and the files in it, when GEOSWARM_SIGNED_MODELS names it; it needs no secret. An agent
    fetches them when it is started with --fetch-models and the same secret.
    """
    from geoswarm.solver.errors import SignedListError
    from geoswarm.solver.registered.folders import VARIABLE, registered_names
    from geoswarm.solver.registered.signed import SignedList, listed, new_secret, read_secret

    chosen = names or registered_names()
    if not chosen:
        raise BadInputError(f"no model is registered on this machine; {VARIABLE} names the folders")
    try:
        models = {name: listed(_found(name)[0]) for name in chosen}
    except (SignedListError, OSError, ValueError) as error:
        raise BadInputError(str(error)) from None
    try:
        if not secret_file.exists():
            with os.fdopen(os.open(secret_file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600), "w") as file:
                file.write(new_secret() + "\n")
            note(f"A new secret was written to {secret_file}; give agents a copy, and the service none.")
        secret = read_secret(secret_file)
    except (OSError, SignedListError) as error:
        why = error.strerror or error if isinstance(error, OSError) else error
        raise BadInputError(f"--secret-file {secret_file}: {why}") from None
    draft = output.with_name(f".{output.name}.{os.getpid()}")
    try:
        draft.write_bytes(SignedList.signed(models, int(time.time()), secret).document())
        draft.replace(output)  # a service that reads it meanwhile sees the old list or the new one
    except OSError as error:
        raise BadInputError(f"--output {output}: {error.strerror or error}; name a file to write to") from None
    rows = [(name, model.version[:12], str(len(model.files))) for name, model in models.items()]
    echo_table(None, ("model", "version", "files"), rows, right=(2,))


def _run_once(name: str, model: ForwardModel, values: dict[str, float]) -> None:
    """Calculate the first series of a model that starts no program, where it knows at which points."""
    from geoswarm.solver.errors import ForwardError

    series = model.series[0]
    x = model.grid(series.name)
    if not x.size:
        note(f"Model {name} is valid; it starts no program, so nothing was run.")
        return
    try:
        y = model.prepare({series.name: x})(values)[series.name]
    except ForwardError as error:
        raise FailedRunError(f"the run failed ({error.reason}): {error}") from None
    last = f"{number(float(y[-1]))} {series.y_unit} at {number(float(x[-1]))} {series.x_unit}"
    echo_facts(name, {"series": series.name, "points": str(x.size), "last": last})


def _found(name: str) -> tuple[Any, Declaration]:
    from geoswarm.solver.errors import UnknownForwardModelError
    from geoswarm.solver.registered.declaration import read_declaration
    from geoswarm.solver.registered.folders import find_folder

    try:
        folder = find_folder(name)
    except UnknownForwardModelError as error:
        raise BadInputError(str(error)) from None
    return folder, read_declaration(folder)


def _limits(info: DeclaredParameter) -> str:
    low, high = info.lower, info.upper
    parts = [f"at least {low:g}" if low is not None else "", f"at most {high:g}" if high is not None else ""]
    return " and ".join(part for part in parts if part) or "any"


def _value(name: str, info: DeclaredParameter) -> float:
    """The default, else the middle of what is typical, else of the limits."""
    if info.default is not None:
        return info.default
    ends = info.typical or (info.lower, info.upper)
    low, high = ends
    if low is None or high is None:
        raise BadInputError(f"parameter {name} has neither a default nor a typical range; give --set {name}=VALUE")
    return (low * high) ** 0.5 if low > 0.0 else (low + high) / 2.0


def _mistake(declaration: Declaration, name: str) -> str | None:
    from geoswarm.solver.words import did_you_mean

    known = declaration.parameters
    return None if name in known else f"unknown parameter{did_you_mean(name, known)}; known: {', '.join(known)}"
