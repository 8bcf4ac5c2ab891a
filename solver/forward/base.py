"""The protocol that every forward model speaks."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeAlias, runtime_checkable

import numpy as np
from pydantic import BaseModel, ConfigDict, JsonValue

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import Issue, ProblemError
from geoswarm.solver.parameter_info import ParameterInfo

if TYPE_CHECKING:
    from geoswarm.solver.forward.diagram import Diagram
    from geoswarm.solver.sketches.declared import Sketch
    from geoswarm.solver.user_laws.section import UserLawSection

__all__ = [
    "ForwardModel",
    "ForwardModelSpec",
    "ForwardRun",
    "NotedResponse",
    "ParameterInfo",
    "SeriesInfo",
    "TellsUnused",
    "in_unit",
]

ForwardRun: TypeAlias = Callable[[Mapping[str, float]], dict[str, FloatArray]]
"""Parameter values by name -> response of every prepared series at its prepared points, in base units."""


class NotedResponse(dict[str, FloatArray]):
    """What a :data:`ForwardRun` returns when something is to be said of a run that succeeded.

    ``note`` is stored with the evaluation, as its message.
    """

    def __init__(self, response: Mapping[str, FloatArray], note: str) -> None:
        super().__init__(response)
        self.note = note


@dataclass(frozen=True, slots=True)
class SeriesInfo:
    """One named output of a forward model: ``y`` over ``x``, both in base units (kN, m, day, degree).

    ``x_lower`` and ``x_upper`` bound the points at which it can be asked for; ``x_integer``: only at whole numbers
    (stage numbers). ``x_increasing``: its observed points must be strictly increasing in x.
    """

    name: str
    description: str
    x_quantity: str
    x_unit: str
    y_quantity: str
    y_unit: str
    x_lower: float | None = None
    x_upper: float | None = None
    x_integer: bool = False
    x_increasing: bool = True

    def require(self, x: FloatArray) -> None:
        """Refuse points (m,) that it cannot be asked for.

        Raises
        ------
        ProblemError
            One is outside the limits, or no whole number where only these are accepted.
        """
        low = -math.inf if self.x_lower is None else self.x_lower
        high = math.inf if self.x_upper is None else self.x_upper
        wrong = ~((x >= low) & (x <= high))
        if self.x_integer:
            wrong |= x != np.round(x)
        if wrong.any():
            accepted = f"{'whole numbers ' if self.x_integer else ''}from {low:g} to {high:g}"
            unit = f" {self.x_unit}" if self.x_unit else ""
            raise ProblemError([Issue(self.name, f"x = {x[wrong][0]:g}{unit}: {accepted}{unit} are accepted")])


class ForwardModel(Protocol):
    """A calculation from parameter values to series. Immutable; safe to use from several threads."""

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters that the model knows, required ones (``default`` None) and optional ones."""

    @property
    def open_parameters(self) -> bool:
        """Whether the problem may declare parameters beyond :attr:`parameters` (a formula may)."""

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Series that the model can calculate."""

    def grid(self, series: str) -> FloatArray:
        """Points x, shape (n,), in base units, at which to show the whole curve of a series."""

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """What is inadmissible about these parameter values, or None.

        ``parameters`` may be a subset: problems use it to judge the fixed values before anything runs.
        """

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of the given series at the given x, each of shape (m_g,), base units.

        The returned function takes values of all required parameters and returns one finite or non-finite array of
        shape (m_g,) a series. It raises :class:`geoswarm.solver.errors.ForwardError` when the calculation fails.
        """


@runtime_checkable
class TellsUnused(Protocol):
    """A model that takes any parameter, and knows which of them reach it."""

    def unused(self, names: Collection[str]) -> tuple[str, ...]:
        """Those of some parameters that change nothing."""


def in_unit(
    unit: str, lowest: float | None = None, highest: float | None = None, *, shown: bool = False
) -> dict[str, JsonValue]:
    """What a field's JSON schema tells forms beside its description: ``x-unit`` and a usual range, ``x-typical``.

    For ``Field(json_schema_extra=...)``. ``shown``: the field is seen at once though it may be left out.
    """
    hint: dict[str, JsonValue] = {"x-unit": unit} | ({"x-shown": True} if shown else {})
    return hint if lowest is None or highest is None else hint | {"x-typical": [lowest, highest]}


class ForwardModelSpec(BaseModel, ABC):
    """Base of the ``forward_model`` sections; subclasses add ``kind: Literal[...]`` and their fields."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    depends_on_section: ClassVar[bool] = False
    """Whether parameters and series follow from what a section says, beyond its kind."""

    programs: ClassVar[bool] = False
    """Whether models of this kind run programs or code of the machine: the service neither offers nor accepts it."""

    consolidates: ClassVar[bool] = False
    """Whether the flow of pore water is calculated, so that primary consolidation is in its curves."""

    kind: str

    @classmethod
    def example(cls) -> dict[str, Any] | None:
        """A section of this kind; the first of the ``examples`` of its JSON schema unless the kind gives another."""
        return next(iter(cls.model_json_schema().get("examples", [])), None)

    @property
    def quick(self) -> bool:
        """Whether a report may make some hundred further runs unasked: they take seconds on any machine.

        A property of the model, not a time that is measured: what is said must not hang on the speed of a machine.
        """
        return False

    @property
    def kernels(self) -> frozenset[str]:
        """Compiled kernels that it needs: samples of :mod:`geoswarm.solver.warm` that use them, and kinds of laws."""
        return frozenset()

    @property
    def user_laws(self) -> tuple[UserLawSection, ...]:
        """Sections of soil laws in libraries of this machine."""
        return ()

    @property
    def runs_programs(self) -> bool:
        """Whether it starts programs or calls libraries of this machine: no problem from the network may have it."""
        return self.programs or bool(self.user_laws)

    @property
    def only_here(self) -> bool:
        """Whether it can be calculated in this very process alone: no other process knows it."""
        return False

    @property
    def runs_outside(self) -> bool:
        """Whether a run is one of the user's programs or functions: it is watched, and none is made unasked."""
        return self.runs_programs

    def unavailable(self) -> str | None:
        """Why it cannot be run on this machine though its section is sound, in words; None: it can."""
        return next((why for law in self.user_laws if (why := law.unavailable())), None)

    def require_available(self, path: str = "forward_model") -> None:
        """Refuse what cannot be run on this machine.

        Parameters
        ----------
        path
            Of this section in the problem, for the message.

        Raises
        ------
        ProblemError
            It says why.
        """
        if why := self.unavailable():
            raise ProblemError([Issue(path, why)])

    def shown(self, text: str) -> str:
        """A message or log of a run as users of a service may see it: it may tell of a machine that is not theirs."""
        return text

    def with_files(self, folder: Path | None, path: str) -> ForwardModelSpec:
        """The same section with the contents of the files that it names in place of their names.

        Parameters
        ----------
        folder
            Where relative files lie; None when no file may be read (problems that came over the network).
        path
            Of this section in the problem, for messages.

        Raises
        ------
        ProblemError
            A file cannot be used; each issue has its path.
        """
        del folder, path
        return self

    def sketch(self) -> Sketch | None:
        """What a form and a report draw of it: specimen or ground and the loading programme; None: nothing."""
        return None

    def by_part(self) -> Mapping[str, ForwardModelSpec]:
        """Sections of the parts by name; this one with an empty name where there are no parts."""
        return {"": self}

    def diagrams(self) -> tuple[Diagram, ...]:
        """What reports draw beside each series over its own axis: one series over another."""
        return ()

    @abstractmethod
    def build(self) -> ForwardModel:
        """Build the forward model that this section describes."""
