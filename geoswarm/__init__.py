"""Finds the parameters of geotechnical models from measurements.

>>> from geoswarm import Client
>>> with Client() as client:                              # doctest: +SKIP
...     job = client.submit(Path("problem.yaml"))
...     print(client.wait(job.id).parameters)

Beside the client there is what a forward model of one's own is made of (``docs/plug-ins.md``). The names below are
loaded when they are used, so importing the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geoswarm.client import (
        AsyncClient,
        Client,
        ConflictError,
        ConnectionFailedError,
        GeoswarmError,
        HttpError,
        InvalidProblemError,
        JobFailedError,
        NotFoundError,
        ServerError,
        UnauthorizedError,
        WaitTimeoutError,
    )
    from geoswarm.solver.arrays import FloatArray
    from geoswarm.solver.errors import (
        BadOutputError,
        DivergedError,
        ForwardError,
        InfeasibleError,
        NotFiniteError,
    )
    from geoswarm.solver.forward.base import (
        ForwardModel,
        ForwardModelSpec,
        ForwardRun,
        ParameterInfo,
        SeriesInfo,
        in_unit,
    )

_FORWARD, _ERRORS = "geoswarm.solver.forward.base", "geoswarm.solver.errors"
_ELSEWHERE = {
    "FloatArray": "geoswarm.solver.arrays",
    **dict.fromkeys(("BadOutputError", "DivergedError", "ForwardError", "InfeasibleError", "NotFiniteError"), _ERRORS),
    **dict.fromkeys(("ForwardModel", "ForwardModelSpec", "ForwardRun"), _FORWARD),
    **dict.fromkeys(("ParameterInfo", "SeriesInfo", "in_unit"), _FORWARD),
}

__all__ = [
    "AsyncClient",
    "Client",
    "ConflictError",
    "ConnectionFailedError",
    "GeoswarmError",
    "HttpError",
    "InvalidProblemError",
    "JobFailedError",
    "NotFoundError",
    "ServerError",
    "UnauthorizedError",
    "WaitTimeoutError",
    "ForwardModelSpec",
    "ForwardModel",
    "ForwardRun",
    "FloatArray",
    "ParameterInfo",
    "SeriesInfo",
    "in_unit",
    "ForwardError",
    "DivergedError",
    "NotFiniteError",
    "InfeasibleError",
    "BadOutputError",
]


def __getattr__(name: str) -> Any:
    if name in __all__:
        return getattr(import_module(_ELSEWHERE.get(name, "geoswarm.client")), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return sorted([*globals(), *__all__])
