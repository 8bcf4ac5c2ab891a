"""``law: mfront``: a behaviour of MFront in a library as a soil law.

::

    material:
      law: mfront
      library: ogs                          # or libsand.so
      behaviour: ModCamClay_semiExpl
      parameters: {phi: {unit: degree}, OCR: {default: 1}}
      properties: {CriticalStateLineSlope: "6 * sin(phi * pi / 180) / (3 - sin(phi * pi / 180))"}
      state: {PreConsolidationPressure: "OCR * p", VolumeRatio: InitialVolumeRatio}

Material properties that ``properties`` does not mention are parameters under their own names.
"""

from __future__ import annotations

import ctypes
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache
from importlib.metadata import PackageNotFoundError, distribution
from pathlib import Path
from typing import Any, ClassVar, Literal, Self

import numpy as np
from pydantic import Field
from pydantic.json_schema import SkipJsonSchema

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleError, Issue, ProblemError
from geoswarm.solver.laws.base import StateTensor, StateVariable
from geoswarm.solver.laws.binary import NumbaUpdate
from geoswarm.solver.laws.libraries.mfront_bridge import MESSAGE_LENGTH, PLACES, TROUBLES, mfront_update
from geoswarm.solver.parameter_info import ParameterInfo
from geoswarm.solver.system.extras import needs_extra
from geoswarm.solver.user_laws.behaviour import Behaviour, UnusableBehaviourError, behaviour_in
from geoswarm.solver.user_laws.law import UserLaw
from geoswarm.solver.user_laws.library import address_of, opened
from geoswarm.solver.user_laws.section import (
    STRESS_NAMES,
    Formula,
    Place,
    UserLawSection,
    names_in,
    stress_values,
    value_of,
)
from geoswarm.solver.words import did_you_mean

__all__ = ["OGS", "MfrontLaw", "MfrontSection"]

OGS = "ogs"
"""Name of the library that OpenGeoSys brings (extra ``mfront``)."""

_OGS_FILE = "libOgsMFrontBehaviour.so"
_COMPONENTS = ("xx", "yy", "zz", "xy", "yz", "zx")
_MANDEL = ("xx", "yy", "zz", "xy", "xz", "yz")
_ELASTIC, _PLASTIC = "ElasticStrain", "EquivalentPlasticStrain"
_SAME_STRESS = 1.0e-6


class MfrontSection(UserLawSection):
    """A behaviour of MFront; see docs/user-laws.md."""

    law: Literal["mfront"] = "mfront"
    library: str = Field(
        min_length=1,
        max_length=1000,
        description="Shared library, relative to the problem file; ogs: that of the package ogs (extra mfront).",
    )
    behaviour: str = Field(pattern=r"^[A-Za-z_][A-Za-z0-9_]*$", max_length=200, description="Name of the behaviour.")
    properties: dict[str, Formula] = Field(
        {}, max_length=100, description="Material properties that are not parameters: numbers, or expressions of these."
    )
    state: dict[str, Formula] = Field(
        {},
        max_length=100,
        description="Initial values of internal state variables: numbers, or expressions of parameters and the stress.",
    )
    external: dict[str, Formula] = Field(
        {}, max_length=100, description="External state variables other than the temperature: numbers or expressions."
    )
    temperature: float = Field(293.15, description="Temperature passed to it.")
    # Only in canonical problems; users do not write it.
    read: SkipJsonSchema[Behaviour | None] = Field(None, description="what the library says of the behaviour")

    @property
    def file(self) -> str:
        """Name of the library's file."""
        return _OGS_FILE if self.library == OGS else self.library

    def library_folder(self, folder: Path | None, path: str) -> Path:
        """That of the package ogs, or of the problem file."""
        if self.library != OGS:
            return super().library_folder(folder, path)
        try:
            files = distribution(OGS).files or []
        except PackageNotFoundError:
            files = []
        found = next((Path(str(one.locate())) for one in files if one.name == _OGS_FILE), None)
        if found is None:
            text = f"{needs_extra(f'library: {OGS}', OGS)}; or name your own library"
            raise ProblemError([Issue(f"{path}.library", text)])
        return found.resolve().parent

    @property
    def parameter_names(self) -> tuple[str, ...]:
        """Those that are declared, and material properties that stand for themselves."""
        own = () if self.read is None else self.read.properties
        return (
            *self.parameters,
            *(name for name in own if name not in self.parameters and name not in self.properties),
        )

    def formulas(self) -> list[Place]:
        """Properties, initial state and external variables, and those of all laws."""
        return [
            *((f"properties.{name}", one, ()) for name, one in self.properties.items()),
            *((f"state.{name}", one, STRESS_NAMES) for name, one in self.state.items()),
            *((f"external.{name}", one, ()) for name, one in self.external.items()),
            *super().formulas(),
        ]

    def with_files(self, folder: Path | None, path: str) -> Self:
        """With folder and fingerprint of the library, and what it says of the behaviour."""
        found = super().with_files(folder, path)
        if found.read is not None:
            return found
        try:
            read = behaviour_in(found.place, found.version or "", found.behaviour)
        except UnusableBehaviourError as error:
            raise ProblemError([Issue(f"{path}.behaviour", str(error))]) from None
        found = found.model_copy(update={"read": read})
        if fault := found.fault():
            raise ProblemError([Issue(path, fault)])
        return found

    def fault(self) -> str | None:
        """What does not fit the behaviour, in words; it must have been read."""
        read = self.read
        assert read is not None
        numbers = [name for name, kind in zip(read.state, read.state_kinds, strict=True) if not kind]
        beside = [name for name in read.external if name != "Temperature"]
        for key, names, known in (
            ("properties", self.properties, read.properties),
            ("state", self.state, numbers),
            ("external", self.external, beside),
        ):
            for name in names:
                if name not in known:
                    what = "is a tensor, which begins with 0" if name in read.state else "is unknown"
                    hint = did_you_mean(name, known)
                    return f"{key}.{name} {what}{hint}; known: {', '.join(known) or 'none'}"
        for name in self.parameter_names:
            if name not in self.parameters and (not name.isidentifier() or name in STRESS_NAMES):
                return f"properties.{name} is missing: its name is none of a parameter, so it needs a value there"
        missing = [name for name in beside if name not in self.external]
        if missing:
            return f"external.{missing[0]} is missing: the behaviour depends on it"
        if fault := self.wrong_limit(numbers, "state variable that is a number"):
            return fault
        # A parameter of a property's name describes it, used in formulas or not.
        own = {name: one for name, one in self.parameters.items() if name not in read.properties}
        return self.model_copy(update={"parameters": own}).wrong_names()

    @property
    def made(self) -> MfrontLaw:
        """The law; before the library was read it has the declared parameters alone."""
        return _law(self.model_dump_json(include=set(MfrontSection.model_fields)))  # a material has more


