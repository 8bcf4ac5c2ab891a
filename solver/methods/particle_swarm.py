"""The particle swarm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag, field_validator, model_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.methods.base import Maker, SearchMethod, Task
from geoswarm.solver.methods.widths import Next, Situation, overlapping, wide, worth_overlapping
from geoswarm.solver.sentences import SentenceError, setting

if TYPE_CHECKING:
    from collections.abc import Sequence

    from geoswarm.solver.search.base import Search, Snapshot
    from geoswarm.solver.search.particle_swarm import ParticleSwarm, SwarmSettings

__all__ = ["POLISHED", "POLISH_UNFINISHED", "ParticleSwarmMethod", "swarm_settings"]

POLISHED = "polished"
POLISH_UNFINISHED = "polish_unfinished"

Particles: TypeAlias = Annotated[
    Annotated[int, Field(ge=1, le=1000), Tag("number")] | Annotated[Literal["auto"], Tag("auto")],
    Discriminator(lambda value: "auto" if isinstance(value, str) else "number"),
]


class ParticleSwarmMethod(SearchMethod):
    """Particle swarm: generations of particles, each evaluated in parallel."""

    title: ClassVar[str] = "particle swarm"
    bias: ClassVar[str] = (
        "The samples are particles of a swarm, which are dense where it searched: correlations and widths reflect its "
        "path as well as the data. Only the lower envelope is free of this."
    )

    kind: Literal["particle_swarm"] = "particle_swarm"
    particles: Particles = Field(
        "auto",
        description="particles in a generation, 1 for one run at a time; auto: as many as runs can be in "
        "progress at once, set again for each generation (at least 10 of a forward model whose runs take milliseconds, "
        "and of the textbook swarm, which keeps its number)",
    )
    overlap: bool | None = Field(
        None,
        description="requests each generation while the previous one is running, so that no slot waits for its last "
        "run; absent: with particles: auto where the last runs took more than a second and differed in length",
    )
    form: Literal["constriction", "inertia_weight"] = Field("constriction", description="form of the velocity equation")
    inertia_weight: float | None = Field(
        None, ge=0, le=1, description="w; 0.7298 if absent; only with form inertia_weight"
    )
    cognitive_coefficient: float | None = Field(
        None, ge=0, le=10, description="pull to the particle's own best; 2.05 (constriction) or 1.49618 if absent"
    )
    social_coefficient: float | None = Field(
        None, ge=0, le=10, description="pull to the best of the neighbourhood; 2.05 (constriction) or 1.49618 if absent"
    )
    topology: Literal["global", "ring"] = Field(
        "global", description="whose best a particle knows: all or two neighbours"
    )
    boundary: Literal["reflect", "absorb", "resample"] = Field("reflect", description="what happens at the bounds")
    max_velocity: float = Field(
        0.5, gt=0, le=1, description="largest step as a fraction of the range between the bounds"
    )
    acceleration: Literal["none", "response_surface"] = Field(
        "response_surface",
        description="aims most particles at what all runs so far promise; none: the textbook swarm",
    )
    polish: bool = Field(
        False,
        description="where an accelerated search would restart elsewhere: polish the best by Levenberg-Marquardt "
        "steps and end",
    )

    @field_validator("inertia_weight")
    @classmethod
    def _only_with_its_form(cls, value: float | None, info: Any) -> float | None:
        if value is not None and info.data.get("form") == "constriction":
            raise SentenceError(
                *("only used with ", setting("form", "inertia_weight"), "; leave it out or set ", setting("form"))
            )
        return value

    @field_validator("acceleration")
    @classmethod
    def _one_particle_is_aimed(cls, value: str, info: Any) -> str:
        if value == "none" and info.data.get("particles") == 1:
            raise PydanticCustomError("acceleration", "a swarm needs at least 2 particles")
        return value

    @field_validator("polish")
    @classmethod
    def _only_accelerated(cls, value: bool, info: Any) -> bool:
        if value and info.data.get("acceleration") == "none":
            raise SentenceError("needs the stored responses of ", setting("acceleration", "response_surface"))
        return value

    @model_validator(mode="after")
    def _overlap_is_aimed(self) -> ParticleSwarmMethod:
        if self.overlap and not self._can_overlap:
            raise SentenceError("needs ", setting("acceleration", "response_surface"), ", and no ", setting("polish"))
        return self

    @model_validator(mode="after")
    def _constriction_exists(self) -> ParticleSwarmMethod:
        if self.form == "constriction":
            cognitive = 2.05 if self.cognitive_coefficient is None else self.cognitive_coefficient
            social = 2.05 if self.social_coefficient is None else self.social_coefficient
            if not cognitive + social > 4:
                raise SentenceError(
                    *("form constriction needs ", setting("cognitive_coefficient"), " + "),
                    *(setting("social_coefficient"), f" above 4, got {cognitive + social:g}"),
                )
        return self

    @property
    def least(self) -> tuple[int, str]:
        """Particles."""
        return (1 if self.particles == "auto" else self.particles), "particles"

    @property
    def learns(self) -> bool:
        """With acceleration."""
        return self.acceleration != "none"

    @property
    def _can_overlap(self) -> bool:
        return self.learns and not self.polish

    @property
    def may_overlap(self) -> bool:
        """Where that was asked for, or left to the engine with ``particles: auto``."""
        return self._can_overlap and (self.follows_slots if self.overlap is None else self.overlap)

    @property
    def follows_slots(self) -> bool:
        """With ``particles: auto``; the textbook swarm keeps its particles."""
        return self.particles == "auto" and self.learns

    def asks_next(self, situation: Situation | None, lengths: Sequence[float], *, quick: bool) -> Next:
        """As many runs as slots; two generations under way where that was asked for, or runs differ in length."""
        if not self.follows_slots or situation is None:
            return Next(None, bool(self.overlap))
        size = wide(situation.slots, quick=quick)
        ahead = self.overlap
        if ahead is None:
            ahead = self._can_overlap and not quick and worth_overlapping(lengths, size)
        return Next(max(size, overlapping(situation.slots)) if ahead else size, ahead)

    @property
    def takes_offers(self) -> bool:
        """With acceleration."""
        return self.learns

    def in_words(self) -> str:
        """Form, topology, particles."""
        form = self.form.replace("_", " ")
        automatic = self.particles == "auto"
        count = "as many particles as runs at once" if automatic else f"{self.particles} particles"
        return f"particle swarm ({form}, {self.topology}), {count}"

    def end_reason(self, search: Search, evaluations: int, *, over: bool) -> str | None:  # noqa: ARG002  others need it
        """It ends with its polish."""
        if not over:
            return None
        return POLISHED if getattr(search, "converged", False) else POLISH_UNFINISHED

    def maker(self, task: Task) -> Maker:
        """Prepare to make the swarm of a job."""
        return _SwarmMaker(self, task)


@dataclass(frozen=True, slots=True)
class _SwarmMaker:
    method: ParticleSwarmMethod
    task: Task

    def start(self, slots: int) -> ParticleSwarm:
        from geoswarm.solver.search.particle_swarm import ParticleSwarm

        task, method = self.task, self.method
        particles = wide(slots, quick=task.quick or not method.learns)
        if method.overlap:
            particles = max(particles, overlapping(slots))
        if task.most is not None:
            particles = min(particles, task.most)
        begin = ParticleSwarm.begin_overlapping if method.overlap else ParticleSwarm
        return begin(task.space, swarm_settings(method, particles), task.seed, task.initial, task.offered)

    def restore(self, snapshot: Snapshot) -> ParticleSwarm:
        from geoswarm.solver.search.particle_swarm import ParticleSwarm

        return ParticleSwarm.restore(self.task.space, swarm_settings(self.method), self.task.seed, snapshot)


def swarm_settings(method: ParticleSwarmMethod, particles: int = 1) -> SwarmSettings:
    """Translate the ``method`` section of a swarm; a coefficient not given takes the default of its form.

    ``particles``: of the first generation, where the method leaves them to the engine.
    """
    from geoswarm.solver.search.particle_swarm import SwarmSettings

    constriction = method.form == "constriction"
    coefficient = 2.05 if constriction else 1.49618
    return SwarmSettings(
        particles=particles if method.particles == "auto" else method.particles,
        form=method.form,
        cognitive_coefficient=_or(method.cognitive_coefficient, coefficient),
        social_coefficient=_or(method.social_coefficient, coefficient),
        inertia_weight=_or(method.inertia_weight, 0.7298),
        topology=method.topology,
        boundary=method.boundary,
        max_velocity=method.max_velocity,
        acceleration=method.acceleration,
        polish=method.polish,
    )


def _or(value: float | None, default: float) -> float:
    return default if value is None else value
