"""What sections of several forward models have in common: fields, their checks, one material with its law."""

from __future__ import annotations

from abc import ABC
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal, Self, TypeAlias

from pydantic import Field

from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.sentences import SentenceError, setting
from geoswarm.solver.user_laws.material import LawChoice, law_of
from geoswarm.solver.user_laws.section import UserLawSection

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["Geometry", "LawSettings", "OneMaterialSpec", "StepError", "require_stage"]

Geometry: TypeAlias = Annotated[
    Literal["updated", "fixed"],
    Field(description="updated: logarithmic strain, large deformations; fixed: small strain."),
]
LawSettings: TypeAlias = Annotated[
    dict[str, str | float | None],
    Field(max_length=50, description="Settings of the law by name, where they are not its defaults."),
]
StepError: TypeAlias = Annotated[
    float,
    Field(
        ge=1.0e-9,
        le=1.0e-2,
        description="Error of the integration aimed at, as strain, of stress over the bulk modulus; kept step by step.",
    ),
]


def require_stage(zero_at_stage: int, stages: Sequence[object]) -> None:
    """Refuse a zero of time at a stage that there is not.

    Raises
    ------
    ValueError
        It is later than the last one.
    """
    if zero_at_stage > len(stages):
        raise SentenceError(setting("zero_at_stage"), f" must be from 1 to {len(stages)}, got {zero_at_stage}")


class OneMaterialSpec(ForwardModelSpec, ABC):
    """The field ``material``, and what follows from it."""

    material: LawChoice = Field(description="Law of the material.")

    @property
    def law(self) -> Law:
        """The law of the material."""
        return law_of(self.material)

    @property
    def material_in_words(self) -> str:
        """Name of the law as it is written beside a specimen."""
        return self.law.kind.replace("_", " ")

    @property
    def user_laws(self) -> tuple[UserLawSection, ...]:
        """That of the material, where it is in a library."""
        return (self.material,) if isinstance(self.material, UserLawSection) else ()

    def with_files(self, folder: Path | None, path: str) -> Self:
        """With what is known of the library of the material."""
        if not isinstance(self.material, UserLawSection):
            return self
        return self.model_copy(update={"material": self.material.with_files(folder, f"{path}.material")})
