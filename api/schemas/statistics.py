"""Models of what is asked about the statistics of a job; the answers are in :mod:`geoswarm.records.statistics`."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import BaseModel, ConfigDict, Field

__all__ = [
    "DesignRequest",
    "ExploreRequest",
    "FigureList",
    "GlobalRequest",
    "PredictRequest",
    "JackknifeRequest",
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

    polish: bool = Field(
        True, description="refine the optimum first; false: evaluate one generation at the best evaluation"
    )
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


class JackknifeRequest(_Request):
    """Fits without each test of a job."""

    by: Literal["test"] = Field("test", description="what is left out, one at a time")
    runs: int | None = Field(
        None, ge=2, le=100_000, description="maximum number of evaluations; 1 + 3 (parameters + tests) if absent"
    )


class ExploreRequest(_Request):
    """Runs where a second basin of a job would be most likely."""

    runs: int = Field(100, ge=1, le=100_000, description="maximum number of evaluations")
    noise: dict[str, float] | float | None = Field(
        None, description="known standard deviation of a reading, base units; that of the problem if absent"
    )


class PredictRequest(_Request):
    """Another problem with the identified parameters of a job."""

    problem: dict[str, Any] | str = Field(
        description="the problem that is predicted, as in a problem file, or the text of one (YAML): forward_model, "
        "observations that say where (points with x; y if it was measured), and the parameters that the job does not "
        "identify"
    )
    runs: int = Field(200, ge=20, le=10_000, description="forward runs")
    level: float = Field(0.9, gt=0, lt=1, description="probability of the band at each x")
    noise: dict[str, float] | float | None = Field(
        None, description="known standard deviation of a reading, base units; that of the problem if absent"
    )
    source: Literal["auto", "posterior", "covariance"] = Field(
        "auto",
        description="where the draws come from; auto: the covariance at the optimum, and a trusted posterior sample "
        "where the model is nonlinear",
    )


class DesignRequest(_Request):
    """Candidate tests to be ranked by what they would add."""

    candidates: dict[str, Any] | str = Field(
        description="as a file of them, or the text of one (YAML); candidates: a list of tests, each with name, "
        "observations (series, points with x, error) and, unless they are of the job's forward model, a forward_model "
        "of their own, and optionally cost; parameters: those that the job has not"
    )
    predict: dict[str, Any] | str | None = Field(None, description="a problem whose prediction is to become narrower")
    criterion: Literal["widths", "volume", "prediction"] | None = Field(
        None, description="how they are ranked: by all intervals, the common region, or the prediction"
    )
    draws: int = Field(
        8, ge=0, le=200, description="number of points around the optima over which the worth is averaged"
    )
    noise: dict[str, float] | float | None = Field(
        None, description="known standard deviation of a reading, base units; that of the problem if absent"
    )


class GlobalRequest(_Request):
    """Global sensitivity over the search range of a job."""

    kind: Literal["sobol", "morris"] = "sobol"
    samples: int | None = Field(
        None, ge=8, le=2**17, description="base points (a power of two; 256) or trajectories (20)"
    )
