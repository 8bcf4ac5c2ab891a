"""Several forward models calibrated at once, such as an oedometer and an isotropic compression test of one soil.

::

    forward_model:
      kind: combined
      parts:
        oedometer: {kind: oedometer, ...}
        isotropic: {kind: isotropic_compression, ...}

The series of a part are named ``part.series``. The parts share parameters by name: ``lambda_star`` is one value for
all. A parameter ``part.name`` is the value for that part alone and goes before the shared one.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal

from pydantic import Field, field_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import ForwardError, Issue, ProblemError, message_of
from geoswarm.solver.forward.base import (
    ForwardModel,
    ForwardModelSpec,
    ForwardRun,
    ParameterInfo,
    SeriesInfo,
    TellsIncomplete,
)
from geoswarm.solver.forward.registry import AnyForwardModelSpec, built, find_spec
from geoswarm.solver.words import listed

if TYPE_CHECKING:
    from geoswarm.solver.user_laws.section import UserLawSection

__all__ = ["CombinedModel", "CombinedRun", "CombinedSpec", "ModelPart", "parts_of"]


class CombinedSpec(ForwardModelSpec):
    """Several forward models that share parameters."""

    depends_on_section: ClassVar[bool] = True

    kind: Literal["combined"] = "combined"
    parts: dict[Annotated[str, Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=100)], AnyForwardModelSpec] = (
        Field(min_length=1, max_length=100, description="forward models by a name of your choice")
    )

    @field_validator("parts")
    @classmethod
    def _not_nested(cls, parts: dict[str, ForwardModelSpec]) -> dict[str, ForwardModelSpec]:
        nested = [name for name, part in parts.items() if isinstance(part, CombinedSpec)]
        if nested:
            raise PydanticCustomError(
                "nested", "part {part} is itself combined; list its parts here", {"part": nested[0]}
            )
        return parts

    @classmethod
    def example(cls) -> dict[str, Any]:
        """Two laboratory tests."""
        kinds = {"oedometer": "oedometer", "isotropic": "isotropic_compression"}
        return {"kind": "combined", "parts": {name: find_spec(kind).example() for name, kind in kinds.items()}}

    def remedy_for(self, series: str) -> str:
        """What would give a series in its part."""
        part, _, name = series.partition(".")
        return self.parts[part].remedy_for(name) if part in self.parts else ""

    def with_files(self, folder: Path | None, path: str) -> CombinedSpec:
        """The parts with the contents of their files."""
        parts = {name: part.with_files(folder, f"{path}.parts.{name}") for name, part in self.parts.items()}
        unchanged = all(parts[name] is part for name, part in self.parts.items())
        return self if unchanged else self.model_copy(update={"parts": parts})

    @property
    def quick(self) -> bool:
        """When all parts are."""
        return all(part.quick for part in self.parts.values())

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Those of all parts, each once with the parts that make it."""
        parts: dict[str, list[str]] = {}
        for name, part in self.parts.items():
            for sentence in part.assumptions:
                parts.setdefault(sentence, []).append(name)
        return tuple(f"{listed(names)}: {sentence}" for sentence, names in parts.items())

    @property
    def kernels(self) -> frozenset[str]:
        """Those of all parts."""
        return frozenset().union(*(part.kernels for part in self.parts.values()))

    @property
    def user_laws(self) -> tuple[UserLawSection, ...]:
        """Those of all parts."""
        return tuple(law for part in self.parts.values() for law in part.user_laws)

    @property
    def runs_programs(self) -> bool:
        """When a part does."""
        return any(part.runs_programs for part in self.parts.values())

    @property
    def runs_outside(self) -> bool:
        """When those of a part are."""
        return any(part.runs_outside for part in self.parts.values())

    def unavailable(self) -> str | None:
        """Why a part cannot be run here."""
        return next((why for part in self.parts.values() if (why := part.unavailable())), None)

    def shown(self, text: str) -> str:
        """As users of all parts may see it."""
        for part in self.parts.values():
            text = part.shown(text)
        return text

    @property
    def only_here(self) -> bool:
        """When a part can."""
        return any(part.only_here for part in self.parts.values())

    def by_part(self) -> Mapping[str, ForwardModelSpec]:
        """The parts."""
        return self.parts

    def build(self) -> CombinedModel:
        """Build the forward models of all parts."""
        return CombinedModel({name: built(spec) for name, spec in self.parts.items()})


@dataclass(frozen=True, slots=True)
class _Part:
    name: str
    model: ForwardModel
    own_names: tuple[tuple[str, str], ...]  # (shared name, name for this part alone)

    def values(self, parameters: Mapping[str, float]) -> dict[str, float]:
        values = dict(parameters) if self.model.open_parameters else {}
        for shared, own in self.own_names:
            if own in parameters:
                values[shared] = parameters[own]
            elif shared in parameters:
                values[shared] = parameters[shared]
        return values


