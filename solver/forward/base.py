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
    from geoswarm.solver.index_properties import IndexProperties
    from geoswarm.solver.sketches.declared import Sketch
    from geoswarm.solver.user_laws.section import UserLawSection

__all__ = [
    "ForwardModel",
    "ForwardModelSpec",
    "ForwardRun",
    "NotedResponse",
    "ParameterInfo",
    "SeriesInfo",
    "TellsIncomplete",
    "TellsUnused",
    "in_unit",
]

ForwardRun: TypeAlias = Callable[[Mapping[str, float]], dict[str, FloatArray]]
"""Parameter values by name -> response of every prepared series at its prepared points, in base units.

Examples
--------
>>> import numpy as np
>>> import geoswarm as gs
>>> def run(values) -> dict[str, gs.FloatArray]:  # a ForwardRun
...     return {"y": values["a"] * np.array([1.0, 2.0])}
>>> run({"a": 3.0})["y"].tolist()
[3.0, 6.0]
"""


class NotedResponse(dict[str, FloatArray]):
    """What a :data:`ForwardRun` returns to attach a note to a successful run.

    ``note`` is stored with the evaluation, as its message.

    Examples
    --------
    >>> import numpy as np
    >>> import geoswarm as gs
    >>> found = gs.NotedResponse({"settlement": np.array([0.1])}, "two load steps were halved")
    >>> found.note, found["settlement"].tolist()
    ('two load steps were halved', [0.1])
    """

    def __init__(self, response: Mapping[str, FloatArray], note: str) -> None:
        super().__init__(response)
        self.note = note


