"""Which extra of this distribution brings a missing package, and the message for the user.

The table of extras is the one in the metadata of the installed distribution, so a new extra, or a package that moves
from one to another, needs no second list.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from importlib.util import find_spec

__all__ = ["extra_of", "has", "needs_extra"]

_REQUIREMENT = re.compile(r"""(?P<name>[\w.-]+).*;.*\bextra\s*==\s*["'](?P<extra>[\w.-]+)["']""")


def has(module: str) -> bool:
    """Whether a module of an extra is installed; it is not imported."""
    try:
        return find_spec(module) is not None
    except ValueError:  # a module without a spec replaces it
        return True


def needs_extra(what: str, module: str) -> str:
    """Say that ``what`` needs the extra that brings ``module``, and how to install it.

    >>> needs_extra("geoswarm serve", "sqlalchemy")
    "geoswarm serve needs the extra server: pip install 'geoswarm[server]'"
    """
    extra = extra_of(module)
    if extra is None:
        return f"{what} needs the package {_top(module)}: pip install {_top(module)}"
    return f"{what} needs the extra {extra}: pip install 'geoswarm[{extra}]'"


def extra_of(module: str) -> str | None:
    """Return the extra that brings a module; None for a module of no extra. Of several extras the smallest is meant."""
    wanted = _normal(_top(module))
    extras: dict[str, list[str]] = {}
    for extra, name in _requirements():
        extras.setdefault(extra, []).append(_normal(name))
    # A distribution may be a part of the package that it names: opentelemetry-sdk brings opentelemetry.sdk.
    found = [
        extra
        for extra, names in extras.items()
        if any(name == wanted or name.startswith(f"{wanted}-") for name in names)
    ]
    return min(found, key=lambda extra: (len(extras[extra]), extra), default=None)


def _requirements() -> Iterator[tuple[str, str]]:
    """Give extra and distribution of every requirement that an extra makes."""
    from importlib.metadata import (
        PackageNotFoundError,
        requires,
    )  # slow to import, and needed when something is missing

    try:
        lines = requires("geoswarm") or []
    except PackageNotFoundError:  # a checkout that is not installed
        return
    for line in lines:
        if match := _REQUIREMENT.match(line):
            yield match["extra"], match["name"]


def _top(module: str) -> str:
    return module.partition(".")[0]


def _normal(name: str) -> str:
    return re.sub(r"[-_.]+", "-", name).lower()
