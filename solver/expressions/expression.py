"""A parsed expression with its value."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from geoswarm.solver.arrays import BoolArray, FloatArray
from geoswarm.solver.errors import ExpressionError
from geoswarm.solver.expressions.nodes import Evaluator, Node, array_evaluator, is_truth, names_of, scalar_evaluator
from geoswarm.solver.expressions.parser import parse_tree

__all__ = ["Expression", "parse_expression"]


class Expression:
    """What the user wrote, ready to be evaluated many times. Immutable; equal when the text is equal.

    Attributes
    ----------
    text
        As the user wrote it, without surrounding space.
    names
        Parameters and variables in it, dotted ones (``oedometer.mu_star``) included.
    is_comparison
        Whether its value is true or false (a constraint) rather than a number.
    """

    __slots__ = ("_array", "_names", "_scalar", "is_comparison", "names", "text")

    text: str
    names: frozenset[str]
    is_comparison: bool
    _names: tuple[str, ...]
    _scalar: Evaluator
    _array: Evaluator

    def __init__(self, text: str, tree: Node) -> None:
        self.text = text
        self._names = names_of(tree)
        self.names = frozenset(self._names)
        self.is_comparison = is_truth(tree)
        self._scalar = scalar_evaluator(tree)
        self._array = array_evaluator(tree)

    def value(self, values: Mapping[str, float | FloatArray]) -> float | FloatArray | bool | BoolArray:
        """Value for given names.

        Parameters
        ----------
        values
            Numbers or arrays of a common shape by name; further names are ignored.

        Returns
        -------
        A float (a bool for a comparison) if all values are numbers, else an array of the common shape. What is not
        defined is nan, what is too large inf, without a warning; a comparison with nan is false, negated or not.

        Raises
        ------
        ExpressionError
            A name has no value.
        """
        try:
            for name in self._names:
                if type(values[name]) is not float:
                    return self._general(values)
        except KeyError as error:
            raise ExpressionError(f"no value for {error.args[0]!r} in '{self.text}'") from None
        try:
            number: float | bool = self._scalar(values)
        except (ArithmeticError, ValueError):
            # 1 / 0, ln(0), exp(1000): Python's float functions raise, NumPy's give the inf or nan that is wanted.
            return self._general(values)
        return number

    def _general(self, values: Mapping[str, Any]) -> float | FloatArray | bool | BoolArray:
        arrays = {name: np.asarray(values[name], dtype=np.float64)[()] for name in self._names}
        with np.errstate(all="ignore"):
            result = self._array(arrays)
        if isinstance(result, np.ndarray):
            return result
        return bool(result) if self.is_comparison else float(result)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Expression) and other.text == self.text

    def __hash__(self) -> int:
        return hash(self.text)

    def __repr__(self) -> str:
        return f"Expression({self.text!r})"

    def __reduce__(self) -> tuple[Any, ...]:
        return parse_expression, (self.text,)


def parse_expression(text: str) -> Expression:
    """Parse an expression: ``+ - * / **``, comparisons, ``and or not``, functions, ``pi``, names.

    Precedence is that of Python; angles are radians; ``a < b < c`` means ``a < b and b < c``.

    Raises
    ------
    ExpressionError
        The message names the piece that is wrong and what could be written.
    """
    text = text.strip()
    return Expression(text, parse_tree(text))
