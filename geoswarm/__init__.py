"""Finds the parameters of geotechnical models from measurements.

:func:`calibrate` calibrates your own function (``docs/python.md``):

>>> import geoswarm as gs
>>> result = gs.calibrate(curve, parameters={"E": gs.free(1e3, 1e5)}, observations=gs.observed(x, y))  # doctest: +SKIP

and :class:`Client` talks to a service (``docs/python-client.md``):

>>> from geoswarm import Client
>>> with Client() as client:                              # doctest: +SKIP
...     job = client.submit(Path("problem.yaml"))
...     print(client.wait(job.id).parameters)

The other names are for writing forward models (``docs/plug-ins.md``). All names are loaded on first use, so importing
the package costs nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from geoswarm.calibration import (
        DEFAULT_STOPPING,
        Evaluated,
        InProcessWarning,
        Problem,
        ProblemError,
        Result,
        Runs,
        SolverError,
        WorkerLostError,
        calibrate,
        evaluate,
        fixed,
        free,
        linked,
        load_problem,
        observed,
        problem,
        series,
    )
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
        NotedResponse,
        ParameterInfo,
        SeriesInfo,
        TellsIncomplete,
        TellsUnused,
        in_unit,
    )

_CALIBRATION = (
    *("calibrate", "evaluate", "problem", "load_problem", "free", "fixed", "linked", "observed", "series"),
    *("DEFAULT_STOPPING", "Result", "Runs", "Evaluated", "Problem"),
    *("ProblemError", "SolverError", "WorkerLostError", "InProcessWarning"),
)
_FORWARD, _ERRORS = "geoswarm.solver.forward.base", "geoswarm.solver.errors"
_ELSEWHERE = {
    **dict.fromkeys(_CALIBRATION, "geoswarm.calibration"),
    "FloatArray": "geoswarm.solver.arrays",
    **dict.fromkeys(("BadOutputError", "DivergedError", "ForwardError", "InfeasibleError", "NotFiniteError"), _ERRORS),
    **dict.fromkeys(("ForwardModel", "ForwardModelSpec", "ForwardRun"), _FORWARD),
    **dict.fromkeys(("NotedResponse", "ParameterInfo", "SeriesInfo", "in_unit"), _FORWARD),
    **dict.fromkeys(("TellsIncomplete", "TellsUnused"), _FORWARD),
}

__all__ = [
    "calibrate",
    "evaluate",
    "problem",
    "load_problem",
    "free",
    "fixed",
    "linked",
    "observed",
    "series",
    "DEFAULT_STOPPING",
    "Result",
    "Runs",
    "Evaluated",
    "Problem",
    "ProblemError",
    "SolverError",
    "WorkerLostError",
    "InProcessWarning",
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
    "NotedResponse",
    "TellsIncomplete",
    "TellsUnused",
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
