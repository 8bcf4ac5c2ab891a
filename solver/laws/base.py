"""What a soil law declares: parameters, settings, state variables, initial state, and its stress update."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar, NamedTuple

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.terms import Term
from geoswarm.solver.parameter_info import ParameterInfo, outside_limits

if TYPE_CHECKING:
    from geoswarm.solver.laws.binary import StressUpdate

__all__ = ["Law", "Setting", "Soil", "StateTensor", "StateVariable", "StrengthPlaces", "mean_and_squared_q"]


@dataclass(frozen=True, slots=True)
class Setting:
    """A choice of a law that is not a parameter: one of ``choices``, or without them a number of at least ``lower``.

    A number may also be None, which its description explains.
    """

    name: str
    description: str
    default: str | float | None
    choices: tuple[str, ...] = ()
    unit: str = ""
    lower: float = 0.0


@dataclass(frozen=True, slots=True)
class StateVariable:
    """A number that a law keeps for each material point."""

    name: str
    symbol: str
    unit: str
    description: str


class StateTensor(NamedTuple):
    """A symmetric tensor among the state variables, which turns with the body: where its xx, yy, zz and xy stand.

    ``shear`` is what it keeps of a shear component: 1 (stress), 2 (engineering strain) or sqrt(2) (as MFront).
    """

    first: int
    shear: float


class StrengthPlaces(NamedTuple):
    """Where the constants of a law hold its Mohr-Coulomb strength; the tension cut-off may be inf."""

    cohesion: int
    sin_phi: int
    cos_phi: int
    sin_psi: int
    tension: int


class Law(ABC):
    """A soil law.

    Stress is compression positive, kPa, in the order of :mod:`geoswarm.solver.laws.binary`; yy is vertical.
    """

    kind: ClassVar[str]
    title: ClassVar[str]
    """In words, a noun."""

    parameters: ClassVar[tuple[ParameterInfo, ...]]
    derived: ClassVar[frozenset[str]] = frozenset()
    """Parameters that follow from others unless they are given; their default 0 stands for that."""

    instead_of_e0: ClassVar[frozenset[str]] = frozenset()
    """Parameters that give the void ratio before a test unless e0 does; their default stands for that."""

    terms: ClassVar[tuple[Term, ...]] = ()
    """What parameters are in the terms of laboratories."""

    settings: ClassVar[tuple[Setting, ...]] = ()
    state: ClassVar[tuple[StateVariable, ...]] = ()
    tensors: ClassVar[tuple[StateTensor, ...]] = ()
    """Which of these are tensors: finite elements with an updated mesh turn them with the body, as they turn stress."""

    update: ClassVar[StressUpdate]
    components: ClassVar[frozenset[int]] = frozenset({4, 6})
    """Numbers of stress components that the update takes: 6 for element tests, 4 for finite elements."""

    strength: ClassVar[StrengthPlaces | None] = None
    """A Mohr-Coulomb strength that finite elements may change in steps."""

    discrete: ClassVar[BoolArray | None] = None
    """Which state variables (s,) are flags or counters, of which a mean of several steps means nothing; None: none."""

    perfectly_plastic: ClassVar[bool] = False
    """Whether the tangent may lose all stiffness: finite elements then mix elastic stiffness into it."""

    @abstractmethod
    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Numbers that the update reads, shape (n,), from a value of every parameter and setting.

        Raises
        ------
        InfeasibleError
            The values do not fit together. Those outside their limits do not come here.
        """

    def contradiction(self, values: Mapping[str, float]) -> str | None:
        """What is inadmissible about parameters together, in words, or None; not all need to be there yet."""
        del values
        return None

    def incomplete(self, given: frozenset[str]) -> str | None:
        """What is missing among the parameters that follow from one another, in words, or None."""
        del given
        return None

    def inadmissible(self, values: Mapping[str, float]) -> str | None:
        """What is inadmissible about some of the parameters, in words, or None."""
        return outside_limits(self.parameters, values) or self.contradiction(values)

    @property
    def knows_K0(self) -> bool:
        """Whether :meth:`K0` gives a number."""
        return type(self).K0 is not Law.K0

    @property
    def depends_on_time(self) -> bool:
        """Whether the pace of a test matters; of laws that give a time scale."""
        return type(self).log_time_scale is not Law.log_time_scale

    def K0(self, constants: FloatArray) -> float | None:
        """Ratio of horizontal to vertical stress at rest; None: the law knows none."""
        del constants
        return None

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """State variables (..., s) of a soil that is placed under stresses (..., 4 or 6)."""
        del constants
        return np.zeros((*stress.shape[:-1], len(self.state)))

    def log_time_scale(self, stress: FloatArray, state: FloatArray, constants: FloatArray) -> FloatArray | None:
        """ln(theta/day), (...,), of the time theta in which a soil under these stresses slows down by half its rate.

        ``stress`` (..., 4 or 6), ``state`` (..., s). Time is stepped in ln(1 + t/theta); None: time has no effect.
        """
        del stress, state, constants
        return None

    @abstractmethod
    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """Bulk and shear modulus, kPa, at the mean stress p, kPa."""

    def state_weights(self, constants: FloatArray) -> FloatArray:
        """Strain that one unit of each state variable stands for, (s,), to judge errors; 0: it does not count."""
        del constants
        return np.zeros(len(self.state))

    def soil(self, given: Mapping[str, Any]) -> Soil:
        """A soil of this law; parameters and settings that are not given, or None, have their defaults.

        Raises
        ------
        InfeasibleError
            A parameter is missing, or what is given is inadmissible.
        """
        known = {info.name: info.default for info in self.parameters}
        numbers = {name: default if given.get(name) is None else float(given[name]) for name, default in known.items()}
        missing = [name for name, value in numbers.items() if value is None]
        if missing:
            raise InfeasibleError(f"{self.title} needs {missing[0]}, which is not given")
        values = {name: value for name, value in numbers.items() if value is not None}
        message = self.inadmissible(values)
        if message is not None:
            raise InfeasibleError(message)
        for one in self.settings:
            value = given.get(one.name)
            if not one.choices and value is not None and not value >= one.lower:
                raise InfeasibleError(f"{one.name} must be at least {one.lower:g}, got {value:g} {one.unit}")
        choices = {one.name: given.get(one.name, one.default) for one in self.settings}
        return Soil(self, self.constants({**values, **choices}))


@dataclass(frozen=True, eq=False)
class Soil:
    """A law with its constants."""

    law: Law
    constants: FloatArray


def mean_and_squared_q(stress: FloatArray) -> tuple[FloatArray, FloatArray]:
    """p and q^2 = 3/2 s:s, shapes (...), of stresses (..., 4 or 6): xx, yy, zz, xy, and in general yz, zx.

    >>> p, squared = mean_and_squared_q(np.array([50.0, 110.0, 50.0, 0.0]))
    >>> float(p), float(np.sqrt(squared))
    (70.0, 60.0)
    """
    p: FloatArray = stress[..., :3].mean(axis=-1)
    normal = ((stress[..., :3] - p[..., np.newaxis]) ** 2).sum(axis=-1)
    squared: FloatArray = 1.5 * normal + 3.0 * (stress[..., 3:] ** 2).sum(axis=-1)
    return p, squared
