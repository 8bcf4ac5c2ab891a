"""Calibrations from Python: ``docs/python.md``. Everything here is imported from ``geoswarm``.

=============  ================================================================================================
``sections``   sections of a problem: parameter, series, observation
``functions``  how a function reaches the processes that call it
``problems``   from a function or a problem, and options, to a checked problem
``calibrate``  runs a calibration
``evaluate``   makes one forward calculation
``folder``     writes results
``result``     what a calibration has found
``runs``       its history as columns
``plot``       measured and calculated series
``outlook``    what comes next, from a calibration in this process: predictions, and the worth of further tests
=============  ================================================================================================
"""

from __future__ import annotations

from geoswarm.calibration.calibrate import calibrate
from geoswarm.calibration.evaluate import Evaluated, evaluate
from geoswarm.calibration.functions import InProcessWarning
from geoswarm.calibration.problems import DEFAULT_STOPPING, problem
from geoswarm.calibration.result import Result
from geoswarm.calibration.runs import Runs
from geoswarm.calibration.sections import fixed, free, linked, observed, series
from geoswarm.solver.errors import ProblemError, SolverError, WorkerLostError
from geoswarm.solver.problem import Problem, load_problem

__all__ = [
    "DEFAULT_STOPPING",
    "Evaluated",
    "InProcessWarning",
    "Problem",
    "ProblemError",
    "Result",
    "Runs",
    "SolverError",
    "WorkerLostError",
    "calibrate",
    "evaluate",
    "fixed",
    "free",
    "linked",
    "load_problem",
    "observed",
    "problem",
    "series",
]
