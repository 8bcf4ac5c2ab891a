"""Forward model behind the UM-Bridge protocol: a server that turns vectors of parameters into vectors of results.

::

    forward_model:
      kind: umbridge
      url: http://localhost:4242
      name: forward
      inputs: [[E, nu], [k]]                 # parameters, in the order of the input vectors
      config: {level: 2}
      series:
        settlement: {output: 0, x: [1, 10, 100], x_unit: day, y_unit: mm}

A server is called only by problem files on this machine and by registered models, never by what came over the network.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated, Any, ClassVar, Literal, TypeVar

from pydantic import BaseModel, ConfigDict, Field, field_validator

from geoswarm.solver.external.umbridge import address_of
from geoswarm.solver.forward.base import ForwardModelSpec, in_unit
from geoswarm.solver.section import Name

if TYPE_CHECKING:
    from geoswarm.solver.forward.programs.umbridge_model import UmbridgeModel

__all__ = ["UmbridgeSeries", "UmbridgeSpec"]

T = TypeVar("T")
Vector = Annotated[tuple[Name, ...], Field(max_length=1000)]


class UmbridgeSeries(BaseModel):
    """An output vector as a series."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    output: int = Field(0, ge=0, description="number of the output vector, from 0")
    x: tuple[float, ...] = Field(
        min_length=1, max_length=200_000, description="points to which its numbers belong; linear between them"
    )
    x_unit: str = Field("dimensionless", max_length=50, description="unit of x")
    y_unit: str = Field("dimensionless", max_length=50, description="unit in which the server answers")
    description: str = Field("", max_length=200, description="what the series is")

    @field_validator("x")
    @classmethod
    def _apart(cls, x: tuple[float, ...]) -> tuple[float, ...]:
        twice = _first_twice(x)
        if twice is not None:
            raise ValueError(f"{twice:g} is given twice; each number of the output needs its own point")
        return x


class UmbridgeSpec(ForwardModelSpec):
    """A model behind the UM-Bridge protocol 1.0."""

    depends_on_section: ClassVar[bool] = True
    programs: ClassVar[bool] = True

    kind: Literal["umbridge"] = "umbridge"
    url: str = Field(max_length=1000, description="address of the server, such as http://localhost:4242")
    name: str = Field("forward", min_length=1, max_length=200, description="name of the model there")
    inputs: tuple[Vector, ...] = Field(
        min_length=1, max_length=100, description="parameters in the order of each input vector: [[E, nu], [k]]"
    )
    config: dict[str, Any] = Field({}, max_length=100, description="configuration that the model gets")
    series: dict[Name, UmbridgeSeries] = Field(
        min_length=1, max_length=1000, description="which output vector each series is"
    )
    seconds: float | None = Field(
        None, gt=0.0, description="Wall time after which a request has failed.", json_schema_extra=in_unit("s")
    )
    tries: int = Field(3, ge=1, le=100, description="Attempts to call a server that cannot be reached or is busy.")
    pause: float = Field(
        1.0, ge=0.0, le=3600.0, description="Pause between these calls.", json_schema_extra=in_unit("s")
    )

    @field_validator("url")
    @classmethod
    def _address(cls, url: str) -> str:
        address_of(url)
        return url.strip().rstrip("/")

    @field_validator("config")
    @classmethod
    def _finite(cls, config: dict[str, Any]) -> dict[str, Any]:
        try:
            json.dumps(config, allow_nan=False)
        except ValueError:
            raise ValueError("numbers must be finite; JSON has no NaN and no infinity") from None
        return config

    @field_validator("inputs", mode="before")
    @classmethod
    def _one_vector(cls, inputs: Any) -> Any:
        """A list of names is one vector."""
        listed = isinstance(inputs, list | tuple) and inputs and all(isinstance(one, str) for one in inputs)
        vectors = [inputs] if listed else inputs
        # A validator that looks first makes lists of JSON's arrays, which strict validation would refuse.
        return (
            tuple(tuple(one) if isinstance(one, list) else one for one in vectors)
            if isinstance(vectors, list | tuple)
            else vectors
        )

    @field_validator("inputs")
    @classmethod
    def _each_once(cls, inputs: tuple[Vector, ...]) -> tuple[Vector, ...]:
        names = [name for vector in inputs for name in vector]
        if not names:
            raise ValueError("no parameter is named; write for example [[E, nu]]")
        twice = _first_twice(names)
        if twice is not None:
            raise ValueError(f"{twice} is given twice; give it once")
        return inputs

    def build(self) -> UmbridgeModel:
        """Build the forward model; the server is not called.

        Raises
        ------
        ProblemError
            The unit of a series is unknown.
        """
        from geoswarm.solver.forward.programs.umbridge_model import UmbridgeModel

        return UmbridgeModel(self)


def _first_twice(values: Iterable[T]) -> T | None:
    seen: set[T] = set()
    for one in values:
        if one in seen:
            return one
        seen.add(one)
    return None
