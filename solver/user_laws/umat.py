"""``law: umat``: a compiled Abaqus user routine as a soil law.

::

    material:
      law: umat
      library: libsand.so
      parameters: {E: {unit: kPa, lower: 0}, nu: {lower: 0, upper: 0.49}, phi: {unit: degree}, OCR: {default: 1}}
      props: [E, nu, "phi * pi / 180", 0]
      state:
        - {name: pc, unit: kPa, initial: "OCR * p"}
        - {name: yields, discrete: true}
      limit: yields
      K0: 1 - sin(phi * pi / 180)
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import lru_cache
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Final, Literal, Self

import numpy as np
from pydantic import Field, model_validator

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.laws.base import StateTensor, StateVariable
from geoswarm.solver.laws.binary import NumbaUpdate
from geoswarm.solver.laws.libraries.umat_bridge import BESIDE, NAME_LENGTH, PLACES, TROUBLES, umat_update
from geoswarm.solver.section import Name, Section
from geoswarm.solver.user_laws.law import UserLaw
from geoswarm.solver.user_laws.library import address_of, opened, pointer_in
from geoswarm.solver.user_laws.section import (
    STRESS_NAMES,
    Formula,
    Place,
    UserLawSection,
    names_in,
    stress_values,
    value_of,
)

__all__ = ["UmatLaw", "UmatSection", "UmatState"]

_BESIDE = tuple(
    [StateVariable(f"strain_{one}", f"ε_{one}", "", "Total strain.") for one in ("xx", "yy", "zz", "xy", "yz", "zx")]
    + [
        StateVariable("total_time", "t", "day", "Time since the soil was placed."),
        StateVariable("increments", "n", "", "Increments since the soil was placed."),
    ]
)

_SHEAR: Final = {"stress": 1.0, "strain": 2.0}


class UmatState(Section):
    """One of the routine's state variables (STATEV)."""

    name: Name
    symbol: str = Field("", max_length=20)
    unit: str = Field("", max_length=50)
    description: str = Field("", max_length=300)
    initial: Formula = Field(
        0.0, description="Initial value: a number, or an expression of parameters and the initial stress."
    )
    discrete: bool = Field(False, description="A flag or counter: never a mean of several steps.")
    tensor: Literal["stress", "strain"] | None = Field(
        None,
        description="This and the next three form a tensor (11, 22, 33, 12; strain: engineering) that turns with the "
        "body where the mesh is updated.",
    )


class UmatSection(UserLawSection):
    """A compiled Abaqus user routine (UMAT); see docs/user-laws.md."""

    law: Literal["umat"] = "umat"
    function: str = Field(
        "umat_", pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=100, description="Symbol of the routine."
    )
    props: tuple[Formula, ...] = Field(
        max_length=1000, description="PROPS in their order: names or expressions of parameters, or numbers."
    )
    state: tuple[UmatState, ...] = Field((), max_length=1000, description="STATEV in their order.")
    shear_order: tuple[Literal["xy"], Literal["xz", "yz"], Literal["xz", "yz"]] = Field(
        ("xy", "xz", "yz"), description="Order of the shear components: [xy, xz, yz], as in Abaqus, or [xy, yz, xz]."
    )
    six_components: bool = Field(False, description="The routine takes NTENS = 6 only.")
    name: Annotated[str, Field(max_length=NAME_LENGTH, pattern=r"^[ -~]*$")] = Field("SOIL", description="CMNAME.")

    def formulas(self) -> list[Place]:
        """PROPS and initial state, and those of all laws."""
        return [
            *((f"props[{number}]", one, ()) for number, one in enumerate(self.props)),
            *((f"state.{one.name}.initial", one.initial, STRESS_NAMES) for one in self.state),
            *super().formulas(),
        ]

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.shear_order[1] == self.shear_order[2]:
            raise ValueError("shear_order must be [xy, xz, yz] or [xy, yz, xz]")
        names = [one.name for one in self.state]
        beside = {one.name for one in _BESIDE}
        for name in names:
            if names.count(name) > 1 or name in beside:
                raise ValueError(f"state: the name {name} is given to two variables")
        if fault := self._wrong_tensor() or self.wrong_limit(names) or self.wrong_names():
            raise ValueError(fault)
        return self

    def _wrong_tensor(self) -> str | None:
        """A tensor of less than four variables of its own, in words."""
        places = [place for place, one in enumerate(self.state) if one.tensor is not None]
        for place, after in pairwise([*places, len(self.state)]):
            own = self.state[place : place + 4]
            what = f"state.{own[0].name}.tensor = {own[0].tensor}"
            if after - place < 4:
                return (
                    f"{what}: {after - place} variables before the next tensor or the end; at least four are accepted: "
                    "11, 22, 33, 12"
                )
            if any(one.discrete for one in own):
                return f"{what}: components that are not discrete are accepted"
        return None

    @property
    def made(self) -> UmatLaw:
        """The law."""
        return _law(self.model_dump_json(include=set(UmatSection.model_fields)))  # a material has more


