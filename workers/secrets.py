"""Keeps secrets out of logs, and refuses those that everybody knows."""

from __future__ import annotations

import ipaddress
import os
import re

from sqlalchemy.engine import make_url
from sqlalchemy.exc import ArgumentError

from geoswarm.workers.errors import SettingsError
from geoswarm.workers.settings import Settings

__all__ = ["DEVELOPMENT", "is_loopback", "redact", "refuse_known_secrets", "refuse_weak_key"]

ENVIRONMENT = "GEOSWARM_ENVIRONMENT"
DEVELOPMENT = "development"
KNOWN = frozenset(
    (
        "admin",
        "administrator",
        "changeme",
        "change-me",
        "change_me",
        "default",
        "demo",
        "example",
        "geoswarm",
        "guest",
        "password",
        "passw0rd",
        "postgres",
        "postgresql",
        "qwerty",
        "redis",
        "root",
        "secret",
        "test",
        "testtest",
        "user",
        "12345678",
        "123456789",
        "1234567890",
    )
)
DIFFERENT_CHARACTERS = 5
LEAST_KEY_LENGTH = 32

_SECRETS = (
    (re.compile(r"gsw_([0-9a-f]{12})_[A-Za-z0-9_-]{43}"), r"gsw_\1_***"),
    (re.compile(r"(://[^\s:/@]*):[^\s/@]+@"), r"\1:***@"),  # without the scheme: linear in the text
    (
        re.compile(r"(?i)\b(authorization|x-api-key|cookie)(['\"]?\s*[:=]\s*['\"]?)((?:bearer|basic)\s+)?[^\s'\",]+"),
        r"\1\2***",
    ),
    (re.compile(r"(?i)\b(password|passwd|secret|api_key)(['\"]?\s*[:=]\s*['\"]?)[^\s'\",;&]+"), r"\1\2***"),
)


def redact(text: str) -> str:
    """Return a text with API keys, passwords and credentials in it made unreadable."""
    for pattern, replacement in _SECRETS:
        text = pattern.sub(replacement, text)
    return text


def refuse_known_secrets(settings: Settings) -> None:
    """Refuse passwords that everybody knows, for database and broker on other machines.

    Raises
    ------
    SettingsError
        Names the setting; GEOSWARM_ENVIRONMENT=development lets them pass.
    """
    if os.environ.get(ENVIRONMENT) == DEVELOPMENT:
        return
    for name, address in (("database", settings.database_url), ("broker", settings.broker_url)):
        password, host = _credentials(address)
        if password is not None and host is not None and not is_loopback(host) and is_known(password):
            raise SettingsError(
                f"the password of the {name} on {host} is publicly known; choose another one"
                f" (openssl rand -hex 24), or set {ENVIRONMENT}={DEVELOPMENT}"
            )


def refuse_weak_key(key: str, *, open_to_others: bool = True) -> str | None:
    """Refuse an API key from the environment that could be guessed; return a warning where it only should be longer.

    Parameters
    ----------
    open_to_others
        Whether other machines can reach the service.

    Raises
    ------
    SettingsError
    """
    if os.environ.get(ENVIRONMENT) == DEVELOPMENT:
        return None
    if is_known(key):
        raise SettingsError(
            "GEOSWARM_API_KEY is publicly known; make another one with 'openssl rand -hex 24',"
            f" or set {ENVIRONMENT}={DEVELOPMENT}"
        )
    if len(key) >= LEAST_KEY_LENGTH:
        return None
    short = (
        f"GEOSWARM_API_KEY has {len(key)} characters; at least {LEAST_KEY_LENGTH} are accepted where other machines"
        " reach the service. Make one with 'openssl rand -hex 24'"
    )
    if open_to_others:
        raise SettingsError(short)
    return short


def is_known(secret: str) -> bool:
    """Whether a secret is among those that are tried first, or hardly one at all."""
    word = secret.lower()
    trimmed = word.strip("0123456789!._-")
    return word in KNOWN or trimmed in KNOWN or len(set(word)) < DIFFERENT_CHARACTERS


def is_loopback(host: str) -> bool:
    """Whether an address can only be reached from this machine."""
    name = host.strip("[]").lower()
    try:
        return ipaddress.ip_address(name).is_loopback
    except ValueError:
        return name == "localhost" or name.startswith("/")  # a folder: a Unix socket


def _credentials(address: str | None) -> tuple[str | None, str | None]:
    if address is None:
        return None, None
    try:
        url = make_url(address)
    except ArgumentError:
        return None, None
    return (None if url.password is None else str(url.password)), url.host
