"""What a user asks for: the problem file of YAML or JSON, checked and ready to be calibrated."""

from solver.problem.assembly import load_problem, parse_problem
from solver.problem.follow_ups import (
    FollowUpMethod,
    GlobalMethod,
    MorrisMethod,
    ProfileMethod,
    SensitivityMethod,
    SobolMethod,
)
from solver.problem.observations import Observation, Points
from solver.problem.parameters import FixedParameter, FreeParameter, LinkedParameter, Parameter
from solver.problem.problem import Problem
from solver.problem.reading import MAX_BYTES, read_document
from solver.problem.schema import problem_schema
from solver.problem.sections import MonteCarloMethod, ParticleSwarmMethod, Stopping
from solver.problem.tables import MAX_TABLE_BYTES

__all__ = [
    "MAX_BYTES",
    "MAX_TABLE_BYTES",
    "FixedParameter",
    "FollowUpMethod",
    "FreeParameter",
    "GlobalMethod",
    "LinkedParameter",
    "MonteCarloMethod",
    "MorrisMethod",
    "Observation",
    "Parameter",
    "ParticleSwarmMethod",
    "Points",
    "Problem",
    "ProfileMethod",
    "SensitivityMethod",
    "SobolMethod",
    "Stopping",
    "load_problem",
    "parse_problem",
    "problem_schema",
    "read_document",
]
