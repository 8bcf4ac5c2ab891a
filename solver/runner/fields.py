"""A forward run for its fields: what a plot of the body shows, where a calibration keeps only observed points."""

from __future__ import annotations

import time

import numpy as np

from geoswarm.solver.arrays import FloatArray
from geoswarm.solver.calibration import Calibration, Evaluation
from geoswarm.solver.errors import ForwardError
from geoswarm.solver.forward.continuum.fields import body_of, displacement_fields

__all__ = ["evaluate_fields"]


def evaluate_fields(calibration: Calibration, parameters: FloatArray, part: str) -> Evaluation:
    """Calculate the displacements of a body; a failure is in the returned evaluation.

    Parameters
    ----------
    parameters
        Natural values of the free parameters, shape (d,).
    part
        Name of the part of a combined model; empty for a model that is none.

    Returns
    -------
    Evaluation
        Its responses are the displacements at the end of each phase, flattened to (2 n,), m; no objective.
    """
    began = time.perf_counter()
    found = body_of(calibration.problem.model, part, calibration.problem.values(parameters.tolist()))
    try:
        if found is None:
            raise ForwardError(f"the forward model has no body {part!r}")
        with np.errstate(all="ignore"):
            fields = displacement_fields(*found)
    except ForwardError as error:
        reason, message = error.reason, str(error)
    except MemoryError:
        reason, message = "killed_memory", "the forward model ran out of memory"
    else:
        flat = {name: displacement.ravel() for name, displacement in fields.items()}
        return Evaluation(parameters, None, {}, flat, None, None, time.perf_counter() - began)
    return Evaluation(parameters, None, {}, {}, reason, message, time.perf_counter() - began)
