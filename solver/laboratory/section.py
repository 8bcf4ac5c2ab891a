"""What the sections of laboratory tests on any law have in common."""

from __future__ import annotations

from abc import ABC
from collections.abc import Mapping
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field, model_validator

from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.fields import Geometry, LawSettings, OneMaterialSpec, StepError
from geoswarm.solver.forward.staged_section import MAX_DURATION, MAX_STRESS
from geoswarm.solver.sentences import Key, SentenceError, setting

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["FlowSpec", "LaboratorySpec", "Loading", "Part", "exactly_one", "ratio_fault", "settings_fault"]


class Part(BaseModel):
    """A part of a section: unknown keys and numbers that are not finite are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class Loading(Part):
    """How long a stage of consolidation takes; a test adds the stresses at its end."""

    duration: float = Field(
        1.0, gt=0.0, le=MAX_DURATION, description="Duration, day.", json_schema_extra=in_unit("day", 0.1, 7)
    )
    loading_time: float = Field(
        0.0,
        ge=0.0,
        description="Time in which the stress is reached, at constant rate, day; 0: at once.",
        json_schema_extra=in_unit("day"),
    )

    @model_validator(mode="after")
    def _load_within_the_stage(self) -> Loading:
        if self.loading_time > self.duration:
            raise SentenceError(
                setting("loading_time"),
                f" must be at most the duration, {self.duration:g} day, got {self.loading_time:g} day",
            )
        return self


class LaboratorySpec(OneMaterialSpec, ABC):
    """Fields of the laboratory tests on a material point of any law."""

    depends_on_section: ClassVar[bool] = True
    series_need: ClassVar[Mapping[str, str]] = {"void_ratio": "initial_void_ratio"}

    settings: LawSettings = Field({})
    initial_void_ratio: float | None = Field(
        None,
        gt=0.0,
        le=100.0,
        description="Void ratio before the first stage, for series of it. Of a law with e0 it is that: give one.",
        json_schema_extra=in_unit("1", 0.4, 3),
    )
    geometry: Geometry = "updated"
    tolerance: StepError = 1.0e-5

    initial_stress: float = Field(
        gt=0.0,
        le=MAX_STRESS,
        description="Vertical effective stress under which the soil is placed, before the first stage, kPa.",
        json_schema_extra=in_unit("kPa", 1, 400),
    )
    initial_ratio: float | Literal["K0"] = Field(
        "K0",
        description="Horizontal over vertical stress under which the soil is placed; K0: that of the law.",
        json_schema_extra=in_unit("1", 0.4, 1),
    )

    @model_validator(mode="after")
    def _fits_the_law(self) -> LaboratorySpec:
        fault = settings_fault(self.law, self.settings) or ratio_fault(self.law, self.initial_ratio)
        if fault is not None:
            raise fault
        return self

    @property
    def components(self) -> int:
        """Stress components of the calculation: 4, as of an axisymmetric or plane body, where the law takes them."""
        return 4 if 4 in self.law.components else 6

    @property
    def kernels(self) -> frozenset[str]:
        """Those of tests on any law, and the law's."""
        return frozenset({"element_test", self.law.kind})

    @property
    def quick(self) -> bool:
        """One material point, of a law of ours."""
        return not self.user_laws


class FlowSpec(LaboratorySpec, ABC):
    """Fields of the laboratory tests in which pore water flows: a column of points stands for the specimen."""

    consolidates: ClassVar[bool] = True

    height: float = Field(
        gt=0.0,
        le=10.0,
        description="Initial height of the specimen, m.",
        json_schema_extra=in_unit("m", 0.01, 0.05),
    )
    back_pressure: float = Field(
        0.0,
        ge=0.0,
        le=MAX_STRESS,
        description="Pore pressure at the drained ends, kPa; it is only added to the pore pressure.",
        json_schema_extra=in_unit("kPa", 0, 600),
    )
    tolerance: StepError = 1.0e-4

    @property
    def kernels(self) -> frozenset[str]:
        """Those of a consolidating column, and the law's."""
        return frozenset({"consolidation", self.law.kind})


def exactly_one(part: BaseModel, *names: str) -> str:
    """The one of some fields that is given.

    Raises
    ------
    ValueError
        None, or more than one is.
    """
    given = [name for name in names if getattr(part, name) is not None]
    if len(given) != 1:
        found = " and ".join(given) + " are given" if given else "none is given"
        raise ValueError(f"give exactly one of {', '.join(names)}; {found}")
    return given[0]


def settings_fault(law: Law, settings: Mapping[str, str | float | None]) -> SentenceError | None:
    """What is wrong with the settings given for a law, in words, or None."""
    known = {one.name: one for one in law.settings}
    for name, value in settings.items():
        one, key = known.get(name), Key(f"settings.{name}", f"settings.{name}")
        if one is None:
            names = ", ".join(known) if known else "it has none"
            return SentenceError(key, f": material {law.kind} has no such setting; known: {names}")
        if one.choices and value not in one.choices:
            return SentenceError(key, f" must be one of {', '.join(one.choices)}, got {value!r}")
        if not one.choices and isinstance(value, str):
            return SentenceError(key, f" must be a number of at least {one.lower:g}, got {value!r}")
        if not one.choices and isinstance(value, float) and value < one.lower:
            return SentenceError(key, f" must be at least {one.lower:g}, got {value:g} {one.unit}")
    return None


def ratio_fault(law: Law, ratio: float | str) -> SentenceError | None:
    """What is wrong with the ratio of stresses under which soil of a law is placed, in words, or None."""
    if isinstance(ratio, float) and not 0.0 < ratio <= 100.0:
        return SentenceError(setting("initial_ratio"), f" must be above 0 and at most 100, or K0; got {ratio:g}")
    if ratio == "K0" and not law.knows_K0:
        return SentenceError(setting("initial_ratio"), f" must be a number, got K0: material {law.kind} has no K0")
    return None
