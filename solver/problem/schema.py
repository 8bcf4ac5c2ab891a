"""The JSON schema of the problem file, with the section of every installed forward model."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from contextlib import suppress
from functools import cache
from typing import Any

from pydantic import BaseModel

from geoswarm.solver.errors import BrokenForwardModelError
from geoswarm.solver.forward.registry import find_spec, kinds, offered_kinds
from geoswarm.solver.methods import registry as methods
from geoswarm.solver.problem.sections import ProblemFile

__all__ = ["problem_schema"]

_FORWARD_MODEL = "x-forward-model"
_Section = tuple[str, type[BaseModel]]


def problem_schema(*, programs: bool = False) -> dict[str, Any]:
    """JSON schema (draft 2020-12) of a problem. Forward models that cannot be loaded are left out.

    ``programs``: with those that run programs of the machine, which a service does not accept.
    """
    specs = tuple(_loaded(kinds() if programs else offered_kinds()))
    found: dict[str, Any] = json.loads(_text(specs, tuple(_methods_of_others())))
    return found


def _loaded(names: Iterable[str]) -> Iterator[_Section]:
    """Forward models that can be loaded."""
    for kind in names:
        with suppress(BrokenForwardModelError):
            yield kind, find_spec(kind)


def _methods_of_others() -> Iterator[_Section]:
    """Methods of other packages that can be loaded."""
    for kind in methods.kinds():
        if kind not in methods.BUILT_IN:
            with suppress(methods.UnknownMethodError):
                yield kind, methods.find_method(kind)


@cache
def _text(specs: tuple[_Section, ...], others: tuple[_Section, ...]) -> str:
    """The schema as JSON; it takes 0.1 s to make, and a form asks for it whenever it is opened."""
    schema = ProblemFile.model_json_schema()
    definitions = schema.setdefault("$defs", {})
    for kind, spec in specs:
        definitions |= _definitions(f"forward_model_{kind}", spec)
    definitions["forward_model"] = {"oneOf": [{"$ref": f"#/$defs/forward_model_{kind}"} for kind, _ in specs]}
    place = schema["properties"]["forward_model"]
    schema["properties"]["forward_model"] = {"$ref": "#/$defs/forward_model", "description": place["description"]}
    schema["required"] = ["parameters"]
    schema["anyOf"] = [{"required": ["forward_model", "observations"]}, {"required": ["tests"]}]
    choice = schema["properties"]["method"]
    for kind, section in others:
        definitions |= _definitions(f"method_{kind}", section)
        choice["oneOf"].append({"$ref": f"#/$defs/method_{kind}"})
        choice["discriminator"]["mapping"][kind] = f"#/$defs/method_{kind}"
    for name, definition in definitions.items():
        if name.startswith("forward_model_"):
            definitions[name] = _with_parts(definition)
    return json.dumps({"$schema": "https://json-schema.org/draft/2020-12/schema", **schema})


def _definitions(name: str, section: type[BaseModel]) -> dict[str, Any]:
    """A section and what it refers to, by names."""
    schema = section.model_json_schema()
    inner = schema.pop("$defs", {})
    found = {f"{name}_{key}": _renamed(value, name) for key, value in inner.items()}
    return found | {name: _renamed(schema, name) | {"required": ["kind", *schema.get("required", [])]}}


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