@lru_cache(maxsize=64)
def _law(text: str) -> MfrontLaw:
    section = MfrontSection.model_validate_json(text)
    read = section.read
    attributes: dict[str, Any] = {
        "parameters": tuple(_parameter(section, name) for name in section.parameter_names),
        "__doc__": f"The behaviour {section.behaviour} of {section.library}.",
    }
    if read is not None:
        state: list[StateVariable] = []
        tensors: list[StateTensor] = []
        for name, kind in zip(read.state, read.state_kinds, strict=True):
            parts = [f"{name}_{one}" for one in _MANDEL] if kind else [name]
            text = "As the behaviour keeps it: tension positive, shear times sqrt(2)." if kind else "Of the behaviour."
            tensors += [StateTensor(len(state), math.sqrt(2.0))] if kind else []
            state += [StateVariable(part, part, "", text) for part in parts]
        tensors.append(StateTensor(len(state), 2.0))
        state += [StateVariable(f"strain_{one}", f"ε_{one}", "", "Total strain.") for one in _COMPONENTS]
        known = {6: "Tridimensional" in read.hypotheses, 4: read.plane is not None}
        attributes |= {
            "state": tuple(state),
            "tensors": tuple(tensors),
            "components": frozenset(count for count, there in known.items() if there),
        }
    return MfrontLaw.of(section, attributes)


def _parameter(section: MfrontSection, name: str) -> ParameterInfo:
    """A parameter; a material property has the limits that the library gives, unless narrower ones are declared."""
    declared = section.parameters.get(name)
    found = ParameterInfo(name, name, "", f"Material property of {section.behaviour}.")
    if declared is not None:
        found = declared.info(name)
    if section.read is not None and name in section.read.bounds:
        lower, upper = section.read.bounds[name]
        found = replace(
            found,
            lower=lower if found.lower is None else found.lower,
            upper=upper if found.upper is None else found.upper,
        )
    return found


