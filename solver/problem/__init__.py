"""What a user asks for: the problem file of YAML or JSON, checked and ready to be calibrated."""

from solver.problem.assembly import load_problem, parse_problem
from solver.problem.draft import Draft, LocatedIssue, draft_of_document, draft_of_text
from solver.problem.follow_ups import (
    FollowUpMethod,
    GlobalMethod,
    MorrisMethod,
    ProfileMethod,
    SensitivityMethod,
    SobolMethod,
)
from solver.problem.measurements import Measurements, read_measurements
from solver.problem.observations import Observation, Points
from solver.problem.parameters import FixedParameter, FreeParameter, LinkedParameter, Parameter
from solver.problem.problem import Problem
from solver.problem.reading import MAX_BYTES, read_document
from solver.problem.schema import problem_schema
from solver.problem.sections import MonteCarloMethod, ParticleSwarmMethod, Stopping
from solver.problem.tables import MAX_TABLE_BYTES, TableError
from solver.problem.writing import problem_yaml

__all__ = [
    "MAX_BYTES",
    "MAX_TABLE_BYTES",
    "Draft",
    "FixedParameter",
    "FollowUpMethod",
    "FreeParameter",
    "GlobalMethod",
    "LinkedParameter",
    "LocatedIssue",
    "Measurements",
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
    "TableError",
    "draft_of_document",
    "draft_of_text",
    "load_problem",
    "parse_problem",
    "problem_schema",
    "problem_yaml",
    "read_document",
    "read_measurements",
]