class CombinedModel:
    """Runs its parts one after the other with one set of parameters."""

    def __init__(self, models: Mapping[str, ForwardModel]) -> None:
        self._parts = {
            name: _Part(name, model, tuple((info.name, f"{name}.{info.name}") for info in model.parameters))
            for name, model in models.items()
        }
        self._shared = _shared_parameters(self._parts.values())

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Shared parameters, then those of a single part; :meth:`missing` names those that a problem lacks."""
        own = (
            replace(info, name=own_name, description=f"{info.description.removesuffix('.')}, in {part.name} only.")
            for part in self._parts.values()
            for info, (_, own_name) in zip(part.model.parameters, part.own_names, strict=True)
        )
        return (*self._shared, *own)

    @property
    def part_names(self) -> tuple[str, ...]:
        """Names of the parts."""
        return tuple(self._parts)

    def part(self, name: str) -> ForwardModel:
        """The model of a part."""
        return self._parts[name].model

    def part_values(self, name: str, parameters: Mapping[str, float]) -> dict[str, float]:
        """Parameters of a part under the names that its model knows."""
        return self._parts[name].values(parameters)

    @property
    def open_parameters(self) -> bool:
        """Whether a part is open."""
        return any(part.model.open_parameters for part in self._parts.values())

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Series of all parts, named ``part.series``."""
        return tuple(
            replace(info, name=f"{part.name}.{info.name}")
            for part in self._parts.values()
            for info in part.model.series
        )

    def missing(self, declared: Collection[str]) -> list[ParameterInfo]:
        """Shared parameters that some part needs but that are declared neither for all nor for that part."""
        needed = {
            shared: None
            for part in self._parts.values()
            for info, (shared, own) in zip(part.model.parameters, part.own_names, strict=True)
            if info.default is None and own not in declared and not info.is_among(declared)
        }
        return [info for info in self._shared if info.name in needed]

    def incomplete(self, declared: Collection[str]) -> str | None:
        """What parts lack among the parameters given, with their names."""
        faults: dict[str, list[str]] = {}
        for part in self._parts.values():
            if isinstance(part.model, TellsIncomplete):
                own = {shared for shared, name in part.own_names if shared in declared or name in declared}
                if (fault := part.model.incomplete(own)) is not None:
                    faults.setdefault(fault, []).append(part.name)
        return "; ".join(f"{listed(parts)}: {fault}" for fault, parts in faults.items()) or None

    def grid(self, series: str) -> FloatArray:
        """Points x, shape (n,), at which to show the whole curve of ``part.series``."""
        part, _, name = series.partition(".")
        return self._parts[part].model.grid(name)

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about these values, with the part that refuses them, or None."""
        for part in self._parts.values():
            message = part.model.check(part.values(parameters))
            if message is not None:
                return f"{part.name}: {message}"
        return None

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculations of all parts that have points; x of shape (m_g,) in base units.

        Raises
        ------
        ProblemError
            A part cannot be prepared for its points; paths lead to that part.
        """
        by_part: dict[str, dict[str, FloatArray]] = {}
        for series, x in points.items():
            part, _, name = series.partition(".")
            by_part.setdefault(part, {})[name] = x
        return CombinedRun(
            {
                name: _part_run(self._parts[name], _prepared(self._parts[name], wanted))
                for name, wanted in by_part.items()
            }
        )


class CombinedRun:
    """The calculations of the parts, one after the other; the first that fails ends all.

    Parameters
    ----------
    parts
        By name; each gives its series as ``part.series``.
    """

    def __init__(self, parts: Mapping[str, ForwardRun]) -> None:
        self.parts = parts

    def __call__(self, parameters: Mapping[str, float]) -> dict[str, FloatArray]:
        """Run all parts with parameters of the whole."""
        found: dict[str, FloatArray] = {}
        for calculate in self.parts.values():
            found |= calculate(parameters)
        return found


@dataclass(frozen=True, slots=True)
class ModelPart:
    """One of the models of a section: its name (empty where it is the only one), section, and forward model.

    ``values``: parameters of the part, under the names that its model knows, from those of the whole.
    """

    name: str
    spec: ForwardModelSpec
    model: ForwardModel
    values: Callable[[Mapping[str, float]], Mapping[str, float]]


def parts_of(spec: ForwardModelSpec, model: ForwardModel) -> tuple[ModelPart, ...]:
    """The parts of a combined model, or the model as the only part."""
    if not isinstance(model, CombinedModel):
        return (ModelPart("", spec, model, dict),)
    return tuple(
        ModelPart(name, part, model.part(name), partial(model.part_values, name))
        for name, part in spec.by_part().items()
    )


def _of_part(name: str, error: ForwardError) -> ForwardError:
    """The failure of a part, with its name and its reason."""
    named = ForwardError(f"{name}: {message_of(error)}")
    named.reason = error.reason
    return named


def _part_run(part: _Part, calculate: ForwardRun) -> ForwardRun:
    """The calculation of a part with the parameters and the names of the whole."""

    def run(parameters: Mapping[str, float]) -> dict[str, FloatArray]:
        try:
            responses = calculate(part.values(parameters))
        except ForwardError as error:
            raise _of_part(part.name, error) from error
        return {f"{part.name}.{name}": response for name, response in responses.items()}

    return run


def _prepared(part: _Part, points: Mapping[str, FloatArray]) -> ForwardRun:
    try:
        return part.model.prepare(points)
    except ProblemError as error:
        place = f"forward_model.parts.{part.name}"
        issues = [
            Issue(f"{place}.{issue.path.removeprefix('forward_model.')}", issue.message) for issue in error.issues
        ]
        raise ProblemError(issues) from error


def _shared_parameters(parts: Collection[_Part]) -> tuple[ParameterInfo, ...]:
    shared: dict[str, ParameterInfo] = {}
    for part in parts:
        for info in part.model.parameters:
            known = shared.get(info.name)
            shared[info.name] = info if known is None else _narrower(known, info)
    return tuple(shared.values())


def _narrower(first: ParameterInfo, second: ParameterInfo) -> ParameterInfo:
    """The description of a shared parameter: required if any part requires it, admissible if all parts admit it."""
    lower, lower_open = max(
        (-float("inf") if info.lower is None else info.lower, info.lower_open) for info in (first, second)
    )
    upper, upper_open = min(
        (float("inf") if info.upper is None else info.upper, not info.upper_open) for info in (first, second)
    )
    return replace(
        first,
        default=None if second.default is None else first.default,
        lower=None if lower == -float("inf") else lower,
        lower_open=lower_open,
        upper=None if upper == float("inf") else upper,
        upper_open=not upper_open,
    )
