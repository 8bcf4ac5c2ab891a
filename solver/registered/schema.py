"""What forms need to know of the models that are registered on this machine."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from geoswarm.solver.errors import ProblemError
from geoswarm.solver.registered.declaration import Declaration, read_declaration
from geoswarm.solver.registered.folders import find_folder, registered_names
from geoswarm.solver.registered.settings import Setting

__all__ = ["registered_models", "section_schema"]


def registered_models() -> Iterator[tuple[str, Declaration]]:
    """Names and declarations of the models whose ``model.yaml`` can be read."""
    for name in registered_names():
        try:
            yield name, read_declaration(find_folder(name))
        except ProblemError:
            continue  # `geoswarm models list` reports it to the operator


def section_schema(name: str, declaration: Declaration) -> dict[str, Any]:
    """JSON schema of the section of a problem that names a model."""
    properties: dict[str, Any] = {"kind": {"const": "registered"}, "model": {"const": name}}
    if declaration.settings:
        settings = {key: setting_schema(setting) for key, setting in declaration.settings.items()}
        properties["settings"] = {"type": "object", "properties": settings, "additionalProperties": False}
    return {
        "type": "object",
        "description": declaration.description or declaration.title or name,
        "properties": properties,
        "required": ["kind", "model"],
        "additionalProperties": False,
    }


def setting_schema(setting: Setting) -> dict[str, Any]:
    """JSON schema of one setting."""
    schema: dict[str, Any] = {"default": setting.default}
    if setting.description:
        schema["description"] = setting.description
    if setting.type == "switch":
        return {"type": "boolean", **schema}
    if setting.type == "choice":
        return {"type": "string", "enum": list(setting.choices), **schema}
    if setting.type == "integer":
        schema["default"] = int(setting.default)
    limits = {"minimum": setting.lower, "maximum": setting.upper, "x-unit": setting.unit or None}
    return {"type": setting.type, **schema, **{key: value for key, value in limits.items() if value is not None}}
