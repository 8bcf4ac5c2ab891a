"""Models of what is asked about the statistics of a job; the answers are in :mod:`geoswarm.records.statistics`."""

from __future__ import annotations

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = [
    "FigureList",
    "GlobalRequest",
    "ProfileRequest",
    "SensitivityRequest",
]


class FigureList(BaseModel):
    """Figures that can be drawn."""

    model_config = ConfigDict(extra="forbid")

    items: list[str]


class _Request(BaseModel):
    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)


class SensitivityRequest(_Request):
    """Sensitivities at the optimum of a job."""

    polish: bool = Field(True, description="go to the minimum first; false: one generation at the best evaluation")
    step: float | None = Field(
        None, gt=0, le=0.1, description="largest difference in parts of the range; found for each parameter if absent"
    )
    at: dict[str, float] | None = Field(None, description="another optimum: values of the free parameters")


class ProfileRequest(_Request):
    """Profile objectives around the optimum of a job."""

    parameters: list[str] | None = Field(None, min_length=1, max_length=100, description="all free ones if absent")
    noise: dict[str, float] | float | None = Field(
        None, description="known standard deviation of a reading, base units; that of the problem if absent"
    )


class GlobalRequest(_Request):
    """Global sensitivity over the search range of a job."""

    kind: Literal["sobol", "morris"] = "sobol"
    samples: int | None = Field(
        None, ge=8, le=2**17, description="base points (a power of two; 256) or trajectories (20)"
    )
