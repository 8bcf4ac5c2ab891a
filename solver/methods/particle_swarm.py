"""The particle swarm."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeAlias

from pydantic import Discriminator, Field, Tag, field_validator, model_validator
from pydantic_core import PydanticCustomError

from geoswarm.solver.methods.base import Maker, SearchMethod, Task

if TYPE_CHECKING:
    from geoswarm.solver.search import ParticleSwarm, Search, Snapshot, SwarmSettings

__all__ = ["POLISHED", "POLISH_UNFINISHED", "ParticleSwarmMethod", "swarm_settings"]

POLISHED = "polished"
POLISH_UNFINISHED = "polish_unfinished"

_LEAST_AUTOMATIC, _MOST_AUTOMATIC = 8, 200  # particles

Particles: TypeAlias = Annotated[
    Annotated[int, Field(ge=1, le=1000), Tag("number")] | Annotated[Literal["auto"], Tag("auto")],
    Discriminator(lambda value: "auto" if isinstance(value, str) else "number"),
]


class ParticleSwarmMethod(SearchMethod):
    """Particle swarm: generations of particles, each evaluated in parallel."""

    title: ClassVar[str] = "particle swarm"
    bias: ClassVar[str] = (
        "The samples are particles of a swarm: they crowd where the swarm was drawn to, so correlations and widths "
        "describe its path as well as the data. Only the lower envelope can be read as it is."
    )

    kind: Literal["particle_swarm"] = "particle_swarm"
    particles: Particles = Field(
        10,
        description="particles in a generation, 1 for one run after the other; auto: chosen once, at the start, from "
        "the evaluations that can run at once then (a multiple of them, at least 8)",
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
        description="where an accelerated search would begin again elsewhere: polish the best by Levenberg-Marquardt "
        "steps and end",
    )

    @field_validator("inertia_weight")
    @classmethod
    def _only_with_its_form(cls, value: float | None, info: Any) -> float | None:
        if value is not None and info.data.get("form") == "constriction":
            raise PydanticCustomError("form", "only used with form: inertia_weight; leave it out or set form")
        return value

    @field_validator("acceleration")
    @classmethod
    def _one_particle_is_aimed(cls, value: str, info: Any) -> str:
        if value == "none" and info.data.get("particles") == 1:
            raise PydanticCustomError("acceleration", "one particle alone is no swarm: set particles to 2 at least")
        return value

    @field_validator("polish")
    @classmethod
    def _only_accelerated(cls, value: bool, info: Any) -> bool:
        if value and info.data.get("acceleration") == "none":
            raise PydanticCustomError("polish", "needs the stored responses of acceleration: response_surface")
        return value

    @model_validator(mode="after")
    def _constriction_exists(self) -> ParticleSwarmMethod:
        if self.form == "constriction":
            cognitive = 2.05 if self.cognitive_coefficient is None else self.cognitive_coefficient
            social = 2.05 if self.social_coefficient is None else self.social_coefficient
            if not cognitive + social > 4:
                raise PydanticCustomError(
                    "constriction",
                    "form constriction needs cognitive_coefficient + social_coefficient above 4, not {total}",
                    {"total": f"{cognitive + social:g}"},
                )
        return self

    @property
    def least(self) -> tuple[int, str]:
        """Particles."""
        return (2 if self.particles == "auto" else self.particles), "particles"

    @property
    def learns(self) -> bool:
        """With acceleration."""
        return self.acceleration != "none"

    @property
    def takes_offers(self) -> bool:
        """With acceleration."""
        return self.learns

    def in_words(self) -> str:
        """Form, topology, particles."""
        form = self.form.replace("_", " ")
        automatic = self.particles == "auto"
        count = "as many particles as workers suggested" if automatic else f"{self.particles} particles"
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
        from geoswarm.solver.search import ParticleSwarm

        task = self.task
        return ParticleSwarm(task.space, swarm_settings(self.method, slots), task.seed, task.initial, task.offered)

    def restore(self, snapshot: Snapshot) -> ParticleSwarm:
        from geoswarm.solver.search import ParticleSwarm

        return ParticleSwarm.restore(self.task.space, swarm_settings(self.method), self.task.seed, snapshot)


def particles_for(slots: int) -> int:
    """Size of a generation that keeps ``slots`` busy: the least multiple of them from 8 on, 200 at most."""
    return min(slots * -(-_LEAST_AUTOMATIC // slots), _MOST_AUTOMATIC)


def swarm_settings(method: ParticleSwarmMethod, slots: int = 1) -> SwarmSettings:
    """Translate the ``method`` section of a swarm; a coefficient not given takes the default of its form."""
    from geoswarm.solver.search import SwarmSettings

    constriction = method.form == "constriction"
    coefficient = 2.05 if constriction else 1.49618
    return SwarmSettings(
        particles=particles_for(slots) if method.particles == "auto" else method.particles,
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
