"""Settings from the environment; secrets from it or from files.

A secret is the value of a variable, or the content of the file that the variable with the suffix ``_FILE`` names.
Docker, Kubernetes and systemd pass secrets as files: they appear in no process list, no ``docker inspect`` and no
environment that a child process inherits.
"""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

if TYPE_CHECKING:
    from pydantic import BaseModel, ValidationError

__all__ = ["SECRETS", "SecretFileError", "listed", "read_settings", "secret", "without_secrets"]

Settings = TypeVar("Settings", bound="BaseModel")

SECRETS = ("GEOSWARM_DATABASE_URL", "GEOSWARM_BROKER_URL", "GEOSWARM_API_KEY", "GEOSWARM_KEY", "GEOSWARM_SMTP_PASSWORD")
"""Variables with passwords and keys."""


LONGEST = 4096  # bytes


class SecretFileError(ValueError):
    """A secret is given twice, or its file cannot be used; the message names variable and file, never what is in it."""


def secret(name: str, environment: Mapping[str, str] | None = None) -> str | None:
    """Return the value of a variable, or the one line of the file that ``NAME_FILE`` names; None: neither is set.

    Parameters
    ----------
    name
        The variable that holds the secret itself, for example ``GEOSWARM_API_KEY``.
    environment
        The process's own when not given.

    Raises
    ------
    SecretFileError
        When both are set, or the file cannot be read, is empty or holds more than one line.
    """
    variables = os.environ if environment is None else environment
    value, named = variables.get(name), variables.get(f"{name}_FILE")
    if not named:
        return value or None
    if value:
        raise SecretFileError(f"{name} and {name}_FILE are both set; give the secret or the file with it")
    return _only_line(f"{name}_FILE", Path(named))


def without_secrets(environment: Mapping[str, str]) -> dict[str, str]:
    """Return an environment without the variables of :data:`SECRETS`, and without those that name files with them."""
    hidden = {*SECRETS, *(f"{name}_FILE" for name in SECRETS)}
    return {name: value for name, value in environment.items() if name not in hidden}


def read_settings(
    kind: type[Settings], variables: Mapping[str, str], overrides: Mapping[str, Any], wrong: type[Exception]
) -> Settings:
    """Return settings of a kind: the overrides that are not None, else what the variables hold.

    Parameters
    ----------
    variables
        Name of the variable by field. An empty one counts as not set; one of :data:`SECRETS` may name a file.
    wrong
        The error that is raised.

    Raises
    ------
    Exception
        ``wrong``: names the setting or its variable, its value unless it is secret, and what is accepted.
    """
    from pydantic import ValidationError  # secrets are read without it

    given = {field: value for field, value in overrides.items() if value is not None}
    try:
        for field, variable in variables.items():
            if field not in given and (value := secret(variable) if variable in SECRETS else os.environ.get(variable)):
                given[field] = value
        return kind(**given)
    except SecretFileError as error:
        raise wrong(str(error)) from None
    except ValidationError as error:
        raise wrong("; ".join(_mistakes(error, variables, overrides))) from None


def _mistakes(error: ValidationError, variables: Mapping[str, str], overrides: Mapping[str, Any]) -> Iterator[str]:
    for item in error.errors(include_url=False):
        field = str(item["loc"][0]) if item["loc"] else ""
        variable = variables.get(field, field)
        name = field if overrides.get(field) is not None else variable
        if item["type"] == "value_error":  # of our own, with the value where it is no secret
            yield f"{name} {item['ctx']['error']}".lstrip()
        else:
            value = "" if variable in SECRETS else f" {item['input']!r:.100}"
            yield f"{name}{value}: {item['msg']}"


def listed(value: Any) -> Any:
    """Return the names of a text with commas between them; what is not a text stays as it is."""
    return [part.strip() for part in value.split(",") if part.strip()] if isinstance(value, str) else value


def _only_line(variable: str, path: Path) -> str:
    try:
        with path.open("rb") as file:
            content = file.read(LONGEST + 1)
        text = content.decode("utf-8").strip("\r\n")
    except OSError as error:
        raise SecretFileError(f"{variable}: {path} cannot be read: {error.strerror}") from None
    except UnicodeDecodeError:
        raise SecretFileError(f"{variable}: {path} is not text in UTF-8") from None
    if not text.strip() or len(text.splitlines()) > 1 or len(content) > LONGEST:
        raise SecretFileError(f"{variable}: {path} must hold the secret on one line (at most {LONGEST} bytes)")
    return text
