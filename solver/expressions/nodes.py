"""The syntax tree of an expression and its two compilations: over floats and over arrays.

A node is a number or a truth value, never either. A comparison with NaN never holds, negated or not: ``not a > b`` is
understood as ``a <= b``, and ``a != b`` as ``a < b or a > b``. So a constraint over undefined values is not satisfied.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import reduce
from typing import Any, TypeAlias

import numpy as np

from geoswarm.solver.expressions.functions import FUNCTIONS

__all__ = [
    "Call",
    "Comparison",
    "Constant",
    "Evaluator",
    "Junction",
    "Name",
    "Negation",
    "Node",
    "Operation",
    "array_evaluator",
    "depth",
    "is_truth",
    "names_of",
    "negated",
    "scalar_evaluator",
]

Evaluator: TypeAlias = Callable[[Mapping[str, Any]], Any]


@dataclass(frozen=True, slots=True)
class Constant:
    """A number."""

    value: float


@dataclass(frozen=True, slots=True)
class Name:
    """A parameter or variable."""

    name: str


@dataclass(frozen=True, slots=True)
class Negation:
    """Minus a number."""

    operand: Node


@dataclass(frozen=True, slots=True)
class Operation:
    """``left operator right`` with one of ``+ - * / **``."""

    operator: str
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Call:
    """A function of numbers."""

    function: str
    arguments: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Comparison:
    """``left operator right`` with one of ``< <= > >= == !=``."""

    operator: str
    left: Node
    right: Node


@dataclass(frozen=True, slots=True)
class Junction:
    """All (``and``) or any (``or``) of several truth values."""

    operator: str
    operands: tuple[Node, ...]


Node: TypeAlias = Constant | Name | Negation | Operation | Call | Comparison | Junction

_OPPOSITE = {"<": ">=", "<=": ">", ">": "<=", ">=": "<", "==": "!=", "!=": "=="}


def is_truth(node: Node) -> bool:
    """Whether a node is a truth value (else a number)."""
    return isinstance(node, Comparison | Junction)


def negated(node: Comparison | Junction) -> Comparison | Junction:
    """The opposite truth value, by De Morgan's rules down to the comparisons."""
    if isinstance(node, Comparison):
        return Comparison(_OPPOSITE[node.operator], node.left, node.right)
    operands = tuple(negated(operand) for operand in node.operands if isinstance(operand, Comparison | Junction))
    return Junction("or" if node.operator == "and" else "and", operands)


def _children(node: Node) -> tuple[Node, ...]:
    match node:
        case Negation(operand):
            return (operand,)
        case Operation(_, left, right) | Comparison(_, left, right):
            return (left, right)
        case Call(_, children) | Junction(_, children):
            return children
        case _:
            return ()


def depth(node: Node) -> int:
    """Number of levels of a tree."""
    return sum(1 for _ in _levels(node))


def names_of(node: Node) -> tuple[str, ...]:
    """Names in a tree, each once."""
    return tuple({member.name: None for level in _levels(node) for member in level if isinstance(member, Name)})


def _levels(node: Node) -> Iterator[list[Node]]:
    level = [node]
    while level:
        yield level
        level = [child for parent in level for child in _children(parent)]


# Floats: Python's own operators and `math`, some ten times faster than NumPy on single numbers. They raise where NumPy
# would give inf or nan; the caller then takes the array evaluator.

_SCALAR: dict[str, Callable[[float, float], Any]] = {
    "+": operator.add,
    "-": operator.sub,
    "*": operator.mul,
    "/": operator.truediv,
    "**": math.pow,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
    "==": operator.eq,
    "!=": lambda left, right: left < right or left > right,
}


def scalar_evaluator(node: Node) -> Evaluator:
    """Compile a tree for floats into nested closures.

    Raises
    ------
    ZeroDivisionError, OverflowError, ValueError
        By the returned function, where the value is not a finite real number.
    """
    match node:
        case Constant(value):
            return lambda _: value
        case Name(name):
            return operator.itemgetter(name)
        case Negation(operand):
            inner = scalar_evaluator(operand)
            return lambda values: -inner(values)
        case Operation(symbol, left, right) | Comparison(symbol, left, right):
            return _scalar_pair(symbol, left, right)
        case Call(name, arguments):
            function = FUNCTIONS[name].scalar
            inners = tuple(scalar_evaluator(argument) for argument in arguments)
            if len(inners) == 1:
                inner = inners[0]
                return lambda values: function(inner(values))
            return lambda values: function(*[inner(values) for inner in inners])
        case Junction(symbol, operands):
            inners = tuple(scalar_evaluator(operand) for operand in operands)
            if symbol == "and":
                return lambda values: all(inner(values) for inner in inners)
            return lambda values: any(inner(values) for inner in inners)


def _scalar_pair(symbol: str, left: Node, right: Node) -> Evaluator:
    if isinstance(left, Name) and isinstance(right, Name) and symbol in (">", "<"):
        # By far the most frequent constraint: lambda_star > kappa_star.
        high, low = (left.name, right.name) if symbol == ">" else (right.name, left.name)
        return lambda values: values[high] > values[low]
    function, first, second = _SCALAR[symbol], scalar_evaluator(left), scalar_evaluator(right)
    return lambda values: function(first(values), second(values))


# Arrays: NumPy throughout, so every undefined value is inf or nan. The caller silences NumPy's warnings.

_ARRAY: dict[str, Callable[[Any, Any], Any]] = {
    "+": np.add,
    "-": np.subtract,
    "*": np.multiply,
    "/": np.divide,
    "**": np.power,
    "<": np.less,
    "<=": np.less_equal,
    ">": np.greater,
    ">=": np.greater_equal,
    "==": np.equal,
    "!=": lambda left, right: np.logical_or(np.less(left, right), np.greater(left, right)),
}


def array_evaluator(node: Node) -> Evaluator:
    """Compile a tree for arrays (and float64 numbers) into nested closures."""
    match node:
        case Constant(value):
            number = np.float64(value)
            return lambda _: number
        case Name(name):
            return operator.itemgetter(name)
        case Negation(operand):
            inner = array_evaluator(operand)
            return lambda values: np.negative(inner(values))
        case Operation(symbol, left, right) | Comparison(symbol, left, right):
            function, first, second = _ARRAY[symbol], array_evaluator(left), array_evaluator(right)
            return lambda values: function(first(values), second(values))
        case Call(name, arguments):
            several = FUNCTIONS[name].array
            inners = tuple(array_evaluator(argument) for argument in arguments)
            return lambda values: several(*[inner(values) for inner in inners])
        case Junction(symbol, operands):
            inners = tuple(array_evaluator(operand) for operand in operands)
            join = np.logical_and if symbol == "and" else np.logical_or
            return lambda values: reduce(join, [inner(values) for inner in inners])