class MfrontLaw(UserLaw):
    """A behaviour of MFront.

    Constants: what all laws in libraries have, what stands at
    :data:`geoswarm.solver.laws.libraries.mfront_bridge.PLACES`, then the parameters.
    """

    kind: ClassVar[str] = "mfront"
    title: ClassVar[str] = "a behaviour of MFront"
    section: ClassVar[MfrontSection]
    update: ClassVar[NumbaUpdate] = mfront_update
    trouble_words: ClassVar[tuple[str, ...]] = TROUBLES

    def __init__(self) -> None:
        super().__init__()
        self._message = ctypes.create_string_buffer(MESSAGE_LENGTH)

    @property
    def _read(self) -> Behaviour:
        read = self.section.read
        assert read is not None  # a problem is complete before anything is calculated
        return read

    def _starts(self) -> dict[str, int]:
        """Where each internal state variable begins."""
        starts, place = {}, 0
        for name, kind in zip(self._read.state, self._read.state_kinds, strict=True):
            starts[name] = place
            place += 6 if kind else 1
        return starts

    def _properties(self, values: Mapping[str, float | FloatArray]) -> dict[str, float]:
        """Material properties in their order."""
        given = self.section.properties
        return {
            name: float(value_of(given[name], values, f"properties.{name}") if name in given else values[name])
            for name in self._read.properties
        }

    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Open the library, and put together what the thin function reads."""
        section, read = self.section, self._read
        values = self.given_values(given)
        library = opened(section.place, section.version or "")
        limit = self._starts().get(section.limit or _PLASTIC, -1)
        head = self.shared_constants(len(read.state), limit, PLACES.tail)
        if 6 in self.components:
            head[PLACES.address] = address_of(library, f"{section.behaviour}_Tridimensional")
        if 4 in self.components:
            head[PLACES.plane_address] = address_of(library, f"{section.behaviour}_{read.plane}")
        head[PLACES.message] = ctypes.addressof(self._message)
        head[PLACES.external_count] = len(read.external)
        external = [
            section.temperature
            if name == "Temperature"
            else float(value_of(section.external[name], values, f"external.{name}"))
            for name in read.external
        ]
        properties = self._properties(values)
        return np.array([*head, *read.state_kinds, *external, *properties.values(), *values.values()])

    def initial_state(self, stress: FloatArray, constants: FloatArray) -> FloatArray:
        """Initial values of the section; the elastic strain of the stress, where E and nu are properties; no strain.

        Raises
        ------
        InfeasibleError
            The behaviour does not stay under that stress.
        """
        values = self.values(constants)
        properties = self._properties(values)
        starts = self._starts()
        found = np.zeros((*stress.shape[:-1], len(self.state)))
        if any(names_in(one) & set(STRESS_NAMES) for one in self.section.state.values()):
            values |= stress_values(stress)
        for name, one in self.section.state.items():
            found[..., starts[name]] = value_of(one, values, f"state.{name}")
        if _ELASTIC in starts and {"YoungModulus", "PoissonRatio"} <= properties.keys():
            young, poisson = properties["YoungModulus"], properties["PoissonRatio"]
            mandel = np.zeros((*stress.shape[:-1], 6))
            mandel[..., :4] = -self.stress_factor * stress[..., :4]
            if stress.shape[-1] == 6:
                mandel[..., 4], mandel[..., 5] = (
                    -self.stress_factor * stress[..., 5],
                    -self.stress_factor * stress[..., 4],
                )
            mandel[..., 3:] *= math.sqrt(2.0)
            strain = (1.0 + poisson) / young * mandel
            strain[..., :3] -= poisson / young * mandel[..., :3].sum(axis=-1, keepdims=True)
            found[..., starts[_ELASTIC] : starts[_ELASTIC] + 6] = strain
        self._require_rest(stress, found, constants)
        return found

    def _require_rest(self, stress: FloatArray, state: FloatArray, constants: FloatArray) -> None:
        """Refuse a state that is not at rest under the first of the stresses: the behaviour would jump to another."""
        first, count = stress.reshape(-1, stress.shape[-1])[0], stress.shape[-1]
        new, _, _, status = self.update(
            np.zeros(count), -math.inf, first, state.reshape(-1, len(self.state))[0], constants
        )
        if status < 0:
            raise InfeasibleError(f"the behaviour finds no stress where the soil is placed{self.troubles()}")
        if np.abs(new - first).max() > _SAME_STRESS * max(1.0, float(np.abs(first).max())):
            was, now = (", ".join(f"{one:g}" for one in values[:3]) for values in (first, new))
            raise InfeasibleError(
                f"placed under {was} kPa the behaviour has {now} kPa: the stress is outside its strength, or its "
                "initial state does not belong to it"
            )

    def troubles(self) -> str:
        """How often the behaviour found no stress, and its last words."""
        words = self._message.value.decode("utf-8", "replace").strip()
        found = super().troubles()
        return f"{found}: {words}" if found and words else found

    def forget_troubles(self) -> None:
        """Begin to count anew."""
        super().forget_troubles()
        self._message.value = b""
