"""What the sections of tests on one material have in common: its law, ours, installed, or in a library of a user."""

from __future__ import annotations

from abc import ABC
from pathlib import Path
from typing import TYPE_CHECKING, Self

from pydantic import Field

from geoswarm.solver.forward.base import ForwardModelSpec
from geoswarm.solver.user_laws.material import LawChoice, law_of
from geoswarm.solver.user_laws.section import UserLawSection

if TYPE_CHECKING:
    from geoswarm.solver.laws.base import Law

__all__ = ["OneMaterialSpec"]


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
