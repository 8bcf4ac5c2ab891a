"""Parts of sections: how fast a test goes, and what its stages of shearing have in common."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, ClassVar, Literal

from pydantic import Field, model_validator

from geoswarm.solver.forward.base import in_unit
from geoswarm.solver.forward.staged_section import MAX_DURATION
from geoswarm.solver.laboratory.section import Part, exactly_one
from geoswarm.solver.laboratory.shear_stages import Control, ShearStage

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["MAX_CYCLES", "Cyclic", "Hold", "Monotonic", "require_pace"]

MAX_CYCLES = 20_000
"""Of all stages together."""
_USUAL = 1.0
"""Duration of a movement, or period of a cycle, day, of a law that time has no effect on."""


class Monotonic(Part):
    """A movement to a strain or a stress; a test adds a field for each, which ``ends`` names: (strain, stress)."""

    ends: ClassVar[tuple[str, str]]

    kind: Literal["monotonic"] = "monotonic"
    duration: float | None = Field(
        None,
        gt=0.0,
        le=MAX_DURATION,
        description="Duration, day; or give rate.",
        json_schema_extra=in_unit("day", shown=True),
    )
    rate: float | None = Field(
        None,
        gt=0.0,
        description="Rate of strain, 1/day (1 %/h is 0.24), or of stress, kPa/day; or give duration.",
        json_schema_extra=in_unit("1/day", 0.01, 10, shown=True),
    )

    @property
    def led(self) -> tuple[Control, float]:
        """What is led, and to which value."""
        return _led(self, self.ends)

    def stage(self, name: str, undrained: bool, path: str) -> ShearStage:
        """As it is calculated."""
        control, value = self.led
        duration = _USUAL if self.duration is None and self.rate is None else self.duration
        durations = None if duration is None else (duration,)
        return ShearStage(name, control, (value,), durations, self.rate, undrained=undrained, path=path)

    @model_validator(mode="after")
    def _one_pace_and_end(self) -> Monotonic:
        if self.duration is not None and self.rate is not None:
            raise ValueError("rate and duration are both given; give only one of them")
        exactly_one(self, *self.ends)
        return self


class Cyclic(Part):
    """Cycles of strain or stress; a test adds a field for each amplitude, which ``ends`` names: (strain, stress)."""

    ends: ClassVar[tuple[str, str]]

    kind: Literal["cyclic"] = "cyclic"
    cycles: int = Field(ge=1, le=MAX_CYCLES, description="Number of cycles.", json_schema_extra=in_unit("1", 1, 100))
    period: float | None = Field(
        None,
        gt=0.0,
        le=MAX_DURATION,
        description="Duration of a cycle, day; 1 s is 1.157e-5.",
        json_schema_extra=in_unit("day", shown=True),
    )
    way: Literal["two_way", "one_way"] = Field(
        "two_way",
        description="two_way: up by the amplitude, down by twice the amplitude, back; one_way: up by twice the "
        "amplitude, and back.",
    )

    @model_validator(mode="after")
    def _one_amplitude(self) -> Cyclic:
        exactly_one(self, *self.ends)
        return self

    def stage(self, name: str, undrained: bool, path: str) -> ShearStage:
        """As it is calculated: straight lines between the turning points."""
        control, amplitude = _led(self, self.ends)
        period = _USUAL if self.period is None else self.period
        two = self.way == "two_way"
        targets = (amplitude, -amplitude, 0.0) if two else (2.0 * amplitude, 0.0)
        durations = (0.25 * period, 0.5 * period, 0.25 * period) if two else (0.5 * period, 0.5 * period)
        return ShearStage(
            name,
            control,
            targets * self.cycles,
            durations * self.cycles,
            relative=True,
            undrained=undrained,
            path=path,
            in_cycle=len(targets),
        )


class Hold(Part):
    """Nothing is moved, time passes: creep under constant stress, or relaxation at constant strain."""

    kind: Literal["hold"] = "hold"
    keep: Literal["stress", "strain"] = Field(
        "stress", description="What is held: the stress (creep) or the strain (relaxation)."
    )
    duration: float = Field(gt=0.0, le=MAX_DURATION, description="Duration, day.", json_schema_extra=in_unit("day"))

    def stage(self, name: str, undrained: bool, path: str) -> ShearStage:
        """As it is calculated."""
        return ShearStage(
            name, self.keep, (0.0,), (self.duration,), relative=True, undrained=undrained, path=path, hold=True
        )


def require_pace(law: Law, stages: Sequence[Part]) -> None:
    """Refuse stages of shearing without a pace that matters to a law, or with too many cycles.

    Raises
    ------
    ValueError
        Says which, or how many.
    """
    fault = _without_pace(law, stages) or _too_many_cycles(stages)
    if fault is not None:
        raise ValueError(fault)


def _without_pace(law: Law, stages: Sequence[Part]) -> str | None:
    """Which stage of shearing lacks a pace that matters to a law, in words, or None."""
    for number, one in enumerate(stages):
        if not law.depends_on_time:
            return None
        if isinstance(one, Monotonic) and one.duration is None and one.rate is None:
            return f"shearing[{number}]: rate or duration is missing: time has an effect on material {law.kind}"
        if isinstance(one, Cyclic) and one.period is None:
            return f"shearing[{number}]: period is missing: time has an effect on material {law.kind}"
    return None


def _too_many_cycles(stages: Sequence[Part]) -> str | None:
    """What is wrong with the number of all cycles, in words, or None."""
    count = sum(one.cycles for one in stages if isinstance(one, Cyclic))
    return f"shearing: {count} cycles in all; at most {MAX_CYCLES} are accepted" if count > MAX_CYCLES else None


def _led(part: Part, names: tuple[str, str]) -> tuple[Control, float]:
    name = exactly_one(part, *names)
    return ("strain" if name == names[0] else "stress"), float(getattr(part, name))