@lru_cache(maxsize=64)
def _law(text: str) -> UmatLaw:
    section = UmatSection.model_validate_json(text)
    attributes = {
        "parameters": tuple(one.info(name) for name, one in section.parameters.items()),
        "state": (
            *(StateVariable(one.name, one.symbol or one.name, one.unit, one.description) for one in section.state),
            *_BESIDE,
        ),
        "tensors": (
            *(StateTensor(n, _SHEAR[one.tensor]) for n, one in enumerate(section.state) if one.tensor is not None),
            StateTensor(len(section.state), _SHEAR["strain"]),
        ),
        "discrete": np.array([*(one.discrete for one in section.state), *[False] * (BESIDE - 1), True]),
        "__doc__": f"The user routine {section.function} of {section.library}.",
    }
    return UmatLaw.of(section, attributes)


class UmatLaw(UserLaw):
    """A user routine.

    Constants: what all laws in libraries have, what stands at :data:`geoswarm.solver.laws.libraries.umat_bridge.PLACES`
    with PROPS at the end, then the parameters.
    """

    kind: ClassVar[str] = "umat"
    title: ClassVar[str] = "a user routine (UMAT)"
    section: ClassVar[UmatSection]
    update: ClassVar[NumbaUpdate] = umat_update
    trouble_words: ClassVar[tuple[str, ...]] = TROUBLES

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Open the library, and put together what the thin function reads."""
        section = self.section
        values = self.given_values(given)
        library = opened(section.place, section.version or "")
        props = [float(value_of(one, values, f"props[{number}]")) for number, one in enumerate(section.props)]
        names = [one.name for one in section.state]
        limit = -1 if section.limit is None else names.index(section.limit)
        head = self.shared_constants(len(names), limit, PLACES.props)
        head[PLACES.address] = address_of(library, section.function)
        head[PLACES.returns] = pointer_in(library, "geoswarm_umat_return")
        head[PLACES.prop_count] = len(props)
        head[PLACES.cyclic] = section.shear_order[1] == "yz"
        head[PLACES.whole] = section.six_components
        head[PLACES.temperature] = section.temperature
        head[PLACES.name : PLACES.name + NAME_LENGTH // 8] = np.frombuffer(
            section.name.ljust(NAME_LENGTH).encode("ascii")
        )
        return np.array([*head, *props, *values.values()])

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """Initial values of the section; no strain, no time."""
        values = self.values(constants)
        if any(names_in(one.initial) & set(STRESS_NAMES) for one in self.section.state):
            values |= stress_values(stress)
        found = np.zeros((*stress.shape[:-1], len(self.state)))
        for place, one in enumerate(self.section.state):
            found[..., place] = value_of(one.initial, values, f"state.{one.name}.initial")
        return found
