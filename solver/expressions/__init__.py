"""Expressions that users write: linked parameters, constraints and formula series. Parsed here, never given to eval."""

from geoswarm.solver.expressions.expression import Expression, parse_expression
from geoswarm.solver.expressions.functions import CONSTANTS, FUNCTIONS
from geoswarm.solver.expressions.parser import MAX_DEPTH, MAX_LENGTH

__all__ = ["CONSTANTS", "FUNCTIONS", "MAX_DEPTH", "MAX_LENGTH", "Expression", "parse_expression"]
