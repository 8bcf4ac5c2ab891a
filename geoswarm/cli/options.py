"""Options and arguments that several commands share."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from geoswarm.cli.words.error_messages import BadInputError

if TYPE_CHECKING:
    _ParamType = click.ParamType[float]
else:
    _ParamType = click.ParamType  # takes no type argument before click 8.4

__all__ = [
    "SPAN",
    "accept_option",
    "accepting",
    "api_key_option",
    "broker_option",
    "connection_options",
    "database_option",
    "job_argument",
    "json_option",
    "problem_argument",
    "read_values",
    "values_option",
]

Decorated = TypeVar("Decorated", bound=Callable[..., Any])


def _from_file(context: click.Context, option: click.Parameter, value: str | None) -> str | None:
    """Take an option that holds a secret from the file that its variable with ``_FILE`` names, if it is not given."""
    from click.core import ParameterSource

    from geoswarm.environment import SecretFileError, secret

    given = option.name is not None and context.get_parameter_source(option.name) is ParameterSource.COMMANDLINE
    if given or context.resilient_parsing or not isinstance(option.envvar, str):
        return value
    try:
        return secret(option.envvar)
    except SecretFileError as error:
        raise BadInputError(str(error)) from None


problem_argument = click.argument("problem", type=click.Path(path_type=Path), metavar="PROBLEM")
"""Path of a problem file; reading it reports what is wrong with it."""

job_argument = click.argument("job", metavar="ID")
"""A job's id, its first characters where they name one job only, or ``latest``."""


def values_option(help: str) -> Callable[[Decorated], Decorated]:
    """Add ``--set``, which may be repeated; :func:`read_values` reads what is given."""
    return click.option("--set", "given", multiple=True, metavar="NAME=VALUE", help=f"{help}; may be repeated.")


def read_values(given: Sequence[str], mistake: Callable[[str], str | None]) -> dict[str, float]:
    """Read the ``NAME=VALUE`` texts of ``--set``.

    Parameters
    ----------
    mistake
        What is wrong with giving a value to a name, or None.

    Raises
    ------
    BadInputError
        For a text of another form, a mistake, a name given twice, or a value that is not a finite number.
    """
    values: dict[str, float] = {}
    for text in given:
        name, equals, value_text = (part.strip() for part in text.partition("="))
        if not equals or not name:
            raise BadInputError(f"--set {text!r}: give NAME=VALUE, for example --set lambda_star=0.1")
        if (wrong := mistake(name)) is not None:
            raise BadInputError(f"--set {name}: {wrong}")
        if name in values:
            raise BadInputError(f"--set {name}: given twice")
        try:
            value = float(value_text)
        except ValueError:
            value = math.nan
        if not math.isfinite(value):
            raise BadInputError(f"--set {name}: {value_text!r} is not a finite number")
        values[name] = value
    return values


accept_option = click.option(
    "--accept",
    multiple=True,
    metavar="SERIES",
    help="Readings of this series are meant as they are, although no soil can have them; may be repeated.",
)


def accepting(series: Sequence[str]) -> Callable[[dict[str, Any]], dict[str, Any]]:
    """Add the series of ``--accept`` to a problem as it was read."""

    def completed(document: dict[str, Any]) -> dict[str, Any]:
        known = document.get("accept", [])
        return document | {"accept": [*known, *series]} if series and isinstance(known, list) else document

    return completed


json_option = click.option("--json", "as_json", is_flag=True, help="Print JSON for scripts.")

api_key_option = click.option(
    "--api-key",
    envvar="GEOSWARM_API_KEY",
    show_envvar=True,
    callback=_from_file,
    metavar="KEY",
    help="API key of the service.",
)

database_option = click.option(
    "--database",
    envvar="GEOSWARM_DATABASE_URL",
    show_envvar=True,
    callback=_from_file,
    metavar="URL",
    help="Database, e.g. postgresql+psycopg://user:password@host/name or sqlite:///FILE.",
)

broker_option = click.option(
    "--broker",
    envvar="GEOSWARM_BROKER_URL",
    show_envvar=True,
    callback=_from_file,
    metavar="URL",
    help="Redis for remote workers, e.g. redis://host:6379/0.",
)

_url_option = click.option(
    "--url",
    envvar="GEOSWARM_URL",
    show_envvar=True,
    default="http://127.0.0.1:8765",
    show_default=True,
    metavar="URL",
    help="Address of the service.",
)


def connection_options(function: Decorated) -> Decorated:
    """Add ``--url`` and ``--api-key`` to a command that talks to a service."""
    decorated: Decorated = _url_option(api_key_option(function))
    return decorated


_SECONDS = {"s": 1.0, "m": 60.0, "h": 3600.0, "d": 86400.0, "w": 604800.0}
_PATTERN = re.compile(r"(\d{1,9}(?:\.\d{1,9})?)([smhdw])")


class _Span(_ParamType):
    name = "span"

    def convert(self, value: str | float, param: click.Parameter | None, ctx: click.Context | None) -> float:
        """Return seconds."""
        if isinstance(value, float):
            return value
        match = _PATTERN.fullmatch(str(value).strip().lower())
        if match is None:
            self.fail(f"must be a number with s, m, h, d or w, for example 90d or 12h; got {value!r}", param, ctx)
        return float(match[1]) * _SECONDS[match[2]]


SPAN = _Span()
"""Seconds, written as a number and a unit (second, minute, hour, day, week)."""
