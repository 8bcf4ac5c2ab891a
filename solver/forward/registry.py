"""Finds forward models by their kind: those of this package and those that other packages offer as entry points.

A package offers one by an entry point of the group ``geoswarm.forward_models`` whose name is the kind and whose object
is a subclass of :class:`geoswarm.solver.forward.base.ForwardModelSpec`. A kind is loaded only when it is used, so one
that is broken never harms the others.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Annotated, Any, LiteralString

from pydantic import BeforeValidator, SerializeAsAny, ValidationError, WithJsonSchema
from pydantic_core import InitErrorDetails, PydanticCustomError

from geoswarm.solver.errors import BrokenForwardModelError, SolverError, UnknownForwardModelError, in_words
from geoswarm.solver.forward.base import ForwardModel, ForwardModelSpec
from geoswarm.solver.laws import registry as laws
from geoswarm.solver.system.installed import Installed

if TYPE_CHECKING:
    from geoswarm.solver.sketches.drawing import DrawnSketch

__all__ = [
    "BUILT_IN",
    "GROUP",
    "PROGRAMS_REFUSED",
    "AnyForwardModelSpec",
    "built",
    "find_spec",
    "forget",
    "is_foreign",
    "kinds",
    "offered_kinds",
    "parse_spec",
    "read_foreign_sections",
    "sketches_of",
]

GROUP = "geoswarm.forward_models"
"""Entry point group."""

BUILT_IN = {
    "formula": "geoswarm.solver.forward.formula:FormulaSpec",
    "combined": "geoswarm.solver.forward.combined:CombinedSpec",
    "oedometer": "geoswarm.solver.forward.oedometer:OedometerSpec",
    "isotropic_compression": "geoswarm.solver.forward.isotropic_compression:IsotropicCompressionSpec",
    "triaxial": "geoswarm.solver.laboratory.shear.triaxial:TriaxialSpec",
    "crs_oedometer": "geoswarm.solver.laboratory.flow.crs:CrsOedometerSpec",
    "consolidation": "geoswarm.solver.laboratory.flow.consolidation:ConsolidationSpec",
    "direct_simple_shear": "geoswarm.solver.laboratory.shear.simple_shear:DirectSimpleShearSpec",
    "column": "geoswarm.solver.column.section:ColumnSpec",
    "section": "geoswarm.solver.forward.cross_section:SectionSpec",
    "finite_element": "geoswarm.solver.forward.finite_element:FiniteElementSpec",
    "command": "geoswarm.solver.forward.programs.command:CommandSpec",
    "python": "geoswarm.solver.forward.programs.python_function:PythonSpec",
    "umbridge": "geoswarm.solver.forward.programs.umbridge:UmbridgeSpec",
    "registered": "geoswarm.solver.registered.spec:RegisteredSpec",
}
"""Forward models of this package, as pyproject.toml declares them."""

PROGRAMS_REFUSED = (
    "starts or calls a program or library of the machine it runs on (kind: command, python or umbridge, or a material "
    "with law: umat); that is accepted from "
    "problem files and Python only (geoswarm run, geoswarm.calibrate)"
)
"""What a service answers to a forward model that runs programs."""


_MOST_SKETCHES = 12

log = logging.getLogger(__name__)

_foreign_reader: Callable[[Mapping[str, Any]], ForwardModelSpec] | None = None
_foreign_law_trial: Callable[[Mapping[str, Any]], str | None] | None = None

_installed: Installed[type[ForwardModelSpec]] = Installed(
    "forward model",
    GROUP,
    BUILT_IN,
    lambda: ForwardModelSpec,
    lambda found: found,
    "unknown kind '{kind}'{hint}; known kinds: {known}",
    UnknownForwardModelError,
    BrokenForwardModelError,
)


def kinds() -> tuple[str, ...]:
    """Kinds of forward model that are installed, loaded or not, the built-in ones first."""
    return _installed.kinds()


def offered_kinds() -> tuple[str, ...]:
    """Kinds that a service accepts from its users: those that run no programs of its machine, and broken ones."""
    return tuple(kind for kind in kinds() if not _runs_programs(kind))


def _runs_programs(kind: str) -> bool:
    try:
        return find_spec(kind).programs
    except BrokenForwardModelError:
        return False


def is_foreign(section: Any) -> bool:
    """Whether a ``forward_model`` section of a document, or a part of it, needs a forward model of another package."""
    if not isinstance(section, Mapping):
        return False
    parts = section.get("parts")
    inner = parts.values() if section.get("kind") == "combined" and isinstance(parts, Mapping) else ()
    return section.get("kind") not in BUILT_IN or any(is_foreign(part) for part in inner)


def built(spec: ForwardModelSpec) -> ForwardModel:
    """Build the forward model of a section.

    Raises
    ------
    BrokenForwardModelError
        When the code of another package raises what is no error in the section.
    ProblemError, SolverError, ValueError
        When the section is wrong.
    """
    try:
        return spec.build()
    except (SolverError, ValueError):
        raise
    except Exception as error:  # anybody's code; a fault of our own is shown as one
        if spec.kind in BUILT_IN:
            raise
        raise BrokenForwardModelError(
            f"forward model '{spec.kind}' cannot be built: it raised {in_words(error)}"
        ) from None


def sketches_of(spec: ForwardModelSpec) -> dict[str, DrawnSketch]:
    """The sketches of a section by the name of a part (empty where there are no parts), 12 at most.

    A part of another package whose sketch cannot be drawn has none, and the log says why.
    """
    from geoswarm.solver.sketches.drawing import DrawnSketch, drawings

    found: dict[str, DrawnSketch] = {}
    for name, part in spec.by_part().items():
        try:
            sketch = part.sketch()
            if sketch is not None:
                found[name] = DrawnSketch(sketch, drawings(sketch))
        except Exception as error:  # anybody's code; a fault of our own is shown as one
            if part.kind in BUILT_IN:
                raise
            log.warning("forward model '%s' has no sketch: it raised %s", part.kind, in_words(error))
        if len(found) == _MOST_SKETCHES:
            break
    return found


def find_spec(kind: str) -> type[ForwardModelSpec]:
    """Find the class that describes the ``forward_model`` section of a kind.

    Raises
    ------
    UnknownForwardModelError
        No such kind is installed; the message lists the known ones.
    BrokenForwardModelError
        The entry point cannot be imported or is no :class:`ForwardModelSpec`.
    """
    return _installed.find(kind)


def forget() -> None:
    """Search for installed forward models again on the next use, for example after a package was installed."""
    _installed.forget()


def read_foreign_sections(
    reader: Callable[[Mapping[str, Any]], ForwardModelSpec] | None,
    trial: Callable[[Mapping[str, Any]], str | None] | None = None,
) -> None:
    """Have sections of models of other packages read by a function from now on; None: their classes are imported.

    ``trial`` says what is against reading a section with a law of another package.
    """
    global _foreign_reader, _foreign_law_trial
    _foreign_reader, _foreign_law_trial = reader, trial


def _has_foreign_law(value: Any) -> bool:
    """Whether a section, or what is in it, names a law of another package."""
    if isinstance(value, str):
        return value not in laws.BUILT_IN and value in laws.kinds()
    inner = value.values() if isinstance(value, Mapping) else value if isinstance(value, list | tuple) else ()
    return any(map(_has_foreign_law, inner))


def parse_spec(section: Any) -> ForwardModelSpec:
    """Validate a ``forward_model`` section by the class of its kind, strictly: no text or truth value as a number.

    Raises
    ------
    pydantic.ValidationError
        The kind is missing, unknown or broken, or the section does not fit its kind.
    """
    if isinstance(section, ForwardModelSpec):
        return section
    if not isinstance(section, Mapping):
        raise _refused((), "a forward model is a mapping with a kind; known kinds: {known}", section, _known())
    kind = section.get("kind")
    if _foreign_reader is not None and kind not in BUILT_IN and kind in kinds():
        return _foreign_reader(section)
    if _foreign_law_trial is not None and kind != "combined" and _has_foreign_law(section):
        why = _foreign_law_trial(section)
        if why is not None:
            raise _refused((), "with its law the forward model {why}", kind, {"why": why})
    if not isinstance(kind, str):
        raise _refused(("kind",), "give the kind of forward model as text; known kinds: {known}", kind, _known())
    try:
        spec = find_spec(kind)
    except (UnknownForwardModelError, BrokenForwardModelError) as error:
        raise _refused(("kind",), "{reason}", kind, {"reason": str(error)}) from error
    # Through JSON because strict validation of Python objects would refuse a list where a tuple is meant.
    return spec.model_validate_json(json.dumps(dict(section)), strict=True)


def _known() -> dict[str, str]:
    return {"known": ", ".join(kinds())}


def _refused(place: tuple[str, ...], message: LiteralString, value: Any, context: dict[str, str]) -> ValidationError:
    detail = InitErrorDetails(type=PydanticCustomError("forward_model", message, context), loc=place, input=value)
    return ValidationError.from_exception_data("forward_model", [detail])


AnyForwardModelSpec = Annotated[
    SerializeAsAny[ForwardModelSpec],
    BeforeValidator(parse_spec),
    WithJsonSchema(
        {"type": "object", "properties": {"kind": {"type": "string"}}, "required": ["kind"], "x-forward-model": True}
    ),
]
"""Field type: the ``forward_model`` section of any installed kind."""
