"""A law of a soil in a forward model: an installed one by its name, or the section of one in a library."""

from __future__ import annotations

import json
from collections.abc import Mapping
from importlib import import_module
from typing import TYPE_CHECKING, Annotated, Any, TypeAlias

from pydantic import BeforeValidator, SerializeAsAny, WithJsonSchema

from geoswarm.solver.laws.registry import USER_LAWS, UnknownLawError, find_law, kinds
from geoswarm.solver.user_laws.section import UserLawSection
from geoswarm.solver.words import did_you_mean

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["SECTIONS", "LawChoice", "law_of"]

SECTIONS = {
    "umat": "geoswarm.solver.user_laws.umat:UmatSection",
    "mfront": "geoswarm.solver.user_laws.mfront:MfrontSection",
}
"""Where the sections of laws in libraries are, by kind; they bring Numba, for which a check need not wait."""

assert SECTIONS.keys() == USER_LAWS.keys()


def _parse(value: Any) -> Any:
    """Check the name of a law, or its section, strictly."""
    if isinstance(value, UserLawSection):
        return value
    if isinstance(value, Mapping):
        law = value.get("law")
        section = _section(law) if isinstance(law, str) else None
        if section is None:
            known = ", ".join(SECTIONS)
            hint = did_you_mean(law, SECTIONS) if isinstance(law, str) else ""
            raise ValueError(f"law must be one of {known} in a section of a material{hint}; others by their name")
        _refuse_unknown(section, value)
        return section.model_validate_json(json.dumps(dict(value)), strict=True)
    if isinstance(value, str):
        if value in SECTIONS:
            raise ValueError(f"law {value} needs a section: {{law: {value}, library: libsand.so, ...}}")
        try:
            find_law(value)
        except UnknownLawError as error:
            raise ValueError(str(error)) from error
    return value


def _section(kind: str) -> type[UserLawSection] | None:
    """The section of laws of a kind in libraries, if there is one."""
    if kind not in SECTIONS:
        return None
    module, _, name = SECTIONS[kind].partition(":")
    found: type[UserLawSection] = getattr(import_module(module), name)
    return found


def _refuse_unknown(section: type[UserLawSection], given: Mapping[str, Any]) -> None:
    """Refuse unknown keys here: the schema, which names the known ones elsewhere, has no such sections."""
    known = [name for name in section.model_fields if name not in ("folder", "version", "read")]
    for name in given:
        if name not in section.model_fields:
            hint = did_you_mean(str(name), known)
            raise ValueError(f"{str(name)[:60]} is an unknown key{hint}; accepted: {', '.join(known)}")


LawChoice: TypeAlias = Annotated[
    str | SerializeAsAny[UserLawSection],
    BeforeValidator(_parse),
    # Forms and services know the names alone: a library is never named over the network.
    WithJsonSchema({"type": "string", "enum": list(kinds())}),
]
"""Field type: the name of an installed law, or a section of :data:`SECTIONS`."""


def law_of(choice: str | UserLawSection) -> Law:
    """Return the law that was chosen."""
    return find_law(choice) if isinstance(choice, str) else choice.made
