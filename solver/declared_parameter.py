"""A parameter that a user declares: of a registered model, or of a soil law in a library."""

from __future__ import annotations

from pydantic import BaseModel, ConfigDict, Field, model_validator

from geoswarm.solver.parameter_info import ParameterInfo

__all__ = ["DeclaredParameter"]


class DeclaredParameter(BaseModel):
    """A parameter as users see it."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    symbol: str = Field("", max_length=20)
    unit: str = Field("", max_length=50)
    description: str = Field("", max_length=300)
    default: float | None = None
    lower: float | None = None
    upper: float | None = None
    typical: tuple[float, float] | None = None
    source: str = Field("", max_length=300)

    @model_validator(mode="after")
    def _ordered(self) -> DeclaredParameter:
        if self.lower is not None and self.upper is not None and self.lower >= self.upper:
            raise ValueError(f"lower {self.lower:g} must be below upper {self.upper:g}")
        if self.typical is not None and self.typical[0] >= self.typical[1]:
            raise ValueError(f"typical must rise, got {self.typical[0]:g} to {self.typical[1]:g}")
        return self

    def info(self, name: str) -> ParameterInfo:
        """As forward models tell it."""
        return ParameterInfo(
            name,
            self.symbol or name,
            self.unit,
            self.description or name,
            default=self.default,
            lower=self.lower,
            upper=self.upper,
            typical=self.typical,
            source=self.source,
        )