@dataclass(frozen=True, slots=True)
class SeriesInfo:
    """One named output of a forward model: ``y`` over ``x``, both in base units (kN, m, day, degree).

    ``x_lower`` and ``x_upper`` bound the points at which it can be evaluated; ``x_integer``: only at whole numbers
    (stage numbers). ``x_increasing``: its observed points must be strictly increasing in x. ``x_names``: what
    1, 2, ... are called, where x only counts.

    Examples
    --------
    >>> import geoswarm as gs
    >>> info = gs.SeriesInfo("settlement", "settlement over time", "time", "day", "settlement", "m", x_lower=0.0)
    >>> info.name, info.y_unit
    ('settlement', 'm')
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
    x_names: tuple[str, ...] = ()

    def require(self, x: FloatArray) -> None:
        """Refuse points (m,) at which it cannot be evaluated.

        Raises
        ------
        ProblemError
            A point is outside the limits, or not a whole number where only these are accepted.
        """
        low = -math.inf if self.x_lower is None else self.x_lower
        high = math.inf if self.x_upper is None else self.x_upper
        wrong = ~((x >= low) & (x <= high))
        if self.x_integer:
            wrong |= x != np.round(x)
        if wrong.any():
            accepted = f"{'whole numbers ' if self.x_integer else ''}from {low:g} to {high:g}"
            unit = f" {self.x_unit}" if self.x_unit else ""
            raise ProblemError([Issue(self.name, f"x must be {accepted}{unit}, got {x[wrong][0]:g}{unit}")])


class ForwardModel(Protocol):
    """A calculation from parameter values to series. Immutable; safe to use from several threads.

    Examples
    --------
    >>> import numpy as np
    >>> import geoswarm as gs
    >>> class Spring:
    ...     open_parameters = False
    ...     parameters = (gs.ParameterInfo("k", "k", "kN/m", "stiffness", lower=0.0),)
    ...     series = (gs.SeriesInfo("force", "force over displacement", "displacement", "m", "force", "kN"),)
    ...
    ...     def grid(self, series):
    ...         return np.linspace(0.0, 0.1, 11)
    ...
    ...     def check(self, parameters):
    ...         return None
    ...
    ...     def prepare(self, points):
    ...         return lambda values: {"force": values["k"] * points["force"]}
    >>> run = Spring().prepare({"force": np.array([0.0, 0.1])})
    >>> run({"k": 50.0})["force"].tolist()
    [0.0, 5.0]
    """

    @property
    def parameters(self) -> tuple[ParameterInfo, ...]:
        """Parameters of the model, required ones (``default`` None) and optional ones."""

    @property
    def open_parameters(self) -> bool:
        """Whether the problem may declare parameters beyond :attr:`parameters` (a formula may)."""

    @property
    def series(self) -> tuple[SeriesInfo, ...]:
        """Series that the model can calculate."""

    def grid(self, series: str) -> FloatArray:
        """Points x, shape (n,), in base units, at which to show the whole curve of a series."""

    def check(self, parameters: Mapping[str, float]) -> str | None:
        """Why these parameter values are inadmissible; None if they are admissible.

        ``parameters`` may be a subset: problems check their fixed values in this way before anything runs.
        """

    def prepare(self, points: Mapping[str, FloatArray]) -> ForwardRun:
        """Build the calculation of the given series at the given x, each of shape (m_g,), base units.

        The returned function takes values of all required parameters and returns one finite or non-finite array of
        shape (m_g,) a series. It raises :class:`geoswarm.solver.errors.ForwardError` when the calculation fails.
        """


@runtime_checkable
class TellsUnused(Protocol):
    """A model that accepts any parameter and knows which ones it uses.

    Examples
    --------
    >>> import geoswarm as gs
    >>> class Program:
    ...     def unused(self, names):
    ...         return tuple(name for name in names if name not in ("E", "nu"))
    >>> isinstance(Program(), gs.TellsUnused), Program().unused(["E", "phi"])
    (True, ('phi',))
    """

    def unused(self, names: Collection[str]) -> tuple[str, ...]:
        """Return those of the given parameters that change nothing."""


@runtime_checkable
class TellsIncomplete(Protocol):
    """A model that needs one of several parameters, such as a void ratio or what it follows from.

    Examples
    --------
    >>> class Spring:
    ...     def incomplete(self, declared):
    ...         return None if len({"k", "compliance"} & set(declared)) == 1 else "give exactly one of k and compliance"
    >>> import geoswarm as gs
    >>> isinstance(Spring(), gs.TellsIncomplete), Spring().incomplete(["E"])
    (True, 'give exactly one of k and compliance')
    """

    def incomplete(self, declared: Collection[str]) -> str | None:
        """What is missing among the names of the parameters given, in words, or None."""


def in_unit(
    unit: str, lowest: float | None = None, highest: float | None = None, *, shown: bool = False
) -> dict[str, JsonValue]:
    """Metadata of a field for forms, in its JSON schema: ``x-unit``, and a usual range, ``x-typical``.

    For ``Field(json_schema_extra=...)``. ``shown``: forms always show the field, although it is optional.

    Examples
    --------
    >>> import geoswarm as gs
    >>> gs.in_unit("m", 0.01, 0.1)
    {'x-unit': 'm', 'x-typical': [0.01, 0.1]}
    """
    hint: dict[str, JsonValue] = {"x-unit": unit} | ({"x-shown": True} if shown else {})
    return hint if lowest is None or highest is None else hint | {"x-typical": [lowest, highest]}


class ForwardModelSpec(BaseModel, ABC):
    """Base of the ``forward_model`` sections; subclasses add ``kind: Literal[...]`` and their fields.

    Examples
    --------
    >>> from typing import Literal
    >>> import geoswarm as gs
    >>> class SpringSpec(gs.ForwardModelSpec):
    ...     kind: Literal["spring"] = "spring"
    ...     length: float
    ...
    ...     def build(self):
    ...         return Spring(self.length)  # a ForwardModel
    >>> SpringSpec(length=2.0).quick
    False
    """

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    depends_on_section: ClassVar[bool] = False
    """Whether parameters and series depend on the contents of a section, not only on its kind."""

    programs: ClassVar[bool] = False
    """Whether models of this kind run programs or code of the machine; a service neither offers nor accepts them."""

    series_need: ClassVar[Mapping[str, str]] = {}
    """Optional fields without which a section lacks series, by the end of their names."""

    consolidates: ClassVar[bool] = False
    """Whether the flow of pore water is calculated, so that the curves include primary consolidation."""

    kind: str

    @classmethod
    def example(cls) -> dict[str, Any] | None:
        """A section of this kind; the first of the ``examples`` of its JSON schema unless the kind gives another."""
        return next(iter(cls.model_json_schema().get("examples", [])), None)

    def remedy_for(self, series: str) -> str:
        """What would add a missing series to the section, as an ending of a message; '' if nothing does."""
        for end, field in self.series_need.items():
            if series.endswith(end) and vars(self)[field] is None:
                return f"; it needs {field}"
        return ""

    @property
    def assumptions(self) -> tuple[str, ...]:
        """Default assumptions of the section that a reader should know, in sentences with the remedy."""
        return ()

    @property
    def quick(self) -> bool:
        """Whether up to 200 runs may follow a short search: they take seconds on any machine.

        A property of the model, not a measured time: results must not depend on the speed of a machine.
        """
        return False

    @property
    def index_properties_of_soils(self) -> Mapping[str, IndexProperties | None]:
        """Index properties of each soil by the prefix of its parameters; {} if there is a single soil."""
        return {}

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
        """Whether it starts programs or calls libraries of this machine; problems from the network must not use it."""
        return self.programs or bool(self.user_laws)

    @property
    def only_here(self) -> bool:
        """Whether it can be calculated only in this process, because no other process has it."""
        return False

    @property
    def runs_outside(self) -> bool:
        """Whether a run calls a program or function of the user: runs are supervised, and none is made without
        asking."""
        return self.runs_programs

    def at_once(self, workers: int, machines: int = 1) -> int:
        """Return how many runs the given workers and machines can make at once; licences may limit them."""
        slots: int | None = getattr(self, "slots", None)
        return workers if slots is None else min(workers, slots * machines)

    def unavailable(self) -> str | None:
        """Why it cannot run on this machine although its section is valid, in words; None if it can."""
        return next((why for law in self.user_laws if (why := law.unavailable())), None)

    def require_available(self, path: str = "forward_model") -> None:
        """Refuse a model that cannot run on this machine.

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
        """A message or log of a run as users of a service may see it, without details of a machine that is not
        theirs."""
        return text

    def with_files(self, folder: Path | None, path: str) -> ForwardModelSpec:
        """Return the section with the contents of its files instead of their names.

        Parameters
        ----------
        folder
            Folder of relative paths; None if no file may be read (problems from the network).
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
        """Sketch for forms and reports: specimen or ground and the loading programme; None if there is none."""
        return None

    def by_part(self) -> Mapping[str, ForwardModelSpec]:
        """Sections of the parts by name; this one with an empty name where there are no parts."""
        return {"": self}

    def diagrams(self) -> tuple[Diagram, ...]:
        """Additional diagrams for reports: one series over another."""
        return ()

    @abstractmethod
    def build(self) -> ForwardModel:
        """Build the forward model that this section describes."""
