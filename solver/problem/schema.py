"""The JSON schema of the problem file, with the section of every installed forward model."""

from __future__ import annotations

from typing import Any

from geoswarm.solver.errors import BrokenForwardModelError
from geoswarm.solver.forward.registry import find_spec, kinds, offered_kinds
from geoswarm.solver.methods import registry as methods
from geoswarm.solver.problem.sections import ProblemFile

__all__ = ["problem_schema"]

_FORWARD_MODEL = "x-forward-model"


def problem_schema(*, programs: bool = False) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a problem. Forward models that cannot be loaded are left out.

    ``programs``: with those that run programs of the machine, which a service does not accept.
    """
    schema = ProblemFile.model_json_schema()
    definitions = schema.setdefault("$defs", {})
    choices = []
    for kind in kinds() if programs else offered_kinds():
        try:
            section = find_spec(kind).model_json_schema()
        except BrokenForwardModelError:
            continue
        name = f"forward_model_{kind}"
        inner = section.pop("$defs", {})
        definitions |= {f"{name}_{key}": _renamed(value, name) for key, value in inner.items()}
        definitions[name] = _renamed(section, name) | {"required": ["kind", *section.get("required", [])]}
        choices.append({"$ref": f"#/$defs/{name}"})
    definitions["forward_model"] = {"oneOf": choices}
    place = schema["properties"]["forward_model"]
    schema["properties"]["forward_model"] = {"$ref": "#/$defs/forward_model", "description": place["description"]}
    _add_methods(schema, definitions)
    for name, definition in definitions.items():
        if name.startswith("forward_model_"):
            definitions[name] = _with_parts(definition)
    return {"$schema": "https://json-schema.org/draft/2020-12/schema", **schema}


def _add_methods(schema: dict[str, Any], definitions: dict[str, Any]) -> None:
    """Add the methods of other packages to the choice of the section ``method``; those that cannot be loaded not."""
    choice = schema["properties"]["method"]
    for kind in methods.kinds():
        if kind in methods.BUILT_IN:
            continue
        try:
            section = methods.find_method(kind).model_json_schema()
        except methods.UnknownMethodError:
            continue
        name = f"method_{kind}"
        inner = section.pop("$defs", {})
        definitions |= {f"{name}_{key}": _renamed(value, name) for key, value in inner.items()}
        definitions[name] = _renamed(section, name) | {"required": ["kind", *section.get("required", [])]}
        choice["oneOf"].append({"$ref": f"#/$defs/{name}"})
        choice["discriminator"]["mapping"][kind] = f"#/$defs/{name}"


def _renamed(value: Any, prefix: str) -> Any:
    """References to a section's own definitions, which get a prefix so that two sections may use one name."""
    if isinstance(value, dict):
        return {
            key: inner.replace("#/$defs/", f"#/$defs/{prefix}_") if key == "$ref" else _renamed(inner, prefix)
            for key, inner in value.items()
        }
    return [_renamed(inner, prefix) for inner in value] if isinstance(value, list) else value


def _with_parts(value: Any) -> Any:
    """Forward models inside forward models refer to the same choice."""
    if isinstance(value, dict):
        if value.get(_FORWARD_MODEL):
            return {"$ref": "#/$defs/forward_model"}
        return {key: _with_parts(inner) for key, inner in value.items()}
    return [_with_parts(inner) for inner in value] if isinstance(value, list) else value
