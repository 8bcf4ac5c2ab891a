"""What laws in libraries of the user's have in common."""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from typing import Any, ClassVar, Self, cast

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.errors import InfeasibleError
from geoswarm.solver.laws.base import Law
from geoswarm.solver.laws.libraries.calls import SHARED
from geoswarm.solver.units import convert
from geoswarm.solver.user_laws.section import UserLawSection, value_of

__all__ = ["UserLaw"]


class UserLaw(Law):
    """A law of a library; a class of its own is made for each section. Its constants end with the parameters."""

    section: ClassVar[UserLawSection]
    trouble_words: ClassVar[tuple[str, ...]]
    """Why a step has no stress, in words, for each counter of the thin function."""

    @classmethod
    def of(cls, section: UserLawSection, attributes: Mapping[str, Any]) -> Self:
        """The law of a section, with attributes of its class."""
        own = {"section": section, "perfectly_plastic": section.perfectly_plastic, **attributes}
        return cast(Self, type(cls.__name__, (cls,), own)())

    def __init__(self) -> None:
        self.counters = np.zeros(len(self.trouble_words), dtype=np.int64)
        self.stress_factor = float(convert(1.0, "kPa", self.section.stress_unit))
        """Units of stress of the library in a kPa."""
        self.time_factor = float(convert(1.0, "day", self.section.time_unit))
        """Units of time of the library in a day."""

    def values(self, constants: FloatArray) -> dict[str, float | FloatArray]:
        """Parameters by name."""
        names = [info.name for info in self.parameters]
        return dict(zip(names, constants[constants.size - len(names) :].tolist(), strict=True))

    def given_values(self, given: Mapping[str, Any]) -> dict[str, float | FloatArray]:
        """Parameters by name, in their order, of what is given."""
        return {info.name: float(given[info.name]) for info in self.parameters}

    def shared_constants(self, state_count: int, limit: int, size: int) -> FloatArray:
        """Constants that all laws in libraries have, in an array of a size.

        ``state_count``: of variables that the library keeps; ``limit``: place of the one that shows yield, -1: none.
        """
        head = np.zeros(size)
        head[SHARED.troubles] = self.counters.ctypes.data
        head[SHARED.state_count] = state_count
        head[SHARED.stress_factor] = self.stress_factor
        head[SHARED.time_factor] = self.time_factor
        head[SHARED.numerical] = self.section.tangent == "differences"
        head[SHARED.least_time] = self.section.least_time
        head[SHARED.least_log_time] = math.log(self.section.least_time)
        head[SHARED.limit] = limit
        return head

    @property
    def knows_K0(self) -> bool:
        """Whether the section gives one."""
        return self.section.K0 is not None

    def K0(self, constants: FloatArray) -> float | None:
        """That of the section."""
        if self.section.K0 is None:
            return None
        return float(value_of(self.section.K0, self.values(constants), "K0"))

    def log_time_scale(self, stress: FloatArray, state: FloatArray, constants: FloatArray) -> FloatArray | None:
        """That of the section."""
        del state
        if self.section.time_scale is None:
            return None
        values = self.values(constants) | {"p": stress[..., :3].mean(axis=-1)}
        scale = np.asarray(value_of(self.section.time_scale, values, "time_scale"))
        if not (scale > 0.0).all():
            raise InfeasibleError(f"time_scale must be above 0 day, got {scale.min():g} day")
        found: FloatArray = np.log(np.broadcast_to(scale, stress.shape[:-1]))
        return found

    def elastic_moduli(self, constants: FloatArray, p: float) -> tuple[float, float]:
        """Those of the section, or of the tangent at rest under p."""
        moduli = self.section.moduli
        if moduli is not None:
            values = self.values(constants) | {"p": p}
            bulk = float(value_of(moduli.bulk, values, "moduli.bulk"))
            shear = float(value_of(moduli.shear, values, "moduli.shear"))
        else:
            stress = np.array([p, p, p, 0.0, 0.0, 0.0])
            state = self.initial_state(stress, constants)
            _, _, tangent, status = self.update(np.zeros(6), -math.inf, stress, state, constants)
            if status < 0:
                raise InfeasibleError(
                    f"{self.title} gives no tangent at rest under p = {p:g} kPa{self.troubles()}; declare its moduli"
                )
            bulk, shear = float(tangent[:3, :3].mean()), float(np.diag(tangent)[3:].mean())
        if not (bulk > 0.0 and shear > 0.0):
            raise InfeasibleError(f"bulk and shear modulus must be above 0, got {bulk:g} and {shear:g} kPa")
        return bulk, shear

    def forget_troubles(self) -> None:
        """Begin to count anew why steps have no stress."""
        self.counters[:] = 0

    def troubles(self) -> str:
        """Why steps had no stress since then, and how often, in words; empty: none."""
        counts = zip(self.trouble_words, self.counters.tolist(), strict=True)
        found = [f"{words} {count} times" for words, count in counts if count]
        return f"; the routine {', '.join(found)}" if found else ""

    @abstractmethod
    def constants(self, given: Mapping[str, Any]) -> FloatArray:
        """Open the library, and put together what the thin function reads; the parameters come last."""
