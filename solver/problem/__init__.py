"""What a user asks for: the problem file of YAML or JSON, checked and ready to be calibrated."""

from geoswarm.solver.problem.assembly import load_problem, parse_problem
from geoswarm.solver.problem.draft import Draft, LocatedIssue, draft_of_document, draft_of_text
from geoswarm.solver.problem.load_stages import measured_stages
from geoswarm.solver.problem.observations import Observation
from geoswarm.solver.problem.parameters import FixedParameter, FreeParameter, LinkedParameter, Parameter
from geoswarm.solver.problem.points import Points, measured_points
from geoswarm.solver.problem.problem import Problem
from geoswarm.solver.problem.schema import problem_schema
from geoswarm.solver.problem.sections import Stopping
from geoswarm.solver.problem.tables.measurements import Measurements, read_measurements
from geoswarm.solver.problem.tables.reading import MAX_TABLE_BYTES, TableError
from geoswarm.solver.problem.text.reading import MAX_BYTES, read_document
from geoswarm.solver.problem.text.writing import problem_yaml

__all__ = [
    "MAX_BYTES",
    "MAX_TABLE_BYTES",
    "Draft",
    "FixedParameter",
    "FreeParameter",
    "LinkedParameter",
    "LocatedIssue",
    "Measurements",
    "Observation",
    "Parameter",
    "Points",
    "Problem",
    "Stopping",
    "TableError",
    "draft_of_document",
    "draft_of_text",
    "load_problem",
    "measured_points",
    "measured_stages",
    "parse_problem",
    "problem_schema",
    "problem_yaml",
    "read_document",
    "read_measurements",
]
